// SPDX-License-Identifier: Zlib
// Signed gap and error bound, as proved in the header.
#include "clod/query/GapCertificate.h"

#include <algorithm>
#include <limits>

namespace clod
{
namespace
{
constexpr double kUp = 1 + 1e-12;  // rounds a sum of a few terms up

double sum(float x, float y)
{
	return double(x) + double(y);
}

struct Margins
{
	double below = 0;  // m
	double reachA = 0, reachB = 0, surfA = 0, surfB = 0;
	double common = std::numeric_limits<double>::infinity();  // protrude_a + protrude_b of an overlapping pair
	bool inputOnly = true;                                    // level 0 on both sides
};

Margins marginsOf(const QueryContext& context, const std::vector<Contact>& contacts)
{
	Margins margins;
	for (const Contact& contact : contacts)
	{
		const Node &a = context.a.node(contact.nodeA), &b = context.b.node(contact.nodeB);
		margins.below = std::max({margins.below, sum(a.reach, b.surf), sum(b.reach, a.surf)});
		margins.reachA = std::max(margins.reachA, double(a.reach));
		margins.reachB = std::max(margins.reachB, double(b.reach));
		margins.surfA = std::max(margins.surfA, double(a.surf));
		margins.surfB = std::max(margins.surfB, double(b.surf));
		if (contact.upper <= 0) margins.common = std::min(margins.common, sum(a.protrude, b.protrude));
		margins.inputOnly = margins.inputOnly && a.childCount == 0 && b.childCount == 0;
	}
	return margins;
}

// The smallest protrude of the thickened hulls that hold a point (their body's frame); infinite when there is none.
double protrudeAround(const Hierarchy& hierarchy, const ContactSide& side, const Vec3& point)
{
	float coordinates[3][kVertexLanes];
	for (int k = 0; k < 3; ++k) std::fill_n(coordinates[k], kVertexLanes, float(point[k]));
	const ConvexHull single{{coordinates[0], coordinates[1], coordinates[2], 1, kVertexLanes}, {}};
	const double rounded = length(single.vertices.vertex(0) - point);
	const RelativePose same(Transform{}, length(point));
	double best = std::numeric_limits<double>::infinity();
	for (const ContactSide::Slot& slot : side.slots)
	{
		const Node& node = hierarchy.node(slot.node);
		if (node.protrude + rounded >= best || boxDistance(hierarchy.cullBox(slot.node), point) > 0) continue;
		const ConvexHull hull = contactHull(hierarchy, node);
		const Vec3 start = single.vertices.vertex(0) - hull.vertices.vertex(0);
		if (hullDistance(single, hull, same, start, 0).overlap) best = node.protrude + rounded;
	}
	return best;
}

// Upper bound of the gap from the deepest point found; see the header.
double provenHigh(const QueryContext& context, const Margins& margins, const Penetration& penetration,
				  PenetrationScratch& scratch, QueryStats& stats)
{
	constexpr double kEverything = std::numeric_limits<double>::infinity();
	const bool onA = penetration.deepestOnA;
	const double reach = onA ? margins.reachB : margins.reachA, surf = onA ? margins.surfA : margins.surfB;
	if (!penetration.found || penetration.lower <= reach + surf) return margins.common;
	ContactSide &own = onA ? scratch.a : scratch.b, &other = onA ? scratch.b : scratch.a;
	const double depth = GatheredSurface(own, other, kEverything, stats).distanceToAll(penetration.witness);
	const double protrude = protrudeAround(onA ? context.b : context.a, other, penetration.witness);
	return depth > reach + protrude ? std::min(margins.common, -(depth - reach - surf)) : margins.common;
}
}  // namespace

Gap gapBetween(double low, double high)
{
	const double value = 0.5 * (low + high);
	return {value, kUp * std::max(value - low, high - value), false};
}

Gap gapApart(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance, double largestCover)
{
	double low = tolerance - largestCover, high = std::numeric_limits<double>::infinity(), value = high;
	for (const Contact& contact : contacts)
	{
		const Node &a = context.a.node(contact.nodeA), &b = context.b.node(contact.nodeB);
		low = std::min(low, contact.lower - sum(a.cover, b.cover));
		high = std::min(high, contact.upper + sum(a.protrude, b.protrude));
		value = std::min(value, contact.upper);
	}
	return {value, kUp * std::max(value - low, high - value), false};
}

Gap gapOverlapping(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance,
				   const Penetration& penetration, PenetrationScratch& scratch, QueryStats& stats)
{
	const Margins margins = marginsOf(context, contacts);
	Gap gap;
	if (margins.inputOnly)
		gap = gapBetween(-penetration.upper, -penetration.lower);
	else
		gap =
			gapBetween(-(penetration.upper + margins.below), provenHigh(context, margins, penetration, scratch, stats));
	if (penetration.upper < tolerance) return gap;
	return {-penetration.lower, std::numeric_limits<double>::infinity(), true};
}
}  // namespace clod
