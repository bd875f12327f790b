// SPDX-License-Identifier: GPL-3.0-or-later
// Geomview OFF as text, with optional normals and colours (NOFF, COFF, CNOFF), which are skipped.
#include <fmt/format.h>

#include "builder/intake/ReadMesh.h"
#include "builder/intake/TextCursor.h"

namespace clod::builder
{
namespace
{
// A count needs at least `bytesEach` bytes an item in what is left of the file.
std::size_t readCount(TextCursor& cursor, std::size_t bytesEach)
{
	const long long count = cursor.integer(cursor.word());
	if (count < 0 || std::size_t(count) > cursor.rest().size() / bytesEach + 1)
		cursor.refuse(fmt::format("the file is too short for the count {}", count));
	return std::size_t(count);
}

void readVertex(TextCursor& cursor, std::size_t index, Soup& soup)
{
	if (!cursor.nextLineWithContent()) cursor.refuse(fmt::format("the file ends before vertex {}", index));
	Vec3 v;
	for (int i = 0; i < 3; ++i) v[i] = cursor.number(cursor.word());
	soup.vertices.push_back(v);
}

void readFace(TextCursor& cursor, std::size_t index, Soup& soup)
{
	if (!cursor.nextLineWithContent()) cursor.refuse(fmt::format("the file ends before face {}", index));
	const long long corners = cursor.integer(cursor.word());
	if (corners < 3) cursor.refuse(fmt::format("face {} has {} corners", index, corners));
	for (long long i = 0; i < corners; ++i)
	{
		const std::string_view word = cursor.word();
		if (word.empty()) cursor.refuse(fmt::format("face {} has fewer than {} corners", index, corners));
		soup.corners.push_back(checkedIndex(cursor.integer(word), cursor.place()));
	}
	soup.endPolygon();
}
}  // namespace

Soup parseOff(std::string_view text)
{
	TextCursor cursor(text);
	if (!cursor.nextLineWithContent()) throw Refused(Reason::empty, "the file has no content");
	const std::string_view header = cursor.word();
	if (header != "OFF" && header != "COFF" && header != "NOFF" && header != "CNOFF")
		cursor.refuse("a text OFF file starts with OFF, COFF, NOFF or CNOFF");
	TextCursor sameLine = cursor;
	const bool countsFollow = !sameLine.word().empty();
	if (!countsFollow && !cursor.nextLineWithContent()) throw Refused(Reason::empty, "the file ends after its header");
	const std::size_t vertexCount = readCount(cursor, 6);
	const std::size_t faceCount = readCount(cursor, 8);
	Soup soup;
	for (std::size_t i = 0; i < vertexCount; ++i) readVertex(cursor, i, soup);
	for (std::size_t i = 0; i < faceCount; ++i) readFace(cursor, i, soup);
	if (cursor.nextLineWithContent()) cursor.refuse("more lines than the counts announce");
	return soup;
}
}  // namespace clod::builder
