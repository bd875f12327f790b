// SPDX-License-Identifier: Zlib
#include "clod/manifold/MovedNode.h"

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

const MovedNode& MovedNodes::of(std::uint32_t node)
{
	const auto at = std::lower_bound(m_nodes.begin(), m_nodes.end(), node) - m_nodes.begin();
	MovedNode& moved = m_moved[std::size_t(at)];
	if (moved.node != node) move(moved, node);
	return moved;
}

void MovedNodes::move(MovedNode& moved, std::uint32_t node)
{
	const ContactBody& body = m_isA ? m_question->a : m_question->b;
	moved.node = node;
	moved.level = body.levelOf(node);
	const ContactSurface& surface = body.surface(moved.level);
	const Span<std::uint32_t> vertices = surface.verticesOf(node);
	moved.corners.clear();
	moved.edges.clear();
	moved.polygons.clear();
	m_boxes.clear();
	double displaced = 0;
	for (const std::uint32_t v : vertices)
	{
		const Vec3& own = surface.vertices()[v];
		Box box{own, own};  // A stands still in its own frame
		const bool isCorner = surface.isCorner(v);
		if (!m_isA || isCorner)
		{
			const Vec3 now = m_otherFromThis * own, then = m_otherFromThisThen * own, unforced = m_otherFromThisUnforced * own;
			if (!m_isA)
			{
				displaced = std::max(displaced, std::max(lengthSquared(then - now), lengthSquared(unforced - now)));
				box = {now, now};
				box.add(now + kPathReach * (then - now));
				box.add(now + kPathReach * (unforced - now));
			}
			if (isCorner) moved.corners.push_back({now, then, unforced, v, box});
		}
		if (m_boxes.empty()) moved.box = box;
		moved.box.add(box);
		m_boxes.push_back(box);
	}
	moved.displaced = std::sqrt(displaced);
	for (const ContactSurface::NodePolygon& polygon : surface.polygonsOf(node))
	{
		const Span<std::uint16_t> corners = surface.cornersOf(polygon);
		Box box = m_boxes[corners[0]];
		for (const std::uint16_t corner : corners) box.add(m_boxes[corner]);
		moved.polygons.push_back({polygon.polygon, box});
	}
	for (const std::uint32_t index : surface.edgesOf(node))
	{
		const SurfaceEdge& edge = surface.edges()[index];
		const Vec3 &from = surface.vertices()[edge.vertex[0]], &to = surface.vertices()[edge.vertex[1]];
		MovedEdge at;
		at.index = index;
		if (m_isA)
		{
			at.start = at.thenStart = at.unforcedStart = from;
			at.direction = at.thenDirection = edge.direction;
			at.box = {from, from};
			at.box.add(to);
			moved.edges.push_back(at);
			continue;
		}
		at.start = m_question->aFromB * from;
		at.thenStart = m_question->aFromBThen * from;
		at.unforcedStart = m_question->aFromBUnforced * from;
		at.direction = m_question->aFromB.rotation * edge.direction;
		at.thenDirection = m_question->aFromBThen.rotation * edge.direction;
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
