// SPDX-License-Identifier: GPL-3.0-or-later
// From the patches of one level of detail to nodes: local vertices, faces, mean normal, cone, curvature.
#pragma once
#include "builder/assemble/Draft.h"

namespace clod::builder
{
// One node per patch, in patch order. Throws std::runtime_error where a patch does not fit into a node.
std::vector<NodeDraft> patchNodes(const Lod& lod, std::size_t level);
}  // namespace clod::builder
