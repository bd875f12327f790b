// SPDX-License-Identifier: Zlib
#include "clod/manifold/MovedNode.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clod
{
namespace
{
constexpr double kRounding = 1e-9;  // of a distance from a box, more than its own
constexpr std::size_t kNumbered = 2048;  // a power of two, see FeatureNumbers
constexpr std::uint32_t kMostBlocks = 16;  // of 64 nodes: of more, the tables take more than they save

// Calls each(0: a corner, 1: a polygon, 2: an edge; its box; which) for what a node of A has near: it stands still in
// its own frame.
template <class Each>
void forEachStill(const ContactSurface& surface, std::uint32_t node, const Near& near, const Each& each)
{
	const auto call = [&](std::size_t kind, const Box& box, std::uint32_t index)
	{
		if (near.holds(box)) each(kind, box, index);
	};
	const Span<std::uint32_t> vertices = surface.verticesOf(node);
	const auto placeOf = [&](std::size_t i) -> const Vec3& { return surface.vertices()[vertices[i]]; };
	for (const std::uint32_t v : vertices)
		if (surface.isCorner(v)) call(0, {surface.vertices()[v], surface.vertices()[v]}, v);
	if (near.isOfCornersOnly()) return;
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(node))
	{
		const double radius = surface.radiusOf(polygon.polygon);
		const Vec3 &center = surface.centerOf(polygon.polygon), far{radius, radius, radius};
		if (!near.holds({center - far, center + far})) continue;
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		Box box{placeOf(corners[0]), placeOf(corners[0])};
		for (const std::uint16_t corner : corners) box.add(placeOf(corner));
		call(1, box, polygon.polygon);
	}
	for (const std::uint32_t index : surface.edgesOf(node))
	{
		const SurfaceEdge& edge = surface.edges()[index];
		Box box{surface.vertices()[edge.vertex[0]], surface.vertices()[edge.vertex[0]]};
		box.add(surface.vertices()[edge.vertex[1]]);
		call(2, box, index);
	}
}

Box everywhere()
{
	constexpr double kFar = std::numeric_limits<double>::infinity();
	return {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
}

// The sides of the other box that all of a box lies beyond, as bits. Boxes that share one miss it together.
unsigned sidesBeyond(const Box& box, const Box& other)
{
	unsigned sides = 0;
	for (int axis = 0; axis < 3; ++axis)
	{
		const unsigned isBelow = box.high[axis] < other.low[axis], isAbove = box.low[axis] > other.high[axis];
		sides |= (isBelow | isAbove << 1) << 2 * axis;
	}
	return sides;
}
}  // namespace

// Is all that is near listed, by how far the box has come out of the one that features were listed for?
bool NearFeatures::holds(const Near& near) const
{
	Vec3 out;
	for (int axis = 0; axis < 3; ++axis)
		out[axis] = std::max({0.0, m_box.low[axis] - near.m_box->low[axis], near.m_box->high[axis] - m_box.high[axis]});
	const double far = std::max({out.x, out.y, out.z});
	return (near.m_ofCornersOnly || !m_ofCornersOnly) && (1 + kRounding) * (near.m_reach + far) < m_reach &&
		   (1 + kRounding) * (near.m_straight + length(out)) <= m_straight;
}

NearFeatures::OfNode NearFeatures::of(std::uint32_t node, const ContactSurface& surface, const Near& near)
{
	if (!holds(near))
	{
		m_box = *near.m_box;
		m_ofCornersOnly = near.m_ofCornersOnly;
		m_reach = (1 + 2 * kRounding) * (near.m_reach + near.m_ahead);
		m_straight = (1 + 2 * kRounding) * (near.m_straight + near.m_ahead);
		m_nodes.clear();
		m_features.clear();
	}
	const Listed& at = listed(node, surface);
	const Feature* const first = m_features.data() + at.first;
	const auto& [corners, polygons, edges] = at.counts;
	if (near.m_ofCornersOnly) return {{first, corners}, {first, 0u}, {first, 0u}};
	return {{first, corners}, {first + corners, polygons}, {first + corners + polygons, edges}};
}

const NearFeatures::Listed& NearFeatures::listed(std::uint32_t node, const ContactSurface& surface)
{
	const auto at = std::lower_bound(m_nodes.begin(), m_nodes.end(), node,
									 [](const Listed& listed, std::uint32_t wanted) { return listed.node < wanted; });
	return at != m_nodes.end() && at->node == node ? *at : *m_nodes.insert(at, list(node, surface));
}

NearFeatures::Listed NearFeatures::list(std::uint32_t node, const ContactSurface& surface)
{
	Listed listed{node, std::uint32_t(m_features.size()), {}};
	forEachStill(surface, node, Near(m_box, {m_reach, m_straight}, false, m_ofCornersOnly),
				 [&](std::size_t kind, const Box& box, std::uint32_t index)
				 {
					 m_features.push_back({box, index});
					 ++listed.counts[kind];
				 });
	return listed;
}

void FeatureNumbers::start()
{
	m_count = 0;
	if (++m_dispatch > 1) return;
	m_dispatch = 1;
	m_entries.assign(kNumbered, Entry{});
}

std::uint32_t FeatureNumbers::of(std::uint32_t level, bool isEdge, std::uint32_t index)
{
	const std::uint64_t feature = std::uint64_t(level) << 33 | std::uint64_t(isEdge) << 32 | index;
	Entry& entry = m_entries[(index + (isEdge ? kNumbered / 2 : 0)) & (kNumbered - 1)];
	if (entry.dispatch != m_dispatch || entry.feature != feature) entry = {feature, m_dispatch, next()};
	return entry.number;
}

void MovedNodes::start(const FacetQuestion& question, const std::vector<Contact>& contacts, bool isA,
					   NearFeatures* kept)
{
	m_question = &question;
	m_kept = kept;
	m_isA = isA;
	m_otherFromThis = isA ? inverse(question.aFromB) : question.aFromB;
	m_otherFromThisThen = isA ? inverse(question.aFromBThen) : question.aFromBThen;
	m_otherFromThisUnforced = isA ? inverse(question.aFromBUnforced) : question.aFromBUnforced;
	m_nodes.clear();
	for (const Contact& contact : contacts) m_nodes.push_back(isA ? contact.nodeA : contact.nodeB);
	std::sort(m_nodes.begin(), m_nodes.end());
	m_nodes.erase(std::unique(m_nodes.begin(), m_nodes.end()), m_nodes.end());
	if (m_moved.size() < m_nodes.size()) m_moved.resize(m_nodes.size());
	for (std::size_t i = 0; i < m_nodes.size(); ++i) m_moved[i].node = kNone;
	m_numbers.start();
	m_sharing.clear();
	m_near.clear();
	m_blocks = std::uint32_t((m_nodes.size() + 63) / 64);
	m_wide.assign(m_blocks, 0);
	if (m_blocks > kMostBlocks) m_blocks = 0;
}

std::uint64_t MovedNodes::displaced(double least, std::uint32_t place)
{
	if (least != std::exchange(m_least, least))
	{
		m_wide.assign(m_wide.size(), 0);
		for (std::size_t i = 0; i < m_nodes.size(); ++i)
			if (m_moved[i].node != kNone && m_moved[i].displaced >= least) m_wide[i / 64] |= std::uint64_t(1) << i % 64;
	}
	return m_wide[place / 64];
}

std::uint64_t MovedNodes::noteNear(std::uint32_t number, std::uint32_t otherBlocks, std::uint32_t otherPlace)
{
	if (otherBlocks == 0) return 0;
	const std::size_t at = std::size_t(number) * otherBlocks + otherPlace / 64;
	if (m_near.size() <= at) m_near.resize(2 * (at + 1), 0);
	return std::exchange(m_near[at], m_near[at] | std::uint64_t(1) << otherPlace % 64);
}

// The number of a corner or an edge, of which it is noted that the node has it.
std::uint32_t MovedNodes::numberOf(const MovedNode& moved, bool isEdge, std::uint32_t index)
{
	const std::uint32_t number = m_numbers.of(moved.level, isEdge, index);
	if (m_blocks == 0) return number;
	const std::size_t at = std::size_t(number) * m_blocks + moved.place / 64;
	if (m_sharing.size() <= at) m_sharing.resize(2 * (at + 1), 0);
	m_sharing[at] |= std::uint64_t(1) << moved.place % 64;
	return number;
}

MovedNode& MovedNodes::of(std::uint32_t node, const Near& near)
{
	const auto at = std::size_t(std::lower_bound(m_nodes.begin(), m_nodes.end(), node) - m_nodes.begin());
	MovedNode& moved = m_moved[at];
	if (moved.node == node) return moved;
	const ContactBody& body = m_isA ? m_question->a : m_question->b;
	moved.node = node;
	moved.place = std::uint32_t(at);
	moved.level = body.levelOf(node);
	moved.corners.clear();
	moved.edges.clear();
	moved.polygons.clear();
	const ContactSurface& surface = body.surface(moved.level);
	moved.displaced = 0;
	if (m_isA)
		listStill(moved, surface, near);
	else
	{
		move(moved, surface);
		if (!isOne()) listMoved(moved, surface, everywhere());
	}
	if (moved.displaced >= m_least) m_wide[at / 64] |= std::uint64_t(1) << at % 64;
	return moved;
}

void MovedNodes::place(const ContactSurface& surface, MovedCorner& corner) const
{
	const Vec3& own = surface.vertices()[corner.index];
	corner.now = m_otherFromThis * own;
	corner.then = m_otherFromThisThen * own;
	corner.unforced = m_otherFromThisUnforced * own;
	corner.isPlaced = true;
}

// Placed, with a box round its way.
MovedCorner MovedNodes::placed(const ContactSurface& surface, std::uint32_t vertex) const
{
	MovedCorner corner{{{}, vertex, 0}};
	place(surface, corner);
	const Vec3& now = corner.now;
	corner.box = {now, now};
	corner.box.add(now + kPathReach * (corner.then - now));
	corner.box.add(now + kPathReach * (corner.unforced - now));
	return corner;
}

Vec3 MovedNodes::upOf(const ContactSurface& surface, std::uint32_t polygon) const
{
	return m_otherFromThis.rotation * surface.planeOf(polygon).normal;
}

void MovedNodes::listStill(MovedNode& moved, const ContactSurface& surface, const Near& near)
{
	moved.displaced = 0;
	moved.box = Box::none();
	const auto add = [&](std::size_t kind, const Box& box, std::uint32_t index)
	{
		moved.box.add(box);
		if (kind == 0)
			moved.corners.push_back({{box, index, numberOf(moved, false, index)}});
		else if (kind == 1)
			moved.polygons.push_back({{box, index, m_numbers.next()}, upOf(surface, index)});
		else
			moved.edges.push_back({{box, index, numberOf(moved, true, index)}});
	};
	if (near.isAnywhere()) return forEachStill(surface, moved.node, near, add);
	const NearFeatures::OfNode listed = m_kept->of(moved.node, surface, near);
	const auto addNear = [&](std::size_t kind, const Span<NearFeatures::Feature>& features)
	{
		for (const NearFeatures::Feature& feature : features)
			if (near.holds(feature.box)) add(kind, feature.box, feature.index);
	};
	addNear(0, listed.corners);
	addNear(1, listed.polygons);
	addNear(2, listed.edges);
	if (near.mayBeInside())
		for (const std::uint32_t v : surface.verticesOf(moved.node)) moved.box.add(surface.vertices()[v]);
}

// Places the vertices.
void MovedNodes::move(MovedNode& moved, const ContactSurface& surface)
{
	double displaced = 0;
	m_corners.clear();
	for (const std::uint32_t v : surface.verticesOf(moved.node))
	{
		const MovedCorner corner = placed(surface, v);
		displaced = std::max(displaced, lengthSquared(corner.then - corner.now));
		displaced = std::max(displaced, lengthSquared(corner.unforced - corner.now));
		if (m_corners.empty()) moved.box = corner.box;
		moved.box.add(corner.box);
		m_corners.push_back(corner);
	}
	moved.displaced = std::sqrt(displaced);
}

void MovedNodes::listNear(MovedNode& moved, const Box& places)
{
	listMoved(moved, (m_isA ? m_question->a : m_question->b).surface(moved.level), places);
}

// Of the node whose vertices were placed last, the features that meet the box. All vertices of a surface of one node
// are the node's; of others an edge may go beyond the node.
void MovedNodes::listMoved(MovedNode& moved, const ContactSurface& surface, const Box& places)
{
	const bool hasAllVertices = m_corners.size() == surface.vertices().size();
	m_beyond.clear();
	for (const MovedCorner& corner : m_corners)
	{
		m_beyond.push_back(std::uint8_t(sidesBeyond(corner.box, places)));
		if (!surface.isCorner(corner.index) || m_beyond.back() != 0) continue;
		moved.corners.push_back(corner);
		moved.corners.back().number = numberOf(moved, false, corner.index);
	}
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(moved.node))
	{
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		unsigned beyond = m_beyond[corners[0]];
		for (const std::uint16_t corner : corners) beyond &= m_beyond[corner];
		if (beyond != 0) continue;
		Box box = m_corners[corners[0]].box;
		for (const std::uint16_t corner : corners) box.add(m_corners[corner].box);
		moved.polygons.push_back({{box, polygon.polygon, m_numbers.next()}, upOf(surface, polygon.polygon)});
	}
	const auto boxOf = [&](std::uint32_t vertex)
	{ return hasAllVertices ? m_corners[vertex].box : placed(surface, vertex).box; };
	for (const std::uint32_t index : surface.edgesOf(moved.node))
	{
		const SurfaceEdge& edge = surface.edges()[index];
		if (hasAllVertices && (m_beyond[edge.vertex[0]] & m_beyond[edge.vertex[1]]) != 0) continue;
		const Vec3& from = surface.vertices()[edge.vertex[0]];
		MovedEdge at;
		at.index = index;
		at.number = numberOf(moved, true, index);
		at.start = m_question->aFromB * from;
		at.thenStart = m_question->aFromBThen * from;
		at.unforcedStart = m_question->aFromBUnforced * from;
		at.direction = m_question->aFromB.rotation * edge.direction;
		at.thenDirection = m_question->aFromBThen.rotation * edge.direction;
		for (std::size_t side = 0; side < 2; ++side) at.inward[side] = m_question->aFromB.rotation * edge.inward[side];
		at.box = boxOf(edge.vertex[0]);
		at.box.add(boxOf(edge.vertex[1]));
		moved.edges.push_back(at);
	}
}
}  // namespace clod
