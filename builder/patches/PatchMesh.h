// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh while it is simplified: faces with labels, patches with hulls, and one box tree over each of them.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "builder/Lod.h"
#include "builder/patches/BoxTree.h"
#include "builder/patches/Clip.h"

namespace clod::builder
{
constexpr std::uint32_t kNone = 0xffffffffu;

// The smaller of two resolutions, 0 = none: any other counts.
inline double smallerResolution(double a, double b)
{
	return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

struct Patch
{
	std::vector<std::uint32_t> faces;  // empty: the patch no longer exists
	std::vector<Plane> hull;           // outward; empty where all vertices lie in one plane
	Box box;
	double resolution = 0;            // smallest resolution of an edge collapsed here, 0 = none yet
	std::vector<std::uint32_t> kids;  // patches of the previous cut
};

class PatchMesh
{
public:
	// Every face in a patch of its own, hulls not yet made. The mesh is a closed oriented 2-manifold.
	explicit PatchMesh(const Mesh& mesh);

	std::vector<Vec3> positions;
	std::vector<std::array<std::uint32_t, 3>> faces;     // of a removed face: the first index is kNone
	std::vector<std::array<std::uint32_t, 3>> adjacent;  // across the edge from corner k to corner k + 1
	std::vector<Plane> planes;
	std::vector<std::vector<std::uint32_t>> star;  // faces round a vertex; empty for a removed vertex
	std::vector<std::uint32_t> label;
	std::vector<std::vector<std::uint32_t>> leaning;  // patches whose front may be covered by this face of another one
	std::vector<Patch> patches;
	BoxTree faceTree, patchTree;
	double radius = 0;  // half the diagonal of the bounding box
	std::size_t faceCount = 0;
	std::size_t patchCount = 0;

	bool isAlive(std::uint32_t face) const { return faces[face][0] != kNone; }
	TrianglePoints points(std::uint32_t face) const
	{
		const auto& f = faces[face];
		return {positions[f[0]], positions[f[1]], positions[f[2]]};
	}
	// Corner of the face that is not on its edge k.
	static int opposite(int k) { return (k + 2) % 3; }
	int cornerOf(std::uint32_t face, std::uint32_t vertex) const
	{
		const auto& f = faces[face];
		return f[0] == vertex ? 0 : f[1] == vertex ? 1 : f[2] == vertex ? 2 : -1;
	}
	int edgeTo(std::uint32_t face, std::uint32_t neighbour) const
	{
		const auto& a = adjacent[face];
		return a[0] == neighbour ? 0 : a[1] == neighbour ? 1 : a[2] == neighbour ? 2 : -1;
	}
	// How far the edge k of the face is from convex: the higher of each far corner over the other face's plane.
	double edgeHeight(std::uint32_t face, int k) const;
	// Faces of `from` go to `into`; hull, box and trees of both follow. O(faces).
	void join(std::uint32_t into, std::uint32_t from, std::vector<Plane> hull);
	void setHull(std::uint32_t patch, std::vector<Plane> hull);
	// Each face of the patch becomes one of its own, without a hull; the first inherits the kids.
	void split(std::uint32_t patch);
	// Every face becomes a patch of its own, without a hull, and inherits resolution. Kids are forgotten. O(faces).
	void dissolve();
	// Recomputes plane and box of a face after a move.
	void refreshFace(std::uint32_t face);
	void rebuildTrees();
	void lean(std::uint32_t patch, const std::vector<std::uint32_t>& supports);
	Box boxOfPatch(std::uint32_t patch) const;

private:
	void link(const Mesh& mesh);
};

Box boxOf(const TrianglePoints& t);
}  // namespace clod::builder
