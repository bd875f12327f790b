// SPDX-License-Identifier: Zlib
// The deepest point of some triangles below a closed surface, by best-first branch and bound.
//
// depth(x) = -sd(x), the distance to the surface where x is inside. For a triangle T with corners v,
//   (1) depth on T <= min over surface faces t of max over v of dist(v, t), as the distance to a convex set is convex;
//   (1') the same for each part of T, cut along the prism over a face t: the part over t against t, the part beyond
//       an edge of t against the face across that edge. Where a flat or nearly flat surface is met, (1) alone would
//       cut cells down to the depth's own size all along every edge.
//   (2) depth on T <= depth(v) + max over w of |v - w| for each v, as sd is 1-Lipschitz;
//   (3) depth(v) of a corner is reached;
//   (4) a triangle that crosses nothing of the surface is outside where its corners are;
//   (5) depth on T <= max over v of how far v is below a plane that the whole surface is below.
// Cells are halved across their longest edge, or cut where the depths below two faces cross, until the largest upper
// bound exceeds the best depth by no more than the accuracy asked for. (2) removes what is outside without looking at
// it twice.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "clod/collide/ClippedPolygon.h"
#include "clod/distance/Constants.h"
#include "clod/hierarchy/InputSurface.h"

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
	double upper = 0;
	std::uint32_t face = kNone;  // (1') bounds it by what is over this face; kNone: by another part, or (2) does
	Vec3 top;                    // the point over the face that is farthest from it
	std::uint32_t group = 0;     // the surface's own: which faces may be near
	bool operator<(const DepthCell& other) const { return upper < other.upper; }
};

struct DepthBound
{
	double lower = 0, upper = 0;  // the deepest point's depth lies between; lower is that of a point met
	bool isCutShort = false;      // the limit of cells was met
};

struct DepthAccuracy
{
	double absolute = 0, relative = kDepthShare;
	std::size_t cellLimit = kDepthCells;                        // of one search; the bounds stay true when it is met
	double enough = std::numeric_limits<double>::infinity();  // a depth that need not be known better
};

// Surface: DepthSample sample(group, point, hint); hint: a face that may be near, kNone;
//          Triangle triangle(face); faces are numbered by the surface; bool crossesNothing(group, triangle): (4), false
//          where that is not seen; std::uint32_t across(face, edge): the face beyond an edge, kNone where it is not
//          known; double below(face, triangle): (5) for a plane along a face, infinity where there is none.
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
		DepthCell cell;
		cell.triangle = triangle;
		cell.corner[0] = first, cell.corner[1] = second, cell.corner[2] = third;
		cell.group = group;
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
			if (cell.upper <= threshold() || enough()) break;
			if (cells++ == m_accuracy.cellLimit)
			{
				m_best.isCutShort = true;
				break;
			}
			divide(cell);
			undecided = 0;
		}
		m_best.upper = std::max({m_best.upper, m_best.lower, undecided, m_dropped});
		return m_best;
	}

