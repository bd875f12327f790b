// SPDX-License-Identifier: GPL-3.0-or-later
// Every scene as data, before anything is simulated: named, whole, of a size that suits Bullet, and in its picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
TEST(SceneList, EveryoneHasANameOfItsOwnAndSaysWhatItIs)
{
	std::set<std::string> names, summaries;
	for (const SceneDefinition& scene : sceneDefinitions())
	{
		EXPECT_TRUE(names.insert(scene.info.name).second) << scene.info.name;
		EXPECT_TRUE(summaries.insert(scene.info.summary).second) << scene.info.name;
		EXPECT_GT(scene.info.summary.size(), 20u) << scene.info.name;
		ASSERT_NE(findScene(scene.info.name), nullptr);
		EXPECT_EQ(findScene(scene.info.name)->summary, scene.info.summary);
	}
	EXPECT_EQ(findScene("none"), nullptr);
}

TEST(SceneList, BodiesAreOfModelsThatAreThere)
{
	for (const SceneDefinition& scene : sceneDefinitions())
	{
		const SceneInfo& info = scene.info;
		ASSERT_EQ(scene.bodies.size(), info.bodies.size()) << info.name;
		std::set<std::size_t> used;
		for (const SceneBody& body : info.bodies)
		{
			ASSERT_LT(body.model, info.models.size()) << info.name;
			used.insert(body.model);
			EXPECT_FALSE(body.name.empty()) << info.name;
		}
		EXPECT_EQ(used.size(), info.models.size()) << info.name << " has a model that nobody is of";
	}
}

TEST(SceneList, SizesSuitBulletAndEachOther)
{
	for (const SceneDefinition& scene : sceneDefinitions())
	{
		const SceneInfo& info = scene.info;
		const double size = info.overview.radius * info.worldScale;
		EXPECT_GT(size, 2) << info.name << ": Bullet's constants suit bodies of about one unit";
		EXPECT_LT(size, 300) << info.name;
		EXPECT_GT(info.tolerance, 0.005 * info.thinnerWall) << info.name;
		EXPECT_LT(info.tolerance, 0.6 * info.thinnerWall) << info.name;
		EXPECT_LE(info.dt, 1.0 / 240) << info.name;
		EXPECT_GT(info.steps * info.dt, 0.8) << info.name << ": a film of less";
	}
}

TEST(SceneList, PicturesAreOfTheBodies)
{
	for (const SceneDefinition& scene : sceneDefinitions())
	{
		const SceneInfo& info = scene.info;
		const SceneView& view = info.overview;
		double far = 0;
		std::size_t inside = 0;
		for (const BodyDefinition& body : scene.bodies)
		{
			const double away = length((body.course ? body.course(0) : body.start).position - view.center);
			far = std::max(far, away);
			inside += away < view.radius ? 1 : 0;
		}
		EXPECT_GE(3 * inside, scene.bodies.size()) << info.name << ": most start outside";
		EXPECT_LT(view.radius, 3 * (far + info.closeUp.radius)) << info.name << ": small in its picture";
		EXPECT_LT(info.closeUp.radius, view.radius) << info.name;
	}
}
}  // namespace clod::demo
