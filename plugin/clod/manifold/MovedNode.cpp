// SPDX-License-Identifier: Zlib
#include "clod/manifold/MovedNode.h"

#include <algorithm>
#include <cmath>

namespace clod
{
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
}

MovedNode& MovedNodes::of(std::uint32_t node, const Near& near)
{
	const auto at = std::lower_bound(m_nodes.begin(), m_nodes.end(), node) - m_nodes.begin();
	MovedNode& moved = m_moved[std::size_t(at)];
	if (moved.node == node) return moved;
	const ContactBody& body = m_isA ? m_question->a : m_question->b;
	moved.node = node;
	moved.level = body.levelOf(node);
	moved.corners.clear();
	moved.edges.clear();
	moved.polygons.clear();
	m_boxes.clear();
	const ContactSurface& surface = body.surface(moved.level);
	m_isA ? listStill(moved, surface, near) : move(moved, surface);
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

Vec3 MovedNodes::upOf(const ContactSurface& surface, std::uint32_t polygon) const
{
	return m_otherFromThis.rotation * surface.planeOf(polygon).normal;
}

// A stands still in its own frame.
void MovedNodes::listStill(MovedNode& moved, const ContactSurface& surface, const Near& near) const
{
	moved.displaced = 0;
	moved.box = Box::none();
	const Span<std::uint32_t> vertices = surface.verticesOf(moved.node);
	const auto placeOf = [&](std::size_t i) -> const Vec3& { return surface.vertices()[vertices[i]]; };
	const auto isListed = [&](const Box& box)
	{
		if (!near.holds(box)) return false;
		moved.box.add(box);
		return true;
	};
	for (const std::uint32_t v : vertices)
	{
		const Vec3& place = surface.vertices()[v];
		if (near.mayBeInside()) moved.box.add(place);
		if (surface.isCorner(v) && isListed({place, place})) moved.corners.push_back({{place, place}, v});
	}
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(moved.node))
	{
		const double radius = surface.radiusOf(polygon.polygon);
		const Vec3 &center = surface.centerOf(polygon.polygon), far{radius, radius, radius};
		if (!near.holds({center - far, center + far})) continue;
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		Box box{placeOf(corners[0]), placeOf(corners[0])};
		for (const std::uint16_t corner : corners) box.add(placeOf(corner));
		if (isListed(box)) moved.polygons.push_back({box, polygon.polygon, upOf(surface, polygon.polygon)});
	}
	for (const std::uint32_t index : surface.edgesOf(moved.node))
	{
		const SurfaceEdge& edge = surface.edges()[index];
		Box box{surface.vertices()[edge.vertex[0]], surface.vertices()[edge.vertex[0]]};
		box.add(surface.vertices()[edge.vertex[1]]);
		if (isListed(box)) moved.edges.push_back({box, index});
	}
}

void MovedNodes::move(MovedNode& moved, const ContactSurface& surface)
{
	double displaced = 0;
	for (const std::uint32_t v : surface.verticesOf(moved.node))
	{
		MovedCorner corner{{}, v};
		place(surface, corner);
		const Vec3 &now = corner.now, ahead = corner.then - now, unforced = corner.unforced - now;
		displaced = std::max(displaced, std::max(lengthSquared(ahead), lengthSquared(unforced)));
		corner.box = {now, now};
		corner.box.add(now + kPathReach * ahead);
		corner.box.add(now + kPathReach * unforced);
		if (surface.isCorner(v)) moved.corners.push_back(corner);
		if (m_boxes.empty()) moved.box = corner.box;
		moved.box.add(corner.box);
		m_boxes.push_back(corner.box);
	}
	moved.displaced = std::sqrt(displaced);
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(moved.node))
	{
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		Box box = m_boxes[corners[0]];
		for (const std::uint16_t corner : corners) box.add(m_boxes[corner]);
		moved.polygons.push_back({box, polygon.polygon, upOf(surface, polygon.polygon)});
	}
	for (const std::uint32_t index : surface.edgesOf(moved.node))
	{
		const SurfaceEdge& edge = surface.edges()[index];
		const Vec3& from = surface.vertices()[edge.vertex[0]];
		MovedEdge at;
		at.index = index;
		at.start = m_question->aFromB * from;
		at.thenStart = m_question->aFromBThen * from;
		at.unforcedStart = m_question->aFromBUnforced * from;
		at.direction = m_question->aFromB.rotation * edge.direction;
		at.thenDirection = m_question->aFromBThen.rotation * edge.direction;
		for (std::size_t side = 0; side < 2; ++side) at.inward[side] = m_question->aFromB.rotation * edge.inward[side];
		at.box = {at.start, at.start};
		at.box.add(at.start + kPathReach * (at.thenStart - at.start));
		at.box.add(at.start + kPathReach * (at.unforcedStart - at.start));
		const Vec3 end = at.start + edge.length * at.direction;
		at.box.add(end);
		at.box.add(end + kPathReach * (at.thenStart + edge.length * at.thenDirection - end));
		at.box.add(end + kPathReach * (at.unforcedStart - at.start));
		moved.edges.push_back(at);
	}
}
}  // namespace clod
