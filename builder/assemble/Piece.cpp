// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Piece.h"

#include "builder/assemble/VisitMarks.h"

namespace clod::builder
{
Triangle childTriangle(const Triangle& t, std::uint32_t k)
{
	const Vec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
	switch (k)
	{
		case 0:
			return {t.a, ab, ca};
		case 1:
			return {ab, t.b, bc};
		case 2:
			return {ca, bc, t.c};
		default:
			return {ab, bc, ca};
	}
}

Triangle pieceTriangle(const Triangle& face, const Piece& piece)
{
	Triangle t = face;
	for (std::uint32_t count = Piece::kCodes / 4, rest = piece.first; count >= piece.count; count /= 4)
	{
		t = childTriangle(t, rest / count);
		rest %= count;
	}
	return t;
}

Territory territoryOf(const std::vector<Piece>& pieces, const Mesh& input)
{
	thread_local VisitMarks seen;
	thread_local std::vector<std::uint32_t> cornerOf;
	seen.restart(input.vertices.size());
	cornerOf.resize(input.vertices.size());
	Territory result;
	const auto added = [&result](const Vec3& p)
	{
		result.corners.push_back(p);
		return std::uint32_t(result.corners.size() - 1);
	};
	result.triangles.reserve(pieces.size());
	for (const Piece& piece : pieces)
	{
		const auto& t = input.triangles[piece.face];
		if (piece.count == Piece::kCodes)
		{
			for (const std::uint32_t v : t)
				if (seen.add(v)) cornerOf[v] = added(input.vertices[v]);
			result.triangles.push_back({cornerOf[t[0]], cornerOf[t[1]], cornerOf[t[2]]});
			continue;
		}
		const Triangle part = pieceTriangle({input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]}, piece);
		const std::uint32_t a = added(part.a), b = added(part.b), c = added(part.c);
		result.triangles.push_back({a, b, c});
	}
	return result;
}
}  // namespace clod::builder
