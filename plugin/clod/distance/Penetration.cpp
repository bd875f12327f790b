// SPDX-License-Identifier: Zlib
// Depth of an overlap: gathered faces near the contacts, or the whole surfaces.
#include "clod/distance/Penetration.h"

namespace clod
{
namespace
{
Transform aFromB(const RelativePose& pose)
{
	return {pose.rotation, pose.translation};
}
Transform bFromA(const RelativePose& pose)
{
	return inverse(aFromB(pose));
}
Triangle moved(const Transform& into, const Triangle& triangle)
{
	Triangle result = triangle;
	for (Vec3& corner : result) corner = into * corner;
	return result;
}

// Searches the faces of the nodes of one side; the surface is that of the other body.
class NearSearch
{
public:
	NearSearch(PenetrationScratch::Side& own, bool ownIsA, const QueryContext& context,
			   const std::vector<Contact>& near, GatheredSurface& surface, const DepthAccuracy& accuracy)
		: m_own(own.contacts),
		  m_ownIsA(ownIsA),
		  m_intoOther(ownIsA ? bFromA(context.pose) : aFromB(context.pose)),
		  m_near(near),
		  m_scratch(own),
		  m_search(surface, accuracy, own.heap)
	{
	}

	// Of the corners; those of overlapping hulls before others: most of the rest is then dropped at once. A depth is
	// known already.
	double deepestCorner(double known)
	{
		m_search.startFrom({known, 0, false});
		m_scratch.samples.clear();
		m_scratch.searched.clear();
		for (const bool overlaps : {true, false})
			for (std::uint32_t i = 0; i < m_own.slots.size() && !m_search.enough(); ++i)
				if (m_own.slots[i].overlaps == overlaps && (overlaps || !isShallow(i))) sampleCorners(i);
		return m_search.deepest();
	}
	// Of all points.
	DepthBound run(const DepthBound& known)
	{
		m_search.startFrom(known);
		const DepthSample* corner = m_scratch.samples.data();
		for (const std::uint32_t i : m_scratch.searched)
		{
			const Node& node = nodeOf(i);
			for (const Face& face : m_own.hierarchy->faces(node))
				m_search.add(i, moved(m_intoOther, triangleOf(*m_own.hierarchy, node, face)), corner[face.vertex[0]],
							 corner[face.vertex[1]], corner[face.vertex[2]]);
			corner += node.vertexCount;
		}
		return m_search.run();
	}

private:
	const Node& nodeOf(std::uint32_t slot) const { return m_own.hierarchy->node(m_own.slots[slot].node); }

	// A hull that overlaps no other is wholly outside or wholly inside: one point tells.
	bool isShallow(std::uint32_t i)
	{
		const Contact& nearest = m_near[m_own.slots[i].nearest];
		const Vec3 point = m_ownIsA ? m_intoOther * nearest.pointOnA : nearest.pointOnB;
		return m_search.sample(i, point, kNone).depth <= 0;
	}
	void sampleCorners(std::uint32_t i)
	{
		m_scratch.searched.push_back(i);
		const HullView hull = m_own.hierarchy->hull(nodeOf(i));
		std::uint32_t hint = kNone;
		for (std::uint32_t k = 0; k < hull.count; ++k)
		{
			m_scratch.samples.push_back(m_search.sample(i, m_intoOther * hull.vertex(k), hint));
			hint = m_scratch.samples.back().face;
		}
	}

