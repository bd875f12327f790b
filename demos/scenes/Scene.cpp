// SPDX-License-Identifier: Zlib
// The list of scenes.
#include <algorithm>
#include <cmath>

#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
const std::vector<SceneDefinition>& sceneDefinitions()
{
	static const std::vector<SceneDefinition> all = {
		spoonCup(), torusSpiral(), numbersBowl(), spoonsNested(),
		boltNut(),  mixedNeeds(),  contactArea(), drop({{"torus", ""}, {"number8", ""}, {"nut", ""}})};
	return all;
}

Vec3 steadyGravity(double)
{
	return {0, -kGravity, 0};
}

double smoothStep(double t)
{
	t = std::clamp(t, 0.0, 1.0);
	return t * t * (3 - 2 * t);
}

Pose turnedAboutY(const Vec3& place, double angle)
{
	return {place, {0, std::sin(angle / 2), 0, std::cos(angle / 2)}};
}

const std::vector<SceneInfo>& scenes()
{
	static const std::vector<SceneInfo> infos = []
	{
		std::vector<SceneInfo> list;
		for (const SceneDefinition& scene : sceneDefinitions()) list.push_back(scene.info);
		return list;
	}();
	return infos;
}

const SceneInfo* findScene(const std::string& name)
{
	for (const SceneInfo& scene : scenes())
		if (scene.name == name) return &scene;
	return nullptr;
}

}  // namespace clod::demo
