// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/HierarchyContents.h"

#include <stdexcept>

namespace clod::test
{
std::shared_ptr<const Hierarchy> loaded(const HierarchyContent& content)
{
	auto result = Hierarchy::fromBytes(encode(content));
	if (!result) throw std::runtime_error(result.error());
	return *result;
}

HierarchyContent contentOf(const Hierarchy& hierarchy)
{
	HierarchyContent content;
	content.asset = hierarchy.asset();
	content.levels.assign(hierarchy.levels().begin(), hierarchy.levels().end());
	content.nodes.assign(hierarchy.nodes().begin(), hierarchy.nodes().end());
	for (std::uint32_t i = 0; i < content.nodes.size(); ++i) content.cullBoxes.push_back(hierarchy.cullBox(i));
	// Children and vertices lie node by node.
	for (const Node& node : content.nodes)
	{
		for (const std::uint32_t child : hierarchy.children(node)) content.children.push_back(child);
		const HullView hull = hierarchy.hull(node);
		content.hullX.insert(content.hullX.end(), hull.x, hull.x + hull.padded);
		content.hullY.insert(content.hullY.end(), hull.y, hull.y + hull.padded);
		content.hullZ.insert(content.hullZ.end(), hull.z, hull.z + hull.padded);
	}
	content.faces.assign(hierarchy.faces().begin(), hierarchy.faces().end());
	return content;
}

std::string refusal(std::vector<std::byte> bytes)
{
	const auto result = Hierarchy::fromBytes(std::move(bytes));
	return result ? "" : result.error();
}
}  // namespace clod::test
