// SPDX-License-Identifier: GPL-3.0-or-later
// A static tree of boxes over triangles: nearest triangle, box overlap, rays, and the signed distance to a closed
// solid.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "builder/Lod.h"
#include "builder/assemble/Geometry.h"

namespace clod::builder
{
class TriangleTree
{
public:
	struct Nearest
	{
		std::uint32_t triangle = kNone;
		double distanceSquared = std::numeric_limits<double>::infinity();
		ClosestPoint closest;
	};

	explicit TriangleTree(const Mesh& mesh);

	const Triangle& triangle(std::uint32_t i) const { return m_triangles[i]; }
	std::size_t size() const { return m_triangles.size(); }

	// Nearest of the triangles for which accept(index) is true, nearer than sqrt(limitSquared).
	template <class Accept>
	Nearest nearest(const Vec3& p, const Accept& accept, double limitSquared) const
	{
		Nearest best;
		best.distanceSquared = limitSquared;
		struct Waiting
		{
			std::uint32_t node;
			double distanceSquared;
		} stack[64];
		int top = 0;
		stack[top++] = {0, distanceSquared(p, m_nodes[0].box)};
		while (top > 0)
		{
			const Waiting next = stack[--top];
			if (next.distanceSquared >= best.distanceSquared) continue;
			const TreeNode& node = m_nodes[next.node];
			if (node.count > 0)
			{
				for (std::uint32_t k = node.first; k < node.first + node.count; ++k) visit(p, m_order[k], accept, best);
				continue;
			}
			Waiting near{node.first, distanceSquared(p, m_nodes[node.first].box)};
			Waiting far{node.first + 1, distanceSquared(p, m_nodes[node.first + 1].box)};
			if (far.distanceSquared < near.distanceSquared) std::swap(near, far);
			if (far.distanceSquared < best.distanceSquared) stack[top++] = far;
			if (near.distanceSquared < best.distanceSquared) stack[top++] = near;
		}
		return best;
	}
	Nearest nearest(const Vec3& p) const
	{
		return nearest(
			p, [](std::uint32_t) { return true; }, std::numeric_limits<double>::infinity());
	}

	// Calls visitor(index) for every triangle whose box overlaps b, until it returns false; says whether none did.
	template <class Visitor>
	bool forEachIn(const AxisBox& b, const Visitor& visitor) const
	{
		std::uint32_t stack[64];
		int top = 0;
		stack[top++] = 0;
		while (top > 0)
		{
			const TreeNode& node = m_nodes[stack[--top]];
			if (!overlaps(node.box, b)) continue;
			if (node.count == 0)
			{
				stack[top++] = node.first + 1;
				stack[top++] = node.first;
				continue;
			}
			for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
				if (overlaps(boxOf(m_triangles[m_order[k]]), b) && !visitor(m_order[k])) return false;
		}
		return true;
	}

	// Distance along the unit direction from a point on or in the solid to the nearest crossing from inside to outside,
	// at least `from` away; infinity without one.
	double exitDistance(const Vec3& origin, const Vec3& direction, double from) const;

private:
	struct TreeNode
	{
		AxisBox box;
		std::uint32_t first = 0;  // triangle (leaf) or left child; the right one follows it
		std::uint32_t count = 0;  // triangles of a leaf, 0 for an inner node
	};
	template <class Accept>
	void visit(const Vec3& p, std::uint32_t index, const Accept& accept, Nearest& best) const
	{
		if (!accept(index)) return;
		const ClosestPoint closest = closestPoint(p, m_triangles[index]);
		const double d = lengthSquared(p - closest.point);
		if (d < best.distanceSquared || (d == best.distanceSquared && index < best.triangle))
			best = {index, d, closest};
	}
	void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);

	std::vector<Triangle> m_triangles;
	std::vector<std::uint32_t> m_order;
	std::vector<TreeNode> m_nodes;
};

// Signed distance to the solid bounded by a closed mesh, by angle-weighted pseudonormals (Baerentzen & Aanaes 2005).
class Solid
{
public:
	explicit Solid(const Mesh& mesh);
	const TriangleTree& tree() const { return m_tree; }
	// Negative inside; `triangle` receives the nearest one.
	double signedDistance(const Vec3& p, std::uint32_t& triangle) const;
	double signedDistance(const Vec3& p) const
	{
		std::uint32_t triangle;
		return signedDistance(p, triangle);
	}
	// The pseudonormal where the nearest point lies; not of unit length.
	const Vec3& normal(const TriangleTree::Nearest& nearest) const
	{
		return m_normals[nearest.triangle][std::size_t(nearest.closest.feature)];
	}
	double distance(const Vec3& p) const { return std::max(0.0, signedDistance(p)); }

private:
	TriangleTree m_tree;
	std::vector<std::array<Vec3, 7>> m_normals;  // per triangle, in the order of Feature
};

// For triangle i and edge e (from corner e to the next): the triangle on the other side.
std::vector<std::array<std::uint32_t, 3>> triangleNeighbours(const Mesh& mesh);
}  // namespace clod::builder
