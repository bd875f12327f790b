// SPDX-License-Identifier: Zlib
// The list of scenes.
#include "demos/scenes/Scene.h"

#include "demos/scenes/SpoonCup.h"

namespace clod::demo
{
const std::vector<SceneInfo>& scenes()
{
	static const std::vector<SceneInfo> all = {spoonCupInfo()};
	return all;
}

const SceneInfo* findScene(const std::string& name)
{
	for (const SceneInfo& scene : scenes())
		if (scene.name == name) return &scene;
	return nullptr;
}

std::unique_ptr<Scene> makeScene(const std::string& name, const SceneSettings& settings)
{
	if (name == spoonCupInfo().name) return std::make_unique<SpoonCup>(settings);
	return nullptr;
}
}  // namespace clod::demo
