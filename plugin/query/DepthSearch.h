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
//   (3) depth(v) of a corner is reached;
//   (4) a triangle that crosses nothing of the surface is outside where one of its corners is.
// Cells are halved across their longest edge until the largest upper bound exceeds the best depth by no more than the
// accuracy asked for. (2) removes what is outside without looking at it twice.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "clod/query/SurfaceFaces.h"

namespace clod
{
// What is known of the depth at a point.
struct DepthSample
{
	double depth;        // < 0 outside
	double distance;     // from the nearest face, >= 0
	std::uint32_t face;  // that one
};

struct DepthCell
{
	Triangle triangle;      // in the frame of the surface
	DepthSample corner[3];  // at its corners
	double upper;
	std::uint32_t group;  // the surface's own: which faces may be near
	bool operator<(const DepthCell& other) const { return upper < other.upper; }
};

struct DepthBound
{
	double lower = 0, upper = 0;  // the deepest point's depth lies between; lower is that of a point met
};

struct DepthAccuracy
{
	double absolute = 0, relative = 0.01;
	std::size_t cellLimit = 4000;                             // of one search; the bounds stay true when it is met
	double enough = std::numeric_limits<double>::infinity();  // a depth that need not be known better
};

// Surface: DepthSample sample(group, point, hint); hint: a face that may be near, kNone;
//          Triangle triangle(face); faces are numbered by the surface; bool crossesNothing(group, triangle): (4), false
//          where that is not seen; std::uint32_t across(face, edge): the face beyond an edge, kNone where it is not
//          known.
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

	DepthSample sample(std::uint32_t group, const Vec3& point, std::uint32_t hint)
	{
		const DepthSample here = m_surface.sample(group, point, hint);
		m_best.lower = std::max(m_best.lower, here.depth);
		return here;
	}
	// The samples are those of its corners.
	void add(std::uint32_t group, const Triangle& triangle, const DepthSample& first, const DepthSample& second,
			 const DepthSample& third)
	{
		DepthCell cell{triangle, {first, second, third}, 0, group};
		push(cell);
	}
	// Instead of adding what is known to be no deeper. False: it is not shallow enough for that.
	bool drop(double upper)
	{
		if (upper > threshold()) return false;
		m_dropped = std::max(m_dropped, upper);
		return true;
	}
	// What is no deeper than this need not be added.
	double threshold() const
	{
		return m_best.lower + std::max(m_accuracy.absolute, m_accuracy.relative * m_best.lower);
	}

	double deepest() const { return m_best.lower; }
	// Is the largest depth such that no larger one is asked for?
	bool enough() const { return m_best.lower >= m_accuracy.enough; }

	DepthBound run()
	{
		std::size_t cells = 0;
		double undecided = 0;
		while (!m_heap.empty())
		{
			std::pop_heap(m_heap.begin(), m_heap.end());
			const DepthCell cell = m_heap.back();
			m_heap.pop_back();
			undecided = cell.upper;
			if (cell.upper <= threshold() || enough() || ++cells > m_accuracy.cellLimit) break;
			halve(cell);
			undecided = 0;
		}
		m_best.upper = std::max({m_best.upper, m_best.lower, undecided, m_dropped});
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
		const DepthSample here = sample(cell.group, middle, cell.corner[longest].face);
		for (const int replaced : {longest, next})
		{
			DepthCell half = cell;
			half.triangle.corner[replaced] = middle;
			half.corner[replaced] = here;
			push(half);
		}
	}

	void push(DepthCell& cell)
	{
		cell.upper = upperBound(cell);
		if (drop(cell.upper)) return;
		m_heap.push_back(cell);
		std::push_heap(m_heap.begin(), m_heap.end());
	}
	// Upper bound (2), for each quarter of the triangle from its best corner.
	static double nearCorners(const DepthCell& cell)
	{
		const Vec3* corner = cell.triangle.corner;
		double half[3], median[3];  // of the edge from corner i; from corner i to the middle of the opposite edge
		for (int i = 0; i < 3; ++i)
		{
			const Vec3 &next = corner[(i + 1) % 3], &last = corner[(i + 2) % 3];
			half[i] = 0.5 * length(next - corner[i]);
			median[i] = length(0.5 * (next + last) - corner[i]);
		}
		double upper = -std::numeric_limits<double>::infinity(), middle = -upper;
		for (int i = 0; i < 3; ++i)
		{
			const int next = (i + 1) % 3, last = (i + 2) % 3;
			const double own = cell.corner[i].depth + std::max(half[i], half[last]);
			const double ofNext = cell.corner[next].depth + std::max(2 * half[i], median[next]);
			const double ofLast = cell.corner[last].depth + std::max(2 * half[last], median[last]);
			upper = std::max(upper, std::min({own, ofNext, ofLast}));
			middle = std::min(middle, cell.corner[i].depth + std::max({half[i], half[last], median[i]}));
		}
		return std::max(upper, middle);
	}
	double upperBound(const DepthCell& cell)
	{
		double upper = nearCorners(cell);
		const bool isOutside =
			std::any_of(cell.corner, cell.corner + 3, [](const DepthSample& c) { return c.depth <= 0; });
		if (isOutside && upper > threshold() && m_surface.crossesNothing(cell.group, cell.triangle))
			upper = std::min(upper, 0.0);
		// (1') at a corner is no less than its distance from the nearest face.
		const double least = std::max({cell.corner[0].distance, cell.corner[1].distance, cell.corner[2].distance});
		for (int i = 0; i < 3 && upper > threshold() && least < threshold(); ++i)
		{
			const std::uint32_t face = cell.corner[i].face;
			if ((i > 0 && face == cell.corner[0].face) || (i > 1 && face == cell.corner[1].face)) continue;
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
