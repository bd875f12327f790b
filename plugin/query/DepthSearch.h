// SPDX-License-Identifier: Zlib
// The deepest point of some triangles below a closed surface, by best-first branch and bound.
//
// depth(x) = -sd(x), the distance to the surface where x is inside. For a triangle T with corners v,
//   (1) depth on T <= min over surface faces t of max over v of dist(v, t), as the distance to a convex set is convex;
//   (1') the same for each part of T, cut along the prism over a face t: the part over t against t, the part beyond an
//   edge
//       of t against the face across that edge. Where a flat or nearly flat surface is met, (1) alone would cut cells
//       down to the depth's own size all along every edge.
//   (2) depth on T <= depth(v) + max over w of |v - w| for each v, as sd is 1-Lipschitz;
//   (3) depth(v) of a corner is reached.
// Cells are halved across their longest edge until the largest upper bound exceeds the best depth by no more than the
// accuracy asked for. (2) removes what is outside without looking at it twice.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "clod/query/SurfaceFaces.h"

namespace clod
{
struct DepthCell
{
	Triangle triangle;           // in the frame of the surface
	SignedDistance distance[3];  // of the corners
	double upper;
	std::uint32_t group;  // the surface's own: which faces may be near
	bool operator<(const DepthCell& other) const { return upper < other.upper; }
};

struct DepthBound
{
	double lower = 0, upper = 0;  // the deepest point's depth lies between
	Vec3 witness;                 // a point at depth lower, frame of the surface
	bool found = false;           // witness is set
};

struct DepthAccuracy
{
	double absolute = 0, relative = 0.01;
	std::size_t cellLimit = 4000;                             // of one search; the bounds stay true when it is met
	double enough = std::numeric_limits<double>::infinity();  // a depth that need not be known better
};

// Surface: SignedDistance signedDistance(group, point); Triangle triangle(face); faces are numbered by the surface;
//          std::uint32_t across(face, edge): the face beyond an edge, kNone where it is not known.
template <class Surface>
class DepthSearch
{
public:
	DepthSearch(Surface& surface, const DepthAccuracy& accuracy, std::vector<DepthCell>& heap)
		: m_surface(surface), m_accuracy(accuracy), m_heap(heap)
	{
		m_heap.clear();
	}

	// A depth reached already: what is not deeper by more than the accuracy is not looked at.
	void startFrom(const DepthBound& known) { m_best = known; }

	void add(std::uint32_t group, const Triangle& triangle)
	{
		DepthCell cell{triangle, {}, 0, group};
		for (int i = 0; i < 3; ++i) cell.distance[i] = m_surface.signedDistance(group, triangle.corner[i]);
		push(cell);
	}
	// What is no deeper than this need not be added.
	double threshold() const
	{
		return m_best.lower + std::max(m_accuracy.absolute, m_accuracy.relative * m_best.lower);
	}

	// Is the best depth so large that no better one is asked for?
	bool enough() const { return m_best.lower >= m_accuracy.enough; }

	DepthBound run()
	{
		std::size_t cells = 0;
		double upper = m_best.lower;
		while (!m_heap.empty())
		{
			std::pop_heap(m_heap.begin(), m_heap.end());
			const DepthCell cell = m_heap.back();
			m_heap.pop_back();
			upper = std::max(m_best.lower, cell.upper);
			if (cell.upper <= threshold() || enough() || ++cells > m_accuracy.cellLimit) break;
			halve(cell);
			upper = m_best.lower;
		}
		m_best.upper = std::max({upper, m_dropped, m_best.lower});
		return m_best;
	}

private:
	void halve(const DepthCell& cell)
	{
		int longest = 0;
		double most = -1;
		for (int i = 0; i < 3; ++i)
		{
			const double squared = lengthSquared(cell.triangle.corner[(i + 1) % 3] - cell.triangle.corner[i]);
			if (squared > most)
			{
				most = squared;
				longest = i;
			}
		}
		const int next = (longest + 1) % 3;
		const Vec3 middle = 0.5 * (cell.triangle.corner[longest] + cell.triangle.corner[next]);
		const SignedDistance distance = m_surface.signedDistance(cell.group, middle);
		for (const int replaced : {longest, next})
		{
			DepthCell half = cell;
			half.triangle.corner[replaced] = middle;
			half.distance[replaced] = distance;
			push(half);
		}
	}

