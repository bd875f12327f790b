// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/LeafHierarchy.h"

#include <stdexcept>

#include "tests/support/Meshes.h"

namespace clod::test
{
HierarchyContent leafHierarchy(const builder::Mesh& mesh)
{
	return builder::assembleHierarchy({{trianglePatches(mesh)}}, builder::BuildConfig{}, nullptr);
}

std::shared_ptr<const Hierarchy> loaded(const HierarchyContent& content)
{
	auto result = Hierarchy::fromBytes(encode(content));
	if (!result) throw std::runtime_error(result.error());
	return *result;
}
}  // namespace clod::test
