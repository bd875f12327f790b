// SPDX-License-Identifier: Zlib
// What one query prepares once: the two hierarchies, the relative pose with its rounding, and the scale of the pair.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "clod/Export.h"
#include "clod/collide/BoxSeparation.h"
#include "clod/query/Query.h"
#include "clod/query/TraversalTables.h"

namespace clod
{
// About as large as a piece of the finest level.
inline double pieceOf(const Hierarchy& hierarchy)
{
	return hierarchy.originRadius() / std::sqrt(double(std::max(1U, hierarchy.levels()[0].nodeCount)));
}

struct QueryContext
{
	CLOD_API QueryContext(const Hierarchy& hierarchyA, const Hierarchy& hierarchyB, const Transform& aFromB,
						  const Sweep& motion = {});

	const Hierarchy& a;
	const Hierarchy& b;
	const TraversalTables &tablesA, &tablesB;
	double radiusA, radiusB;  // Hierarchy::originRadius
	RelativePose pose;
	Sweep sweep;
	double longestMove;  // no point of B moves farther in the step
	double size;         // radii of both bodies, their distance and the longest way in the step
	BoxFrame boxes;

	// Are the finest levels of both the input surfaces (Hierarchy::load)?
	bool hasInput() const { return !a.isCoarse() && !b.isCoarse(); }
	// cover_a + cover_b of two nodes.
	double coversOf(std::uint32_t nodeA, std::uint32_t nodeB) const
	{
		return double(a.node(nodeA).cover) + double(b.node(nodeB).cover);
	}
};

// Of one node and up to kBoxLanes of the other body: of A or not. Room for kBoxLanes. The bits of those within `limit`.
inline std::uint32_t boxSeparations(const QueryContext& context, bool areOfA, std::uint32_t other,
									const std::uint32_t* nodes, std::uint32_t count, float* separations,
									float limit = std::numeric_limits<float>::infinity())
{
	const Hierarchy &side = areOfA ? context.a : context.b, &otherSide = areOfA ? context.b : context.a;
	const OrientedBox* boxes[kBoxLanes];
	for (std::uint32_t i = 0; i < count; ++i) boxes[i] = &side.cullBox(nodes[i]);
	return boxSeparations(context.boxes, otherSide.cullBox(other), !areOfA, boxes, count, separations, limit);
}

// Hull distance from the canonical start: a function of the two nodes and the pose, whatever was cached. Stops as soon
// as lower > stopAbove.
CLOD_API HullDistance canonicalDistance(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove);

// As far as a contact needs it: where nothing moves, a distance beyond the tolerance is not known any better.
inline HullDistance canonicalContact(const QueryContext& context, std::uint32_t a, std::uint32_t b, double tolerance)
{
	return canonicalDistance(context, a, b,
							 context.longestMove > 0 ? std::numeric_limits<double>::infinity() : tolerance);
}

// Whether the two hulls are apart as they are, by the same evaluation (HullDistance.h: whatever it stops above).
inline bool canonicallyApart(const QueryContext& context, std::uint32_t a, std::uint32_t b)
{
	return canonicalDistance(context, a, b, 0).lower > 0;
}

// Bounds of the distance of two hulls at any time of the step, from the canonical start; the direction the lower one
// was found along. The upper one is of hulls that move with their centre and spread by turning. Stops as soon as lower
// > stopAbove or upper <= stopBelow. Without a sweep those of the hull distance itself.
struct SweptBound
{
	double lower, upper;
	Vec3 normal;
	NearCorners corners;  // that come so near
	bool hasPoints;       // not where it stopped above: lower may still be stopAbove then, by rounding
};
SweptBound canonicalSweptBound(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove,
							   double stopBelow = -std::numeric_limits<double>::infinity());
// The same from the support planes across one direction: any direction gives a true bound.
double sweptSeparationAlong(const QueryContext& context, std::uint32_t a, std::uint32_t b, const Vec3& direction);
// How near the hulls of such corners come: an upper bound of what canonicalSweptBound calls lower.
double sweptCornerDistance(const QueryContext& context, std::uint32_t a, std::uint32_t b, const NearCorners& corners);
}  // namespace clod
