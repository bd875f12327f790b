// SPDX-License-Identifier: GPL-3.0-or-later
// STL, binary and ASCII, told apart by the size a binary file must have. Words may be in capitals. Stored normals are
// ignored: the winding counts.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "builder/intake/ReadMesh.h"
#include "builder/intake/TextCursor.h"

namespace clod::builder
{
namespace
{
constexpr std::size_t kHeader = 84, kFacet = 50;

// Little-endian, as the file; so is every machine this runs on.
template <class T>
T valueAt(std::string_view bytes, std::size_t offset)
{
	T value;
	std::memcpy(&value, bytes.data() + offset, sizeof(T));
	return value;
}

bool isBinary(std::string_view bytes)
{
	return bytes.size() >= kHeader &&
		   bytes.size() == kHeader + kFacet * std::size_t(valueAt<std::uint32_t>(bytes, kHeader - 4));
}

Soup parseBinary(std::string_view bytes)
{
	Soup soup;
	for (std::size_t facet = kHeader; facet < bytes.size(); facet += kFacet)
	{
		for (std::size_t corner = 0; corner < 3; ++corner)
		{
			Vec3 v;
			for (int i = 0; i < 3; ++i)
				v[i] = double(valueAt<float>(bytes, facet + 12 * (corner + 1) + 4 * std::size_t(i)));
			soup.corners.push_back(std::uint32_t(soup.vertices.size()));
			soup.vertices.push_back(v);
		}
		soup.endPolygon();
	}
	return soup;
}

// `wanted` is of small letters, `found` in letters of either case.
bool isWord(std::string_view found, std::string_view wanted)
{
	return std::equal(found.begin(), found.end(), wanted.begin(), wanted.end(),
					  [](char f, char w) { return f == w || f == w - 'a' + 'A'; });
}

void expect(TextCursor& cursor, std::string_view wanted)
{
	const std::string_view found = cursor.wordAnywhere();
	if (!isWord(found, wanted)) cursor.refuse(fmt::format("expected '{}', found '{}'", wanted, found.substr(0, 40)));
}

void readFacet(TextCursor& cursor, Soup& soup)
{
	expect(cursor, "normal");
	for (int i = 0; i < 3; ++i) cursor.number(cursor.wordAnywhere());
	expect(cursor, "outer");
	expect(cursor, "loop");
	for (int corner = 0; corner < 3; ++corner)
	{
		expect(cursor, "vertex");
		Vec3 v;
		for (int i = 0; i < 3; ++i) v[i] = cursor.number(cursor.wordAnywhere());
		soup.corners.push_back(std::uint32_t(soup.vertices.size()));
		soup.vertices.push_back(v);
	}
	expect(cursor, "endloop");
	expect(cursor, "endfacet");
	soup.endPolygon();
}

Soup parseAscii(std::string_view text)
{
	Soup soup;
	TextCursor cursor(text);
	while (cursor.nextLineWithContent())
	{
		// The rest of this line is the solid's name.
		if (!isWord(cursor.word(), "solid")) cursor.refuse("expected 'solid'");
		if (!cursor.nextLine()) cursor.refuse("the file ends inside a solid");
		std::string_view word = cursor.wordAnywhere();
		for (; isWord(word, "facet"); word = cursor.wordAnywhere()) readFacet(cursor, soup);
		if (!isWord(word, "endsolid"))
			cursor.refuse(fmt::format("expected 'facet' or 'endsolid', found '{}'", word.substr(0, 40)));
	}
	return soup;
}
}  // namespace

Soup parseStl(std::string_view bytes)
{
	if (bytes.empty()) throw Refused(Reason::empty, "the file has no content");
	if (isBinary(bytes)) return parseBinary(bytes);
	const std::string_view text = withoutByteOrderMark(bytes);
	TextCursor start(text);
	if (start.nextLineWithContent() && isWord(start.word(), "solid")) return parseAscii(text);
	if (bytes.size() < kHeader)
		throw Refused(Reason::syntax, fmt::format("{} bytes are too few for a binary STL file", bytes.size()));
	const std::uint32_t facets = valueAt<std::uint32_t>(bytes, kHeader - 4);
	throw Refused(Reason::syntax, fmt::format("a binary STL file of {} facets has {} bytes, this one has {}", facets,
											  kHeader + kFacet * std::size_t(facets), bytes.size()));
}
}  // namespace clod::builder
