// SPDX-License-Identifier: GPL-3.0-or-later
// Wavefront OBJ: vertices and faces. Normals, texture coordinates, groups, materials, lines and points are skipped;
// free-form surfaces are refused, because skipping them would change the solid.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "builder/intake/ReadMesh.h"
#include "builder/intake/TextCursor.h"

namespace clod::builder
{
namespace
{
constexpr std::array<std::string_view, 17> kSkipped = {"vn",  "vt",     "vp",    "g",          "o",        "s",
													   "mg",  "l",      "p",     "usemtl",     "mtllib",   "usemap",
													   "lod", "maplib", "bevel", "shadow_obj", "trace_obj"};

void readVertex(TextCursor& cursor, Soup& soup)
{
	Vec3 v;
	for (int i = 0; i < 3; ++i)
	{
		const std::string_view word = cursor.word();
		if (word.empty()) cursor.refuse("a vertex needs three coordinates");
		v[i] = cursor.number(word);
	}
	// What may follow is a weight, or a colour.
	for (std::string_view word = cursor.word(); !word.empty(); word = cursor.word()) cursor.number(word);
	soup.vertices.push_back(v);
}

// "7", "7/1", "7//3", "7/1/3"; negative counts back from the last vertex read.
void readCorner(const TextCursor& cursor, std::string_view word, Soup& soup)
{
	const long long index = cursor.integer(word.substr(0, word.find('/')));
	const long long count = (long long)(soup.vertices.size());
	if (index == 0 || index < -count || index > kMostVertices)
		throw Refused(Reason::indexOutOfRange,
					  fmt::format("{}: vertex index {} with {} vertices before it", cursor.place(), index, count));
	soup.corners.push_back(checkedIndex(index > 0 ? index - 1 : count + index, cursor.place()));
}

void readFace(TextCursor& cursor, Soup& soup)
{
	for (std::string_view word = cursor.word(); !word.empty(); word = cursor.word())
		readCorner(cursor, word, soup);
	const std::size_t corners = soup.corners.size() - soup.polygonBegin(soup.polygonCount());
	if (corners < 3) cursor.refuse(fmt::format("a face needs three corners, this one has {}", corners));
	soup.endPolygon();
}
}  // namespace

Soup parseObj(std::string_view text)
{
	Soup soup;
	TextCursor cursor(text, TextCursor::Lines::goOnAfterBackslash);
	while (cursor.nextLineWithContent())
	{
		const std::string_view keyword = cursor.word();
		if (keyword == "v")
			readVertex(cursor, soup);
		else if (keyword == "f")
			readFace(cursor, soup);
		else if (!keyword.empty() && std::find(kSkipped.begin(), kSkipped.end(), keyword) == kSkipped.end())
			cursor.refuse(fmt::format("keyword '{}' is not one this reader knows", keyword.substr(0, 40)));
		while (!cursor.word().empty())  // what is skipped may go on, too
		{
		}
	}
	return soup;
}
}  // namespace clod::builder