	void push(DepthCell& cell)
	{
		for (int i = 0; i < 3; ++i)
		{
			if (-cell.distance[i].distance <= m_best.lower && m_best.found) continue;
			if (cell.distance[i].distance > 0) continue;
			m_best.lower = std::max(m_best.lower, -cell.distance[i].distance);
			m_best.witness = cell.triangle.corner[i];
			m_best.found = true;
		}
		cell.upper = upperBound(cell);
		if (cell.upper > threshold())
		{
			m_heap.push_back(cell);
			std::push_heap(m_heap.begin(), m_heap.end());
		}
		else
			m_dropped = std::max(m_dropped, cell.upper);
	}
	double upperBound(const DepthCell& cell)
	{
		const Vec3* corner = cell.triangle.corner;
		const double edge[3] = {length(corner[1] - corner[0]), length(corner[2] - corner[1]),
								length(corner[0] - corner[2])};
		double upper = -cell.distance[0].distance + std::max(edge[0], edge[2]);
		upper = std::min(upper, -cell.distance[1].distance + std::max(edge[0], edge[1]));
		upper = std::min(upper, -cell.distance[2].distance + std::max(edge[1], edge[2]));
		for (int i = 0; i < 3 && upper > threshold(); ++i)
		{
			const std::uint32_t face = cell.distance[i].face;
			if ((i > 0 && face == cell.distance[0].face) || (i > 1 && face == cell.distance[1].face)) continue;
			upper = std::min(upper, overPrism(cell.triangle, face, upper));
		}
		return upper;
	}

	// Upper bound (1'), never above that of (1) for the same face. Stops once it is no better than `useful`.
	double overPrism(const Triangle& cell, std::uint32_t face, double useful)
	{
		const Triangle base = m_surface.triangle(face);
		const Vec3 normal = cross(base.corner[1] - base.corner[0], base.corner[2] - base.corner[0]);
		Polygon over(cell);
		double upper = 0;
		for (int edge = 0; edge < 3; ++edge)
		{
			const Vec3 outward = cross(base.corner[(edge + 1) % 3] - base.corner[edge], normal);
			const double offset = dot(outward, base.corner[edge]);
			const Polygon beyond = Polygon(cell).clipped(outward, offset);
			over = over.clipped(-outward, -offset);
			if (beyond.count == 0) continue;
			const std::uint32_t across = m_surface.across(face, edge);
			double farthest = beyond.farthestFrom(base);
			if (across != kNone) farthest = std::min(farthest, beyond.farthestFrom(m_surface.triangle(across)));
			upper = std::max(upper, farthest);
			if (upper >= useful) return useful;
		}
		return std::max(upper, over.farthestFrom(base));
	}

	// A convex polygon: a triangle cut by at most three planes.
	struct Polygon
	{
		Polygon() = default;
		explicit Polygon(const Triangle& triangle) : count(3) { std::copy_n(triangle.corner, 3, corner); }

		// The part with dot(normal, x) >= offset.
		Polygon clipped(const Vec3& normal, double offset) const
		{
			Polygon part;
			for (int i = 0; i < count; ++i)
			{
				const Vec3 &here = corner[i], &next = corner[(i + 1) % count];
				const double side = dot(normal, here) - offset, nextSide = dot(normal, next) - offset;
				if (side >= 0) part.corner[part.count++] = here;
				if ((side < 0) != (nextSide < 0))
					part.corner[part.count++] = here + (side / (side - nextSide)) * (next - here);
			}
			return part;
		}

		double farthestFrom(const Triangle& triangle) const
		{
			double squared = 0;
			for (int i = 0; i < count; ++i) squared = std::max(squared, nearestOnTriangle(triangle, corner[i]).squared);
			return std::sqrt(squared);
		}

		Vec3 corner[8];
		int count = 0;
	};

	Surface& m_surface;
	const DepthAccuracy m_accuracy;
	std::vector<DepthCell>& m_heap;
	DepthBound m_best;
	double m_dropped = 0;
};
}  // namespace clod
