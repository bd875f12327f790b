// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/Meshes.h"

#include <array>
#include <functional>
#include <map>

namespace clod::test
{
using builder::Lod;
using builder::LodSequence;
using builder::Mesh;

namespace
{
const double kPi = std::acos(-1.0);

Vec3 rounded(const Vec3& v)
{
	return toVec3(toFloat3(v));
}

// A grid that closes on itself in both directions.
Mesh closedGrid(int columns, int rows, const std::function<Vec3(int, int)>& point)
{
	Mesh mesh;
	for (int i = 0; i < columns; ++i)
		for (int j = 0; j < rows; ++j) mesh.vertices.push_back(rounded(point(i, j)));
	const auto index = [columns, rows](int i, int j) { return std::uint32_t(i % columns * rows + j % rows); };
	for (int i = 0; i < columns; ++i)
		for (int j = 0; j < rows; ++j)
		{
			mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
			mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
		}
	return mesh;
}
}  // namespace

Mesh boxMesh(const Vec3& half, int divisions)
{
	Mesh mesh;
	std::map<std::array<int, 3>, std::uint32_t> indexOf;
	const auto vertex = [&](std::array<int, 3> g)
	{
		const auto inserted = indexOf.insert({g, std::uint32_t(mesh.vertices.size())});
		if (inserted.second)
		{
			Vec3 p;
			for (int k = 0; k < 3; ++k) p[k] = half[k] * (2.0 * g[std::size_t(k)] / divisions - 1);
			mesh.vertices.push_back(rounded(p));
		}
		return inserted.first->second;
	};
	for (int axis = 0; axis < 3; ++axis)
		for (int side = 0; side < 2; ++side)
			for (int i = 0; i < divisions; ++i)
				for (int j = 0; j < divisions; ++j)
				{
					const auto at = [&](int u, int v)
					{
						std::array<int, 3> g{};
						g[std::size_t(axis)] = side * divisions;
						g[std::size_t((axis + 1) % 3)] = side ? u : v;
						g[std::size_t((axis + 2) % 3)] = side ? v : u;
						return vertex(g);
					};
					mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
					mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
				}
	return mesh;
}

Mesh sphereMesh(double radius, int segments, int rings)
{
	Mesh mesh;
	mesh.vertices.push_back(rounded({0, radius, 0}));
	for (int j = 1; j < rings; ++j)
		for (int i = 0; i < segments; ++i)
		{
			const double a = 2 * kPi * i / segments, b = kPi * j / rings;
			mesh.vertices.push_back(rounded(
				{radius * std::sin(b) * std::cos(a), radius * std::cos(b), -radius * std::sin(b) * std::sin(a)}));
		}
	mesh.vertices.push_back(rounded({0, -radius, 0}));
	const std::uint32_t last = std::uint32_t(mesh.vertices.size() - 1);
	const auto index = [segments](int i, int j) { return std::uint32_t(1 + (j - 1) * segments + i % segments); };
	for (int i = 0; i < segments; ++i)
	{
		mesh.triangles.push_back({0, index(i, 1), index(i + 1, 1)});
		for (int j = 1; j + 1 < rings; ++j)
		{
			mesh.triangles.push_back({index(i, j), index(i, j + 1), index(i + 1, j + 1)});
			mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i + 1, j)});
		}
		mesh.triangles.push_back({index(i, rings - 1), last, index(i + 1, rings - 1)});
	}
	return mesh;
}

Mesh wrinkledTorusMesh(double ring, double tube, double wrinkle, int waves, int segments, int sides)
{
	return closedGrid(segments, sides,
					  [&](int i, int j)
					  {
						  const double a = 2 * kPi * i / segments, b = 2 * kPi * j / sides;
						  const double r = tube + wrinkle * std::cos(waves * a);
						  const double d = ring + r * std::cos(b);
						  return Vec3{d * std::cos(a), r * std::sin(b), -d * std::sin(a)};
					  });
}

Mesh torusMesh(double ring, double tube, int segments, int sides)
{
	return wrinkledTorusMesh(ring, tube, 0, 1, segments, sides);
}

Lod trianglePatches(const Mesh& mesh)
{
	Lod lod;
	lod.mesh = mesh;
	lod.patchCount = std::uint32_t(mesh.triangles.size());
	for (std::uint32_t i = 0; i < lod.patchCount; ++i) lod.patchOfTriangle.push_back(i);
	lod.patchResolution.assign(lod.patchCount, 0);
	return lod;
}

Lod quadPatches(const Mesh& mesh)
{
	Lod lod = trianglePatches(mesh);
	for (std::uint32_t& patch : lod.patchOfTriangle) patch /= 2;
	lod.patchCount = (lod.patchCount + 1) / 2;
	lod.patchResolution.resize(lod.patchCount);
	return lod;
}

LodSequence torusLods(double ring, double tube, int segments, int sides, int levels)
{
	LodSequence sequence;
	sequence.lods.push_back(trianglePatches(torusMesh(ring, tube, segments, sides)));
	for (int k = 1; k < levels; ++k)
	{
		const int columns = segments >> k, rows = sides >> k;
		Lod lod = quadPatches(torusMesh(ring, tube, columns, rows));
		lod.patchResolution.assign(lod.patchCount, columns / (2 * kPi * (ring + tube)));
		// Labels: each quad covers two by two of the level below; level 0's patches are triangles.
		const Lod& below = sequence.lods.back();
		const int perQuad = k == 1 ? 2 : 1;
		for (std::uint32_t p = 0; p < below.patchCount; ++p)
		{
			const int quad = int(p) / perQuad, i = quad / (2 * rows), j = quad % (2 * rows);
			lod.patchOfChild.push_back(std::uint32_t(i / 2 * rows + j / 2));
		}
		sequence.lods.push_back(lod);
	}
	return sequence;
}
}  // namespace clod::test