	const ContactSide& m_own;
	const bool m_ownIsA;
	const Transform m_intoOther;
	const std::vector<Contact>& m_near;
	PenetrationScratch::Side& m_scratch;
	DepthSearch<GatheredSurface> m_search;
};

// The input surface of a whole body (DepthSearch.h).
class InputSurface
{
public:
	InputSurface(const Hierarchy& hierarchy, QueryStats& stats) : m_hierarchy(hierarchy), m_stats(stats) {}
	SignedDistance signedDistance(const Vec3& point)
	{
		++m_stats.pointQueries;
		return distanceToInput(m_hierarchy, point, m_stats.boxTests);
	}
	DepthSample sample(std::uint32_t, const Vec3& point, std::uint32_t)
	{
		const SignedDistance near = signedDistance(point);
		return {-near.distance, std::abs(near.distance), near.face};
	}
	static bool crossesNothing(std::uint32_t, const Triangle&) { return false; }
	static double below(std::uint32_t, const Triangle&) { return std::numeric_limits<double>::infinity(); }
	Triangle triangle(std::uint32_t face) const
	{
		return triangleOf(m_hierarchy, m_hierarchy.node(ownerOf(m_hierarchy, face)), m_hierarchy.faces()[face]);
	}
	std::uint32_t across(std::uint32_t face, int edge) const { return m_hierarchy.faces()[face].neighbour[edge]; }

private:
	const Hierarchy& m_hierarchy;
	QueryStats& m_stats;
};

// Best first over the tree of `own`: what lies in a ball is no deeper than its centre by more than its radius.
DepthBound searchWhole(const Hierarchy& own, const Transform& intoOther, InputSurface& surface, const DepthBound& known,
					   const DepthAccuracy& accuracy, PenetrationScratch& scratch)
{
	DepthSearch<InputSurface> search(surface, accuracy, scratch.a.heap);
	search.startFrom(known);
	double dropped = 0;
	const auto push = [&](std::uint32_t node)
	{
		const OrientedBox& box = own.cullBox(node);
		const Vec3 center = intoOther * centerOf(box);
		const double upper = box.radius - surface.signedDistance(center).distance;
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
		{
			const Triangle triangle = moved(intoOther, triangleOf(own, node, own.faces(node)[i]));
			const DepthSample first = search.sample(0, triangle[0], kNone),
							  second = search.sample(0, triangle[1], kNone);
			search.add(0, triangle, first, second, search.sample(0, triangle[2], kNone));
		}
	}
	if (!scratch.tree.empty()) dropped = std::max(dropped, scratch.tree.front().upper);
	DepthBound bound = search.run();
	bound.upper = std::max(bound.upper, dropped);
	return bound;
}

// Of points moved into the other body's frame, and of what is evaluated there.
DepthBound withRounding(const QueryContext& context, DepthBound bound)
{
	const double rounding = 4 * context.pose.rounding;
	return {bound.lower - rounding, bound.upper + rounding, bound.isCutShort};
}
}  // namespace

DepthBound nearPenetration(const QueryContext& context, const std::vector<Contact>& near, const DepthAccuracy& accuracy,
						   PenetrationScratch& scratch, QueryStats& stats)
{
	ContactSide &a = scratch.a.contacts, &b = scratch.b.contacts;
	gatherSides(context, near, a, b);
	GatheredSurface ofB(a, b, accuracy.enough, stats), ofA(b, a, accuracy.enough, stats);
	NearSearch inB(scratch.a, true, context, near, ofB, accuracy), inA(scratch.b, false, context, near, ofA, accuracy);
	// All corners first: the deepest point is often one of the other side.
	double deepest = inB.deepestCorner(0);
	if (deepest < accuracy.enough) deepest = inA.deepestCorner(deepest);
	if (deepest >= accuracy.enough) return {deepest, std::numeric_limits<double>::infinity(), false};
	const DepthBound bound = inA.run(inB.run({deepest, 0, false}));
	stats.depthsCutShort += bound.isCutShort ? 1 : 0;
	return withRounding(context, bound);
}

DepthBound wholePenetration(const QueryContext& context, const DepthAccuracy& accuracy, PenetrationScratch& scratch,
							QueryStats& stats)
{
	InputSurface ofA(context.a, stats), ofB(context.b, stats);
	const DepthBound boundA = searchWhole(context.a, bFromA(context.pose), ofB, {}, accuracy, scratch);
	const DepthBound bound = searchWhole(context.b, aFromB(context.pose), ofA, boundA, accuracy, scratch);
	stats.depthsCutShort += bound.isCutShort ? 1 : 0;
	return withRounding(context, bound);
}
}  // namespace clod