private:
	// Where another face is nearer to the point that the bound comes from, the two depths cross in a line, along which
	// the cell is cut: a ridge of equal depth has halves meet their bound only when they are as small as the accuracy.
	void divide(const DepthCell& cell)
	{
		if (cell.face == kNone) return halve(cell);
		const DepthSample here = sample(cell.group, cell.top, cell.face);
		if (drop(cell.upper)) return;
		if (here.face == cell.face) return halve(cell);
		const Triangle one = m_surface.triangle(cell.face), other = m_surface.triangle(here.face);
		const Vec3 first = normalized(normalOf(one)), second = normalized(normalOf(other));
		if (!cut(cell, first - second, dot(first, one[0]) - dot(second, other[0]))) halve(cell);
	}
	static Vec3 normalOf(const Triangle& triangle)
	{
		return cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
	}

	// Into three along a plane, unless that only scratches the cell.
	bool cut(const DepthCell& cell, const Vec3& normal, double offset)
	{
		const Triangle& corner = cell.triangle;
		double side[3], most = 0, least = 0;
		for (int i = 0; i < 3; ++i)
		{
			side[i] = dot(normal, corner[i]) - offset;
			most = std::max(most, side[i]);
			least = std::min(least, side[i]);
		}
		if (!(std::min(most, -least) > kScratch * (most - least))) return false;
		int alone = 0;
		while ((side[alone] < 0) == (side[(alone + 1) % 3] < 0) || (side[alone] < 0) == (side[(alone + 2) % 3] < 0))
			++alone;
		const int next = (alone + 1) % 3, last = (alone + 2) % 3;
		const auto crossing = [&](int to)
		{ return corner[alone] + (side[alone] / (side[alone] - side[to])) * (corner[to] - corner[alone]); };
		const Vec3 first = crossing(next), second = crossing(last);
		const DepthSample atFirst = sample(cell.group, first, cell.face),
						  atSecond = sample(cell.group, second, cell.face);
		add(cell.group, {corner[alone], first, second}, cell.corner[alone], atFirst, atSecond);
		add(cell.group, {first, corner[next], corner[last]}, atFirst, cell.corner[next], cell.corner[last]);
		add(cell.group, {first, corner[last], second}, atFirst, cell.corner[last], atSecond);
		return true;
	}

	void halve(const DepthCell& cell)
	{
		int longest = 0;
		double most = -1;
		for (int i = 0; i < 3; ++i)
		{
			const double squared = lengthSquared(cell.triangle[(i + 1) % 3] - cell.triangle[i]);
			if (squared > most)
			{
				most = squared;
				longest = i;
			}
		}
		const int next = (longest + 1) % 3;
		const Vec3 middle = 0.5 * (cell.triangle[longest] + cell.triangle[next]);
		const DepthSample here = sample(cell.group, middle, cell.corner[longest].face);
		for (const int replaced : {longest, next})
		{
			DepthCell half = cell;
			half.triangle[replaced] = middle;
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
		const Triangle& corner = cell.triangle;
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
	double upperBound(DepthCell& cell)
	{
		double upper = nearCorners(cell);
		cell.face = kNone;
		const bool isOutside =
			std::all_of(cell.corner, cell.corner + 3, [](const DepthSample& c) { return c.depth <= 0; });
		if (isOutside && upper > threshold() && m_surface.crossesNothing(cell.group, cell.triangle))
			upper = std::min(upper, 0.0);
		for (int i = 0; i < 3 && upper > threshold(); ++i)
			upper = std::min(upper, m_surface.below(cell.corner[i].face, cell.triangle));
		// (1') at a corner is no less than its distance from the nearest face.
		const double least = std::max({cell.corner[0].distance, cell.corner[1].distance, cell.corner[2].distance});
		for (int i = 0; i < 3 && upper > threshold() && least < threshold(); ++i)
		{
			const std::uint32_t face = cell.corner[i].face;
			if ((i > 0 && face == cell.corner[0].face) || (i > 1 && face == cell.corner[1].face)) continue;
			upper = std::min(upper, overPrism(cell, face, upper));
		}
		return upper;
	}

	// Upper bound (1'), never above that of (1) for the same face. Stops once it is no better than `useful`; else the
	// cell keeps what it comes from.
	double overPrism(DepthCell& cell, std::uint32_t face, double useful)
	{
		const Triangle base = m_surface.triangle(face);
		const Vec3 normal = normalOf(base);
		ClippedPolygon over(cell.triangle);
		double upper = 0;
		for (int edge = 0; edge < 3; ++edge)
		{
			const Vec3 outward = cross(base[(edge + 1) % 3] - base[edge], normal);
			const double offset = dot(outward, base[edge]);
			ClippedPolygon beyond(cell.triangle);
			clipByPlane(beyond, -outward, -offset);
			clipByPlane(over, outward, offset);
			if (beyond.count == 0) continue;
			const std::uint32_t across = m_surface.across(face, edge);
			double farthest = farthestFrom(base, beyond);
			if (across != kNone) farthest = std::min(farthest, farthestFrom(m_surface.triangle(across), beyond));
			upper = std::max(upper, farthest);
			if (upper >= useful) return useful;
		}
		Vec3 top;
		const double farthest = farthestFrom(base, over, &top);
		if (std::max(upper, farthest) >= useful) return useful;
		cell.face = farthest > upper ? face : kNone;
		cell.top = top;
		return std::max(upper, farthest);
	}

	static double farthestFrom(const Triangle& triangle, const ClippedPolygon& polygon, Vec3* which = nullptr)
	{
		double squared = 0;
		for (int i = 0; i < polygon.count; ++i)
		{
			const Vec3& corner = polygon.vertex[std::size_t(i)];
			const double here = nearestOnTriangle(triangle, corner).squared;
			if (which && here > squared) *which = corner;
			squared = std::max(squared, here);
		}
		return std::sqrt(squared);
	}

	Surface& m_surface;
	const DepthAccuracy m_accuracy;
	std::vector<DepthCell>& m_heap;
	DepthBound m_best;
	double m_dropped = 0;
};
}  // namespace clod
