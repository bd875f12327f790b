// SPDX-License-Identifier: GPL-3.0-or-later
// The plainest real hierarchy: every triangle a leaf, then the completion levels. For tests of what reads hierarchies.
#pragma once
#include <memory>

#include "builder/Lod.h"

namespace clod::test
{
HierarchyContent leafHierarchy(const builder::Mesh& mesh);
// Encodes, loads and validates; throws std::runtime_error with the reason where that fails.
std::shared_ptr<const Hierarchy> loaded(const HierarchyContent& content);
}  // namespace clod::test
