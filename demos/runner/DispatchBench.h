// SPDX-License-Identifier: Zlib
// Whole collision dispatches of Bullet at recorded poses, for our shape and for Bullet's btGImpactMeshShape on the same
// meshes: what a user's simulation pays, clustering and manifolds included.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Replay.h"

namespace clod::demo
{
// Times both shapes, moving as recorded and at rest, and returns their spreads and ratios, over all rows and over the
// moving contact rows of `rows`.
nlohmann::ordered_json comparePeer(const HierarchyPointer& a, const HierarchyPointer& b,
								   const std::vector<PoseRow>& poses, const std::vector<ReplayRow>& rows,
								   const ReplayOptions& options);
void printPeer(const nlohmann::ordered_json& peer);
}  // namespace clod::demo
