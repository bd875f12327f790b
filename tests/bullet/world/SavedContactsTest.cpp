// SPDX-License-Identifier: GPL-3.0-or-later
// A world whose bodies and contacts are put back goes on as it did then.
#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bullet/world/MixedWorld.h"

namespace clod::test
{
// From rest, and from three places in a fall, wherever Bullet has ended no pair since. What comes in a fall depends on pairs and
// boxes of Bullet's that have a history: from every other place it goes another way after a step or some, as from one in ten
// if islands are split.
TEST(SavedContacts, PutBackWithTheBodiesAWorldGoesAsItDid)
{
	std::uint32_t kept = 0;
	int whole = 0;
	for (const auto& [start, steps] : {std::pair{40, 8}, {50, 8}, {60, 8}, {680, 40}, {700, 40}, {720, 40}, {740, 40}})
		for (const int passes : {1, 3})
		{
			MixedWorld scene(2, passes, passes);
			scene.world().getDispatchInfo().m_deterministicOverlappingPairs = true;
			scene.world().getSimulationIslandManager()->setSplitIslands(false);
			const auto save = [&] { return scene.context.saveContacts(scene.dispatcher()); };
			scene.run(start);
			const auto places = scene.places();
			const auto contacts = save();
			const int parts = scene.world().expectedParts();
			std::size_t gone = 0;
			std::vector<std::uint64_t> ways[2];
			for (auto& way : ways)
			{
				for (int i = 0; i < steps; ++i)
				{
					way.push_back(scene.run(1));
					way.push_back(hashOf(*save()));
					kept += scene.context.lastStep().keptPairs;
				}
				EXPECT_NE(way.back(), hashOf(*contacts));
				gone += scene.context.restoreContacts(scene.dispatcher(), *contacts);
				EXPECT_TRUE(gone > 0 || hashOf(*save()) == hashOf(*contacts)) << start;
				scene.putBack(places);
				scene.world().expectParts(parts);
			}
			if (gone > 0) continue;
			++whole;
			const auto first = std::mismatch(ways[0].begin(), ways[0].end(), ways[1].begin()).first;
			EXPECT_EQ(first - ways[0].begin(), 2 * steps) << start << ", " << passes;
		}
	EXPECT_GE(whole, 9) << whole;
	EXPECT_GT(kept, 100U);
}

// Whose boxes have parted begin anew.
TEST(SavedContacts, OfPairsThatAreNoLongerThereAreToldOf)
{
	MixedWorld scene(1);
	scene.run(240);
	const auto contacts = scene.context.saveContacts(scene.dispatcher());
	const auto places = scene.places();
	auto apart = places;
	for (std::size_t i = 0; i < apart.size(); ++i) apart[i].pose.getOrigin() += btVector3(0, btScalar(50 * i), 0);
	scene.putBack(apart);
	scene.run(30);
	EXPECT_GT(scene.context.restoreContacts(scene.dispatcher(), *contacts), 0U);
	EXPECT_NE(hashOf(*scene.context.saveContacts(scene.dispatcher())), hashOf(*contacts));
	scene.putBack(places);
	scene.run(240);
	EXPECT_GT(scene.context.lastStep().points, 40U);
}

TEST(SavedContacts, AreTheSameHoweverManyThreadsThereWere)
{
	const auto run = [](unsigned threads, int steps)
	{
		MixedWorld scene(threads);
		scene.run(steps);
		return hashOf(*scene.context.saveContacts(scene.dispatcher()));
	};
	const std::uint64_t one = run(1, 200);
	EXPECT_EQ(run(3, 200), one);
	EXPECT_NE(run(1, 199), one);
}
}  // namespace clod::test
