// SPDX-License-Identifier: Zlib
// Depth of an overlap: gathered faces near the contacts, or the whole surfaces.
#include "clod/query/Penetration.h"

namespace clod
{
namespace
{
// Maps one body's points into the other's frame.
struct Mover
{
	Mat3 rotation;
	Vec3 translation;
	Vec3 operator()(const Vec3& p) const { return rotation * p + translation; }
	Triangle operator()(const Triangle& t) const
	{
		return {{(*this)(t.corner[0]), (*this)(t.corner[1]), (*this)(t.corner[2])}};
	}
};

Mover intoB(const RelativePose& pose)
{
	return {pose.inverseRotation, -(pose.inverseRotation * pose.translation)};
}
Mover intoA(const RelativePose& pose)
{
	return {pose.rotation, pose.translation};
}

void merge(const DepthBound& side, bool onA, Penetration& result)
{
	result.upper = std::max(result.upper, side.upper);
	if (!side.found || (result.found && side.lower <= result.lower)) return;
	result.lower = side.lower;
	result.witness = side.witness;
	result.deepestOnA = onA;
	result.found = true;
}

// Searches the faces of `own`; the surface is that of the other body.
DepthBound searchNear(const ContactSide& own, bool ownIsA, const std::vector<Contact>& contacts, const Mover& intoOther,
					  GatheredSurface& surface, DepthSearch<GatheredSurface>& search)
{
	for (std::uint32_t i = 0; i < own.slots.size() && !search.enough(); ++i)
	{
		const ContactSide::Slot& slot = own.slots[i];
		if (!slot.overlaps)
		{
			const Contact& nearest = contacts[slot.nearest];
			const Vec3 point = ownIsA ? intoOther(nearest.pointOnA) : nearest.pointOnB;
			if (surface.signedDistance(i, point).distance >= 0) continue;
		}
		const Node& node = own.hierarchy->node(slot.node);
		for (const Face& face : own.hierarchy->faces(node))
			search.add(i, intoOther(triangleOf(*own.hierarchy, node, face)));
	}
	return search.run();
}

// The input surface of a whole body (DepthSearch.h).
class InputSurface
{
public:
	InputSurface(const Hierarchy& hierarchy, QueryStats& stats) : m_hierarchy(hierarchy), m_stats(stats) {}
	SignedDistance signedDistance(std::uint32_t, const Vec3& point)
	{
		++m_stats.pointQueries;
		return distanceToInput(m_hierarchy, point, m_stats.boxTests);
	}
	Triangle triangle(std::uint32_t face) const
	{
		return triangleOf(m_hierarchy, m_hierarchy.node(ownerOf(m_hierarchy, 0, face)), m_hierarchy.faces()[face]);
	}
	std::uint32_t across(std::uint32_t face, int edge) const { return m_hierarchy.faces()[face].neighbour[edge]; }

private:
	const Hierarchy& m_hierarchy;
	QueryStats& m_stats;
};

// Best first over the tree of `own`: what lies in a ball is no deeper than its centre by more than its radius.
DepthBound searchWhole(const Hierarchy& own, const Mover& intoOther, InputSurface& surface, const DepthBound& known,
					   const DepthAccuracy& accuracy, PenetrationScratch& scratch)
{
	DepthSearch<InputSurface> search(surface, accuracy, scratch.heap);
	search.startFrom(known);
	double dropped = 0;
	const auto push = [&](std::uint32_t node)
	{
		const CullBox& box = own.cullBox(node);
		const Vec3 center = intoOther(Vec3{double(box.center[0]), double(box.center[1]), double(box.center[2])});
		const double upper = box.radius - surface.signedDistance(0, center).distance;
		if (upper <= search.threshold())
		{
			dropped = std::max(dropped, upper);
			return;
		}
		scratch.tree.push_back({upper, node});
		std::push_heap(scratch.tree.begin(), scratch.tree.end());
	};
	scratch.tree.clear();
	push(own.root());
	while (!scratch.tree.empty() && scratch.tree.front().upper > search.threshold())
	{
		const Node& node = own.node(scratch.tree.front().node);
		std::pop_heap(scratch.tree.begin(), scratch.tree.end());
		scratch.tree.pop_back();
		for (std::uint32_t i = 0; i < node.primaryChildCount; ++i) push(own.children(node)[i]);
		for (std::uint32_t i = 0; node.childCount == 0 && i < node.faceCount; ++i)
			search.add(0, intoOther(triangleOf(own, node, own.faces(node)[i])));
	}
	if (!scratch.tree.empty()) dropped = std::max(dropped, scratch.tree.front().upper);
	DepthBound bound = search.run();
	bound.upper = std::max(bound.upper, dropped);
	return bound;
}
}  // namespace

Penetration nearPenetration(const QueryContext& context, const std::vector<Contact>& contacts,
							const DepthAccuracy& accuracy, PenetrationScratch& scratch, QueryStats& stats)
{
	gatherSides(context, contacts, scratch.a, scratch.b);
	Penetration result;
	GatheredSurface ofB(scratch.a, scratch.b, accuracy.enough, stats),
		ofA(scratch.b, scratch.a, accuracy.enough, stats);
	DepthSearch<GatheredSurface> searchA(ofB, accuracy, scratch.heap);
	const DepthBound boundA = searchNear(scratch.a, true, contacts, intoB(context.pose), ofB, searchA);
	merge(boundA, true, result);
	DepthSearch<GatheredSurface> searchB(ofA, accuracy, scratch.heap);
	searchB.startFrom(boundA);
	merge(searchNear(scratch.b, false, contacts, intoA(context.pose), ofA, searchB), false, result);
	return result;
}

Penetration wholePenetration(const QueryContext& context, const DepthAccuracy& accuracy, PenetrationScratch& scratch,
							 QueryStats& stats)
{
	Penetration result;
	InputSurface ofA(context.a, stats), ofB(context.b, stats);
	const DepthBound boundA = searchWhole(context.a, intoB(context.pose), ofB, {}, accuracy, scratch);
	merge(boundA, true, result);
	merge(searchWhole(context.b, intoA(context.pose), ofA, boundA, accuracy, scratch), false, result);
	return result;
}
}  // namespace clod
