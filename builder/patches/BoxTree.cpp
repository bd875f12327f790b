// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/patches/BoxTree.h"

#include <algorithm>

namespace clod::builder
{
void BoxTree::build(const std::vector<Box>& boxes)
{
	m_nodes.clear();
	m_leafOf.assign(boxes.size(), 0);
	std::vector<std::uint32_t> order(boxes.size());
	for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
	if (order.empty()) return;
	m_nodes.reserve(2 * boxes.size());
	buildRange(order, 0, order.size(), boxes);
	m_nodes[0].parent = kInner;
}

std::uint32_t BoxTree::buildRange(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
								  const std::vector<Box>& boxes)
{
	const auto self = std::uint32_t(m_nodes.size());
	m_nodes.emplace_back();
	if (end - begin == 1)
	{
		m_nodes[self].item = order[begin];
		m_nodes[self].box = boxes[order[begin]];
		m_leafOf[order[begin]] = self;
		return self;
	}
	Box centres;
	const auto centre = [&](std::uint32_t i) { return boxes[i].isEmpty() ? Vec3{} : boxes[i].low + boxes[i].high; };
	for (std::size_t i = begin; i < end; ++i) centres.include(centre(order[i]));
	const Vec3 extent = centres.high - centres.low;
	const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
	const std::size_t middle = (begin + end) / 2;
	std::nth_element(order.begin() + long(begin), order.begin() + long(middle), order.begin() + long(end),
					 [&](std::uint32_t a, std::uint32_t b)
					 {
						 const double ca = centre(a)[axis], cb = centre(b)[axis];
						 return ca < cb || (ca == cb && a < b);
					 });
	const std::uint32_t left = buildRange(order, begin, middle, boxes);
	const std::uint32_t right = buildRange(order, middle, end, boxes);
	Node& node = m_nodes[self];
	node.right = right;
	m_nodes[left].parent = m_nodes[right].parent = self;
	node.box.include(m_nodes[left].box);
	node.box.include(m_nodes[right].box);
	return self;
}

void BoxTree::update(std::uint32_t item, const Box& box)
{
	std::uint32_t at = m_leafOf[item];
	m_nodes[at].box = box;
	for (at = m_nodes[at].parent; at != kInner; at = m_nodes[at].parent)
	{
		Box merged;
		merged.include(m_nodes[at + 1].box);
		merged.include(m_nodes[m_nodes[at].right].box);
		if (merged.low == m_nodes[at].box.low && merged.high == m_nodes[at].box.high) return;
		m_nodes[at].box = merged;
	}
}
}  // namespace clod::builder
