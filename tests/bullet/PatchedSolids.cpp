// SPDX-License-Identifier: GPL-3.0-or-later
// The meshes of PatchHierarchy.h, and solids made of them.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
PatchedMesh boxMesh(const Vec3& size, const std::array<int, 3>& n, int cells)
{
	PatchedMesh mesh;
	std::map<std::array<int, 3>, std::uint32_t> index;
	const auto vertex = [&](const std::array<int, 3>& at)
	{
		const auto [entry, isNew] = index.insert({at, std::uint32_t(mesh.vertices.size())});
		if (isNew)
			mesh.vertices.push_back({size.x * (double(at[0]) / n[0] - 0.5), size.y * (double(at[1]) / n[1] - 0.5),
									 size.z * (double(at[2]) / n[2] - 0.5)});
		return entry->second;
	};
	std::map<std::array<int, 4>, std::uint32_t> patches;
	for (std::size_t axis = 0; axis < 3; ++axis)
		for (int side = 0; side < 2; ++side)
		{
			const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
			for (int i = 0; i < n[u]; ++i)
				for (int j = 0; j < n[v]; ++j)
				{
					const auto corner = [&](int di, int dj)
					{
						std::array<int, 3> at{};
						at[axis] = side * n[axis];
						at[u] = i + di;
						at[v] = j + dj;
						return vertex(at);
					};
					const std::uint32_t q[4] = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
					const std::array<int, 4> key = {int(axis), side, i / cells, j / cells};
					const std::uint32_t patch = patches.insert({key, std::uint32_t(patches.size())}).first->second;
					if (side == 1)
					{
						mesh.triangles.push_back({q[0], q[1], q[2]});
						mesh.triangles.push_back({q[0], q[2], q[3]});
					}
					else
					{
						mesh.triangles.push_back({q[0], q[2], q[1]});
						mesh.triangles.push_back({q[0], q[3], q[2]});
					}
					mesh.patch.insert(mesh.patch.end(), 2, patch);
				}
		}
	mesh.wall = std::min({size.x, size.y, size.z});
	return mesh;
}

namespace
{
// Turns the mesh so that the face looks down: a ball on a corner would topple.
void layOnFace(PatchedMesh& mesh, const std::array<std::uint32_t, 3>& face)
{
	const Vec3 down = normalized(mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]);
	const Vec3 side = normalized(cross(down, Vec3{0.3, 0.5, 0.8}));
	const Mat3 rotation = {{side, -down, cross(side, -down)}};
	for (Vec3& v : mesh.vertices) v = rotation * v;
}
}  // namespace

PatchedMesh ballMesh(double radius, int steps)
{
	PatchedMesh mesh;
	const double g = 0.5 * (1 + std::sqrt(5.0));
	mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
					 {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
	mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
					  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
					  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
	for (int step = 0; step < steps; ++step)
	{
		std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
		std::vector<std::array<std::uint32_t, 3>> finer;
		for (const auto& t : mesh.triangles)
		{
			std::uint32_t m[3];
			for (std::size_t i = 0; i < 3; ++i)
			{
				const std::pair<std::uint32_t, std::uint32_t> edge = std::minmax(t[i], t[(i + 1) % 3]);
				const auto [entry, isNew] = middle.insert({edge, std::uint32_t(mesh.vertices.size())});
				if (isNew) mesh.vertices.push_back(0.5 * (mesh.vertices[edge.first] + mesh.vertices[edge.second]));
				m[i] = entry->second;
			}
			finer.push_back({t[0], m[0], m[2]});
			finer.push_back({t[1], m[1], m[0]});
			finer.push_back({t[2], m[2], m[1]});
			finer.push_back({m[0], m[1], m[2]});
		}
		mesh.triangles = finer;
	}
	for (Vec3& v : mesh.vertices) v = radius * normalized(v);
	layOnFace(mesh, mesh.triangles.back());
	mesh.patch.assign(mesh.triangles.size(), 0);
	mesh.wall = 2 * radius;
	return mesh;
}

PatchedMesh singleTriangles(PatchedMesh mesh)
{
	for (std::uint32_t i = 0; i < mesh.patch.size(); ++i) mesh.patch[i] = i;
	return mesh;
}

PatchedMesh merged(const PatchedMesh& a, const PatchedMesh& b, const Vec3& offsetOfB)
{
	PatchedMesh mesh = a;
	const auto firstVertex = std::uint32_t(a.vertices.size());
	const std::uint32_t firstPatch = *std::max_element(a.patch.begin(), a.patch.end()) + 1;
	for (const Vec3& v : b.vertices) mesh.vertices.push_back(v + offsetOfB);
	for (const auto& t : b.triangles)
		mesh.triangles.push_back({t[0] + firstVertex, t[1] + firstVertex, t[2] + firstVertex});
	for (const std::uint32_t p : b.patch) mesh.patch.push_back(p + firstPatch);
	mesh.wall = std::min(a.wall, b.wall);
	return mesh;
}

std::shared_ptr<const Hierarchy> cube()
{
	return patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1));
}

std::shared_ptr<const Hierarchy> slab()
{
	return patchHierarchy(boxMesh({10, 1, 10}, {20, 1, 20}, 2));
}
}  // namespace clod::test
