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
constexpr std::size_t kNumbered = 2048;  // a power of two, see FeatureNumbers
constexpr std::uint32_t kMostBlocks = 16;  // of 64 nodes: of more, the tables take more than they save

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

void MovedNodes::start(const FacetQuestion& question, const std::vector<Contact>& contacts, bool isA)
{
	m_question = &question;
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
	m_wide.assign(m_blocks, Wide{});
	if (m_blocks > kMostBlocks) m_blocks = 0;
}

std::uint64_t MovedNodes::displaced(double least, std::uint32_t place)
{
	Wide& wide = m_wide[place / 64];
	if (wide.least == least) return wide.nodes;
	wide = {least, 0};
	const std::size_t first = place / 64 * 64, end = std::min(first + 64, m_nodes.size());
	for (std::size_t i = first; i < end; ++i)
		if (m_moved[i].node != kNone && m_moved[i].displaced >= least) wide.nodes |= std::uint64_t(1) << i % 64;
	return wide.nodes;
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
	if (Wide& wide = m_wide[at / 64]; moved.displaced >= wide.least) wide.nodes |= std::uint64_t(1) << at % 64;
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

void MovedNodes::place(const ContactSurface& surface, MovedEdge& edge) const
{
	const SurfaceEdge& own = surface.edges()[edge.index];
	const Vec3& from = surface.vertices()[own.vertex[0]];
	edge.start = m_otherFromThis * from;
	edge.thenStart = m_otherFromThisThen * from;
	edge.unforcedStart = m_otherFromThisUnforced * from;
	edge.direction = m_otherFromThis.rotation * own.direction;
	edge.thenDirection = m_otherFromThisThen.rotation * own.direction;
	for (std::size_t side = 0; side < 2; ++side) edge.inward[side] = m_otherFromThis.rotation * own.inward[side];
	edge.isPlaced = true;
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

// A's stand still in their own frame.
void MovedNodes::listStill(MovedNode& moved, const ContactSurface& surface, const Near& near)
{
	moved.box = Box::none();
	const auto isNear = [&](const Box& box)
	{
		const bool holds = near.holds(box);
		if (holds) moved.box.add(box);
		return holds;
	};
	const Span<std::uint32_t> vertices = surface.verticesOf(moved.node);
	const Vec3* const at = surface.vertices().data();
	for (const std::uint32_t v : vertices)
	{
		const Box box{at[v], at[v]};
		if (surface.isCorner(v) && isNear(box)) moved.corners.push_back({{box, v, numberOf(moved, false, v)}});
	}
	if (near.mayBeInside())
		for (const std::uint32_t v : vertices) moved.box.add(at[v]);
	if (near.isOfCornersOnly()) return;
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(moved.node))
	{
		const std::uint32_t index = polygon.polygon;
		const double radius = surface.radiusOf(index);
		const Vec3 &center = surface.centerOf(index), far{radius, radius, radius};
		if (!near.holds({center - far, center + far})) continue;
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		Box box{at[vertices[corners[0]]], at[vertices[corners[0]]]};
		for (std::size_t i = 1; i < corners.size; ++i) box.add(at[vertices[corners[i]]]);
		if (isNear(box)) moved.polygons.push_back({{box, index, m_numbers.next()}, upOf(surface, index)});
	}
	for (const std::uint32_t index : surface.edgesOf(moved.node))
	{
		const auto& [from, to] = surface.edges()[index].vertex;
		Box box{at[from], at[from]};
		box.add(at[to]);
		if (isNear(box)) moved.edges.push_back({{box, index, numberOf(moved, true, index)}});
	}
}

// Places the vertices.
void MovedNodes::move(MovedNode& moved, const ContactSurface& surface)
{
	double displaced = 0;
	moved.box = Box::none();
	m_corners.clear();
	for (const std::uint32_t v : surface.verticesOf(moved.node))
	{
		const MovedCorner corner = placed(surface, v);
		displaced = std::max(displaced, lengthSquared(corner.then - corner.now));
		displaced = std::max(displaced, lengthSquared(corner.unforced - corner.now));
		moved.box.add(corner.box);
		m_corners.push_back(corner);
	}
	moved.displaced = std::sqrt(displaced);
}

void MovedNodes::listNear(MovedNode& moved, const Box& places)
{
	listMoved(moved, m_question->b.surface(moved.level), places);
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
		Box box = Box::none();
		for (const std::uint16_t corner : corners) box.add(m_corners[corner].box);
		moved.polygons.push_back({{box, polygon.polygon, m_numbers.next()}, upOf(surface, polygon.polygon)});
	}
	const Span<std::uint32_t> vertices = surface.verticesOf(moved.node);
	const auto boxOf = [&](std::uint32_t vertex)
	{
		if (hasAllVertices) return m_corners[vertex].box;
		const std::uint32_t* const at = std::lower_bound(vertices.begin(), vertices.end(), vertex);
		const bool isOfNode = at != vertices.end() && *at == vertex;
		return isOfNode ? m_corners[std::size_t(at - vertices.begin())].box : placed(surface, vertex).box;
	};
	for (const std::uint32_t index : surface.edgesOf(moved.node))
	{
		const auto& [from, to] = surface.edges()[index].vertex;
		if (hasAllVertices && (m_beyond[from] & m_beyond[to]) != 0) continue;
		MovedEdge edge;
		edge.index = index;
		edge.number = numberOf(moved, true, index);
		edge.box = boxOf(from);
		edge.box.add(boxOf(to));
		moved.edges.push_back(edge);
	}
}
}  // namespace clod
