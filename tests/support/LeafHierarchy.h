// SPDX-License-Identifier: GPL-3.0-or-later
// The plainest real hierarchy: every triangle a leaf, then the completion levels. For tests of what reads hierarchies.
#pragma once
#include "builder/Lod.h"

namespace clod::test
{
HierarchyContent leafHierarchy(const builder::Mesh& mesh);
}  // namespace clod::test
