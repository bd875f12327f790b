// SPDX-License-Identifier: Zlib
// Scenes from JSON files (scene.schema.json): bodies, meshes, scales, poses, velocities, joints to the world,
// materials.
#pragma once
#include <string>
#include <string_view>

#include "clod/hierarchy/Result.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
// Mesh files are named from the scene file's folder. Fails with file and element ("bodies[2].model: ...").
Result<SceneDefinition> readScene(const std::string& path);
Result<SceneDefinition> parseScene(std::string_view text, const std::string& path);

// What lies so far from the origin that Bullet cannot tell places apart: its name in the file and why; else empty.
std::string tooFar(const SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models);

// What a file leaves open depends on its models' sizes: tolerance, Bullet's scale, what pictures look at. Leaves what
// is there as it is.
void fitToModels(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models);
}  // namespace clod::demo
