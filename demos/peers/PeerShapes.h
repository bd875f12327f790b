// SPDX-License-Identifier: Zlib
// What users of Bullet make of the models of a scene instead of ours: one shape a model. Compiled once per Bullet
// precision.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "demos/peers/Preparation.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
// Peers have collision margins, ours keeps bodies apart by itself: both by about the default's accuracy.
inline constexpr double kPeerMarginShare = 0.0025;  // of the smallest radius, on each body
// What a game takes of V-HACD (at most so many pieces a model) and of CoACD (concavity, its default).
inline constexpr int kPeerHulls = 32;
inline constexpr double kPeerConcavity = 0.05;

// "bvh-": concave models that stay where they are keep their triangles, in a static tree.
inline const std::vector<std::string> kPeerShapes{"gimpact",   "vhacd",     "coacd",    "hull",
												  "bvh-vhacd", "bvh-coacd", "bvh-hull"};
// The surface of a mesh's convex hull.
ModelMesh convexHullOf(const ModelMesh& mesh);

// In words: "btCompoundShape of at most 32 hulls a mesh".
std::string describePeerShape(const std::string& kind);

// `kind`: one of kPeerShapes, or "vhacd:N" for at most N hulls. A convex model is a hull whatever the kind. `surfaces`:
// one a model. Fails with a sentence where pieces cannot be made.
Result<std::vector<SceneShape>> peerShapes(const std::string& kind, const std::vector<ModelMesh>& surfaces,
										   const std::vector<bool>& moves, double margin,
										   const Preparation& preparation,
										   const std::function<void(const std::string&, double)>& progress);
// Of each model of a scene: does a body of it move?
std::vector<bool> movingModels(const SceneDefinition& scene);
}  // namespace clod::demo
