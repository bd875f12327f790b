// SPDX-License-Identifier: GPL-3.0-or-later
// A static binary tree of axis-aligned boxes whose boxes may change: faces of a mesh, hulls of patches.
// Built by median splits, refitted upwards until nothing changes.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "clod/collide/Vector.h"

namespace clod::builder
{
struct Box
{
	Vec3 low{1e300, 1e300, 1e300};
	Vec3 high{-1e300, -1e300, -1e300};
	void include(const Vec3& p)
	{
		for (int k = 0; k < 3; ++k)
		{
			if (p[k] < low[k]) low[k] = p[k];
			if (p[k] > high[k]) high[k] = p[k];
		}
	}
	void include(const Box& b)
	{
		for (int k = 0; k < 3; ++k)
		{
			if (b.low[k] < low[k]) low[k] = b.low[k];
			if (b.high[k] > high[k]) high[k] = b.high[k];
		}
	}
	bool isEmpty() const { return low.x > high.x; }
	bool meets(const Box& b) const
	{
		return low.x <= b.high.x && b.low.x <= high.x && low.y <= b.high.y && b.low.y <= high.y && low.z <= b.high.z &&
			   b.low.z <= high.z;
	}
	double distanceSquared(const Vec3& p) const
	{
		double sum = 0;
		for (int k = 0; k < 3; ++k)
		{
			const double gap = p[k] < low[k] ? low[k] - p[k] : p[k] > high[k] ? p[k] - high[k] : 0;
			sum += gap * gap;
		}
		return sum;
	}
	Box grownBy(double margin) const
	{
		const Vec3 m{margin, margin, margin};
		return {low - m, high + m};
	}
};

class BoxTree
{
public:
	// One leaf a box; empty boxes are never found.
	void build(const std::vector<Box>& boxes);
	void update(std::uint32_t item, const Box& box);

	// Calls visit(item) for every box that meets the query, in a fixed order; visit returns false to stop the search.
	template <class Visit>
	bool search(const Box& query, Visit&& visit) const
	{
		if (m_nodes.empty()) return true;
		std::uint32_t stack[64];
		int size = 0;
		stack[size++] = 0;
		while (size > 0)
		{
			const Node& node = m_nodes[stack[--size]];
			if (!node.box.meets(query)) continue;
			if (node.item != kInner)
			{
				if (!visit(node.item)) return false;
				continue;
			}
			stack[size++] = node.right;
			stack[size++] = std::uint32_t(&node - m_nodes.data()) + 1;
		}
		return true;
	}

	// The smallest measure(item), a squared distance from p, below limitSquared; limitSquared where there is none.
	template <class Measure>
	double nearestSquared(const Vec3& p, double limitSquared, Measure&& measure) const
	{
		if (m_nodes.empty()) return limitSquared;
		struct Entry
		{
			std::uint32_t node;
			double distance;
		};
		Entry stack[64];
		int size = 0;
		stack[size++] = {0, m_nodes[0].box.distanceSquared(p)};
		while (size > 0)
		{
			const Entry entry = stack[--size];
			if (entry.distance >= limitSquared) continue;
			const Node& node = m_nodes[entry.node];
			if (node.item != kInner)
			{
				const double d = measure(node.item);
				if (d < limitSquared) limitSquared = d;
				continue;
			}
			Entry left{entry.node + 1, m_nodes[entry.node + 1].box.distanceSquared(p)};
			Entry right{node.right, m_nodes[node.right].box.distanceSquared(p)};
			if (left.distance < right.distance) std::swap(left, right);
			stack[size++] = left;
			stack[size++] = right;
		}
		return limitSquared;
	}

private:
	static constexpr std::uint32_t kInner = 0xffffffffu;
	struct Node
	{
		Box box;
		std::uint32_t right = 0;  // the left child follows its parent
		std::uint32_t item = kInner;
		std::uint32_t parent = 0;
	};
	std::uint32_t buildRange(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
							 const std::vector<Box>& boxes);
	std::vector<Node> m_nodes;
	std::vector<std::uint32_t> m_leafOf;
};
}  // namespace clod::builder
