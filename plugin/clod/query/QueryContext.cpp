// SPDX-License-Identifier: Zlib
#include "clod/query/QueryContext.h"

#include <algorithm>

namespace clod
{
QueryContext::QueryContext(const Hierarchy& hierarchyA, const Hierarchy& hierarchyB, const Transform& aFromB,
						   const Sweep& motion)
	: a(hierarchyA),
	  b(hierarchyB),
	  tablesA(hierarchyA.derived<TraversalTables>()),
	  tablesB(hierarchyB.derived<TraversalTables>()),
	  radiusA(hierarchyA.originRadius()),
	  radiusB(hierarchyB.originRadius()),
	  pose(aFromB, std::max(radiusA, radiusB)),
	  sweep(motion),
	  longestMove(length(sweep.of(aFromB.translation)) + length(sweep.angular) * radiusB),
	  size(radiusA + radiusB + length(aFromB.translation) + longestMove),
	  boxes(pose, sweep, size)
{
}

HullDistance canonicalDistance(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove)
{
	const Vec3 start = centerOf(context.a.cullBox(a)) - context.pose.apply(centerOf(context.b.cullBox(b)));
	return hullDistance(contactHull(context.a, context.a.node(a)), contactHull(context.b, context.b.node(b)),
						context.pose, start, stopAbove);
}

namespace
{
// Where node b of body B is and how it moves in the step.
struct MovingNode
{
	Vec3 center, move;
	double spread;  // no point's displacement differs from `move` by more
};
MovingNode movingNode(const QueryContext& context, std::uint32_t b)
{
	const OrientedBox& box = context.b.cullBox(b);
	const Vec3 center = context.pose.apply(centerOf(box));
	if (!context.boxes.moves) return {center, Vec3{}, 0};
	return {center, context.sweep.of(center), length(context.sweep.angular) * double(box.radius)};
}
}  // namespace

SweptBound canonicalSweptBound(const QueryContext& context, std::uint32_t a, std::uint32_t b, double stopAbove,
							   double stopBelow)
{
	const MovingNode moving = movingNode(context, b);
	const Vec3 start = centerOf(context.a.cullBox(a)) - moving.center;
	const HullDistance distance =
		hullDistance(contactHull(context.a, context.a.node(a)), contactHull(context.b, context.b.node(b)), context.pose,
					 start, stopAbove + moving.spread, moving.move, stopBelow + moving.spread);
	return {distance.lower - moving.spread, distance.upper - moving.spread, distance.normal, distance.corners,
			!distance.stoppedAbove};
}

double sweptSeparationAlong(const QueryContext& context, std::uint32_t a, std::uint32_t b, const Vec3& direction)
{
	const MovingNode moving = movingNode(context, b);
	return separationAlong(contactHull(context.a, context.a.node(a)), contactHull(context.b, context.b.node(b)),
						   context.pose, direction, moving.move) -
		   moving.spread;
}

double sweptCornerDistance(const QueryContext& context, std::uint32_t a, std::uint32_t b, const NearCorners& corners)
{
	const MovingNode moving = movingNode(context, b);
	const Vec3 between = betweenCorners(contactHull(context.a, context.a.node(a)), contactHull(context.b, context.b.node(b)),
										context.pose, corners, moving.move);
	// What has corners at the end of the way goes no farther.
	const double apart = corners.haveMoved() ? length(between) : distanceToSegment(-between, moving.move);
	return apart + context.pose.rounding - moving.spread;
}
}  // namespace clod
