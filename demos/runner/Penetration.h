// SPDX-License-Identifier: Zlib
// How deep two closed triangle meshes are inside each other, measured without any of the plugin's code: every vertex of
// either mesh against the other's surface (nearest triangle by a tree of boxes, sign by the angle-weighted normal of
// the nearest face, edge or vertex).
//
// Based on: Baerentzen & Aanaes, "Signed Distance Computation Using the Angle Weighted Pseudonormal", TVCG 2005.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clod/collide/Vector.h"
#include "demos/models/Models.h"

namespace clod::demo
{
using Surface = ModelMesh;  // closed, counter-clockwise from outside

// Signed distance to the solid a surface bounds; negative inside.
class SignedDistance
{
public:
	explicit SignedDistance(Surface surface);
	double operator()(const Vec3& point) const;
	// A lower bound of the unsigned distance, at least half of it: much sooner found where much is equally far.
	double clearance(const Vec3& point) const;
	const Surface& surface() const { return m_surface; }

private:
	struct Box
	{
		Vec3 low, high;
		std::uint32_t first, count;  // triangles of a leaf; count 0: children are the next box and `first`
	};
	struct Nearest;
	Nearest search(const Vec3& point, double share) const;
	std::uint32_t addBox(std::uint32_t first, std::uint32_t count);
	void visit(const Vec3& point, std::uint32_t triangle, Nearest& nearest) const;
	Vec3 normalAt(const Nearest& nearest) const;
	void addNormals();

	Surface m_surface;
	std::vector<std::uint32_t> m_order;
	std::vector<Box> m_boxes;
	std::vector<Vec3> m_faceNormals, m_vertexNormals;
	std::vector<std::array<Vec3, 3>> m_edgeNormals;  // of edge (i, i+1) of each triangle
};

// Deepest vertex over a sequence of relative poses. A vertex that was d outside is not looked at again before it is d
// away from where it was then; and it is still outside where a ball clear of the other surface round its new place
// meets the one round its old place. So following all steps of a simulation costs little more than the first.
class PenetrationMeter
{
public:
	PenetrationMeter(std::shared_ptr<const SignedDistance> a, std::shared_ptr<const SignedDistance> b);
	// Depth (>= 0) of the deepest vertex of either mesh inside the other; aFromB relates the *mesh* frames.
	double depth(const Transform& aFromB);

private:
	// Where a vertex was in the other's frame when it was last looked at, and how far round it all was outside the
	// other.
	struct Look
	{
		Vec3 place;
		double clear = 0;
	};
	std::shared_ptr<const SignedDistance> m_a, m_b;
	std::vector<Look> m_looksA, m_looksB;
};
}  // namespace clod::demo
