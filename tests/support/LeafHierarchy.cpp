// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/LeafHierarchy.h"

#include "tests/support/Meshes.h"

namespace clod::test
{
HierarchyContent leafHierarchy(const builder::Mesh& mesh)
{
	return builder::assembleHierarchy({{trianglePatches(mesh)}}, builder::BuildConfig{}, nullptr);
}
}  // namespace clod::test
