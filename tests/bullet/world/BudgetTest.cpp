// SPDX-License-Identifier: GPL-3.0-or-later
// Budgets over whole steps, with btClodDispatcher and with Bullet's own.
#include <gtest/gtest.h>

#include <algorithm>

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>

#include "tests/bullet/Toruses.h"

namespace clod::test
{
// A clock that moves on whenever it is looked at, as every opened pair of nodes does.
int g_looks = 0;
Clock::time_point nextTick()
{
	static Clock::time_point now;
	++g_looks;
	return now += std::chrono::microseconds(1);
}

TEST(BulletBudget, ATimeIsExceededByAtMostHalf)
{
	const auto looks = [](Toruses& scene, int step, double microseconds)
	{
		scene.context.budget = {kOff, microseconds, &nextTick};
		scene.place(0.8 - 5e-4 * step, 2e-3 * step);
		g_looks = 0;
		scene.detect(kOff);
		return g_looks;
	};
	Toruses none(true), full(true);
	int least = 0, dearest = 0;
	for (int step = 0; step < 60; ++step)
	{
		least = std::max(least, looks(none, step, 0));
		dearest = std::max(dearest, looks(full, step, 1e9));
	}
	ASSERT_GT(dearest, 10 * least);
	int coarse = 0;
	for (double budget = least; budget < dearest; budget *= 2)
	{
		Toruses scene(true);
		for (int step = 0; step < 60; ++step)
		{
			EXPECT_LE(looks(scene, step, budget), 1.5 * budget) << budget << ", step " << step;
			coarse += scene.look().excess > 1;
		}
	}
	EXPECT_GT(coarse, 60);
}

TEST(BulletBudget, AFullOneGivesTheTrajectoryOfNone)
{
	const std::uint64_t none = Toruses(false).run(120, kOff);
	EXPECT_EQ(Toruses(true).run(120, kOff), none);
	EXPECT_EQ(Toruses(true).run(120, 1e9), none);
	EXPECT_EQ(Toruses(true).run(120, 1e9, 1e12), none);
	EXPECT_EQ(Toruses(false).run(120, 1e9), none);
	EXPECT_EQ(Toruses(true).run(120, kOff, 1e12), none);
	EXPECT_NE(Toruses(true).run(120, 300), none);         // the comparison sees a smaller one
}

// Whatever fitted in before.
TEST(BulletBudget, NoTimeIsTheCoarsestAnswerAtEveryStep)
{
	const auto coarsest = [](Toruses& scene, int before, double microseconds, bool inTests)
	{
		scene.context.worldMetric = ContactMetric::deviationShare(0.1);
		scene.run(before, kOff, microseconds);
		return inTests ? scene.run(120, 0) : scene.run(120, kOff, 0);
	};
	for (const int before : {0, 60})
	{
		Toruses tests(true), time(true);
		const std::uint64_t expected = coarsest(tests, before, kOff, true);
		EXPECT_EQ(coarsest(time, before, 1e12, false), expected) << before;
		ASSERT_GT(time.look().excess, 1);
	}
}

TEST(BulletBudget, TheSameBudgetGivesTheSameTrajectory)
{
	EXPECT_EQ(Toruses(true).run(120, 1500), Toruses(true).run(120, 1500));
}

// Bodies that sink into each other and turn.
Toruses::Step movedTo(Toruses& scene, int step, double tests)
{
	scene.place(0.8 - 5e-4 * step, 2e-3 * step);
	return scene.detect(tests);
}

// With fronts, kept points and all; and the most that fits is bought.
TEST(BulletBudget, IsExceededOnlyByTheCoarsestAnswers)
{
	std::vector<Toruses::Step> coarsest, whole;
	Toruses none(true), full(true);
	for (int step = 0; step < 120; ++step)
	{
		coarsest.push_back(movedTo(none, step, 0));
		whole.push_back(movedTo(full, step, kOff));
	}
	std::uint64_t dearest = 0;
	for (const Toruses::Step& step : whole) dearest = std::max(dearest, step.tests);
	ASSERT_GT(dearest, 20 * coarsest[0].tests);
	double excess = kOff;
	for (double budget = 2.0 * double(coarsest[0].tests); budget < 2.5 * double(dearest); budget *= 3)
	{
		Toruses scene(true);
		int same = 0;
		double sum = 0;
		for (std::size_t step = 0; step < coarsest.size(); ++step)
		{
			const Toruses::Step now = movedTo(scene, int(step), std::floor(budget));
			EXPECT_LE(now.tests, std::max(std::uint64_t(budget), coarsest[step].tests)) << step;
			same += now.excess == 0;
			sum += now.excess;
		}
		EXPECT_LT(sum, 1.1 * excess) << budget;
		excess = sum;
		EXPECT_GE(same, budget > 1.2 * double(dearest) ? 114 : 0) << budget;
	}
	EXPECT_EQ(excess, 0);
}

// Bodies that go a third of their size in a step are looked at on their way, and then aside of it: of both questions only the
// latter has a coarsest answer. The reports tell all tests.
TEST(BulletBudget, IsNotExceededByBodiesThatGoFar)
{
	int coarse = 0, whole = 0;
	for (double budget = 100; budget < 2e4; budget *= 1.5)
	{
		Toruses scene(true);
		scene.world().getDispatchInfo().m_timeStep = btScalar(1.0 / 240);
		for (int step = 0; step < 30; ++step)
		{
			scene.place(1.1 - 5e-3 * step, 2e-3 * step);
			for (int i = 0; i < 4; ++i)
				scene.body(std::size_t(2 * i + 1)).setLinearVelocity(btVector3(btScalar(10 * i), btScalar(-60 + step), 0));
			const Toruses::Step now = scene.detect(std::floor(budget));
			EXPECT_LE(now.tests, std::max(std::uint64_t(budget), now.coarsestTests)) << budget << ", step " << step;
			++(now.excess > 0 ? coarse : whole);
		}
	}
	EXPECT_GT(coarse, 100);
	EXPECT_GT(whole, 100);
}

// Points would follow bodies that hardly move, but the program has changed what they are written with; beside them one
// moves that takes all it gets.
TEST(BulletBudget, IsNotExceededWhereWhatLiesStillIsAskedAfterAll)
{
	int asked = 0;
	for (double budget = 50; budget < 1e4; budget *= 1.3)
	{
		Toruses scene(true);
		scene.context.keepPoints = true;
		scene.run(240, kOff);
		for (int step = 0; step < 30; ++step)
		{
			const bool isChanged = step % 3 == 2;
			scene.body(3).getWorldTransform().getOrigin() += btVector3(btScalar(2e-3), 0, 0);
			for (std::size_t i = 0; i < 8 && isChanged; ++i)
				scene.body(i).setRollingFriction(btScalar(1e-3 * step));
			scene.run(1, std::floor(budget));
			const Toruses::Step now = scene.look();
			EXPECT_LE(now.tests, std::max(std::uint64_t(budget), now.coarsestTests)) << budget << ", step " << step;
			asked += isChanged && now.coarsestTests > 0;
		}
	}
	EXPECT_GT(asked, 50);
}

// Children of compounds are of the same step.
TEST(BulletBudget, CountsChildrenOfCompounds)
{
	EXPECT_EQ(Toruses(true, 4, 2).run(120, 1e9), Toruses(false, 4, 2).run(120, kOff));
	const std::uint64_t counted = Toruses(true, 4, 2).run(120, 1500);
	EXPECT_EQ(Toruses(true, 4, 2).run(120, 1500), counted);
	EXPECT_EQ(Toruses(true, 4, 2, nullptr, true).run(120, 1500), counted);  // and theirs
	for (const int compounds : {1, 2, 4})
	{
		Toruses scene(true, 4, compounds), none(true, 4, compounds);
		for (int step = 0; step < 60; ++step)
		{
			const Toruses::Step coarsest = movedTo(none, step, 0), now = movedTo(scene, step, 1000);
			EXPECT_LE(double(now.tests), 1000 + double(coarsest.tests)) << step;
		}
	}
}

// World, shape and pair, from step to step: a full budget still gives what none does.
TEST(BulletBudget, MetricsMayChangeWithEveryStep)
{
	const auto run = [](bool ours, double tests)
	{
		Toruses scene(ours);
		const btRigidBody& special = scene.body(3);
		int step = 0;
		scene.context.pairMetric = [&](const btCollisionObject& a, const btCollisionObject& b, ContactMetric& metric)
		{
			metric = ContactMetric::deviationShare(0.3);
			return step % 4 > 1 && (&a == &special || &b == &special);
		};
		std::uint64_t hash = 0;
		for (; step < 120; ++step)
		{
			scene.context.worldMetric = step % 3 == 0   ? ContactMetric::deviationShare(0.01)
										: step % 3 == 1 ? ContactMetric::errorShare(0.02)
														: ContactMetric::velocityFactor(1);
			if (step % 40 == 20) scene.shape().setMetric(ContactMetric::exactly());
			if (step % 40 == 30) scene.shape().clearMetric();
			hash = 31 * hash + scene.run(1, tests);
		}
		return hash;
	};
	const std::uint64_t none = run(false, kOff);
	EXPECT_EQ(run(true, 1e9), none);
	EXPECT_EQ(run(false, 1e9), none);
	EXPECT_NE(run(true, 300), none);
	EXPECT_EQ(run(true, 300), run(true, 300));
}

// Pairs whose bodies leave, return, or are not dispatched after all.
TEST(BulletBudget, BodiesComeAndGo)
{
	const auto run = [](bool ours, double tests)
	{
		Toruses scene(ours);
		std::uint64_t hash = 0;
		for (int step = 0; step < 90; ++step)
		{
			scene.setPresent(1, step % 30 < 20);
			scene.setPresent(4, step % 20 < 15);  // one that others lie on
			const bool isFiltered = step % 7 == 3;
			scene.setNearCallback(isFiltered ? [](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) {}
											 : &btCollisionDispatcher::defaultNearCallback);
			hash = 31 * hash + scene.run(1, tests);
			EXPECT_LE(scene.context.lastStep().pairs, 4U);
		}
		scene.setPresent(1, false);
		scene.setPresent(4, false);
		EXPECT_LE(scene.context.lastStep().pairs, 2U);
		return hash;
	};
	const std::uint64_t none = run(false, kOff);
	EXPECT_EQ(run(true, 1e9), none);
	EXPECT_EQ(run(false, 1e9), none);
	EXPECT_EQ(run(true, 400), run(true, 400));
}

// What a character asks between the steps is no step, and takes nothing of one: the others go as they go beside a ghost that
// is led the same way and asks nothing.
TEST(BulletBudget, CharactersTakeNothingOfIt)
{
	std::vector<btTransform> way;
	const auto run = [&way](bool ours, bool asks)
	{
		Toruses scene(ours);
		btGhostPairCallback callback;
		scene.world().getPairCache()->setInternalGhostPairCallback(&callback);
		scene.setPresent(7, false);
		btCapsuleShape capsule(btScalar(0.2), btScalar(0.3));
		btPairCachingGhostObject ghost;
		ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(12.7), btScalar(0.7), 0)));
		ghost.setCollisionShape(&capsule);
		ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
		btKinematicCharacterController character(&ghost, &capsule, btScalar(0.1), btVector3(0, 1, 0));
		const int met = btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter;
		scene.world().addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter, met);
		if (asks) way.clear();
		std::uint64_t hash = 0;
		for (std::size_t step = 0; step < 60; ++step)
		{
			scene.place(0.8 - 2e-3 * double(step), 2e-3 * double(step));
			scene.detect(1500);
			scene.context.forEachPair(
				[&](const PairReport& pair)
				{
					if (pair.objectA == &ghost || pair.objectB == &ghost) return;
					const QueryStats& stats = pair.result->stats;
					hash = mixed(hash, double(stats.boxTests) + double(stats.hullTests));
					hash = mixed(mixed(hash, pair.result->excess), double(pair.result->pairs.size()));
				});
			if (asks)
			{
				character.updateAction(&scene.world(), btScalar(1.0 / 60));
				way.push_back(ghost.getWorldTransform());
			}
			else
				ghost.setWorldTransform(way[step]);
		}
		const double height = double(ghost.getWorldTransform().getOrigin().y());
		EXPECT_TRUE(height > 0.3 && height < 0.69) << "it met nothing at " << height;
		scene.world().removeCollisionObject(&ghost);
		return hash;
	};
	for (const bool ours : {false, true})
	{
		const std::uint64_t asking = run(ours, true);
		EXPECT_EQ(asking, run(ours, false)) << ours;
	}
}

// A ghost whose pairs are those of the steps is as budgeted as a body.
TEST(BulletBudget, TriggersAreBudgetedLikeBodies)
{
	Toruses scene(true);
	btPairCachingGhostObject ghost;
	ghost.setCollisionShape(&scene.shape());
	ghost.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
	scene.world().addCollisionObject(&ghost);
	double excess = 0;
	int pairs = 0;
	for (int step = 0; step < 20; ++step)
	{
		scene.place(0.8 - 2e-3 * step, 2e-3 * step);
		btTransform pose = scene.body(1).getWorldTransform();
		pose.setOrigin(pose.getOrigin() + btVector3(btScalar(0.1), btScalar(0.05), 0));
		ghost.setWorldTransform(pose);
		scene.detect(300);
		scene.context.forEachPair(
			[&](const PairReport& pair)
			{
				if (pair.objectA != &ghost && pair.objectB != &ghost) return;
				++pairs;
				excess = std::max(excess, pair.result->excess);
			});
	}
	EXPECT_GT(pairs, 0);
	EXPECT_GT(excess, 1);
	scene.world().removeCollisionObject(&ghost);
}

// Each has its budget, and neither takes from the other's.
TEST(BulletBudget, WorldsMayShareAContext)
{
	for (const double tests : {kOff, 1500.0})
	{
		Toruses alone(true), aloneToo(true, 2);
		Context shared;
		Toruses first(true, 4, 0, &shared), second(true, 2, 0, &shared);
		for (int step = 0; step < 60; ++step)
		{
			ASSERT_EQ(first.run(1, tests), alone.run(1, tests)) << step;
			ASSERT_EQ(second.run(1, tests), aloneToo.run(1, tests)) << step;
		}
		EXPECT_EQ(shared.lastStep().pairs, alone.context.lastStep().pairs + aloneToo.context.lastStep().pairs);
		EXPECT_EQ(first.look().tests, alone.look().tests + aloneToo.look().tests);
	}
}

TEST(BulletBudget, TheCoarsestAnswersCarryBodiesToo)
{
	Toruses exact(true), coarsest(true), hurried(true);
	exact.run(240, kOff);
	coarsest.run(240, 0);
	hurried.run(240, kOff, 0);  // no time at all
	std::printf("heights %.4f %.4f %.4f\n", exact.height(), coarsest.height(), hurried.height());
	EXPECT_NEAR(coarsest.height(), exact.height(), 0.1);
	EXPECT_NEAR(hurried.height(), exact.height(), 0.1);
}

// What was cut short answers no dispatch that may cost more, however still the bodies lie.
TEST(BulletBudget, ACoarseAnswerEndsWithItsBudget)
{
	for (const double microseconds : {kOff, 1e12})
	{
		Toruses scene(true);
		scene.context.worldMetric = ContactMetric::deviationShare(0.1);
		scene.run(60, kOff);
		const Toruses::Step full = scene.detect(1e9);
		scene.context.budget = {kOff, 0};
		const Toruses::Step coarse = scene.detect(kOff);
		ASSERT_GT(coarse.excess, 0);
		scene.context.budget = {kOff, microseconds};
		const Toruses::Step free = scene.detect(kOff);
		EXPECT_EQ(free.excess, 0) << microseconds;
		EXPECT_EQ(free.contacts, full.contacts) << microseconds;
		// And the other way round: a budget is held although a finer answer is at hand.
		scene.context.budget = {};
		const Toruses::Step none = scene.detect(0);
		EXPECT_EQ(none.contacts, coarse.contacts) << microseconds;
		EXPECT_EQ(none.excess, coarse.excess) << microseconds;
	}
}

TEST(BulletBudget, WhatLiesStillCostsNothingWhereNothingIsBought)
{
	Toruses scene(true);
	scene.run(60, kOff);
	const Toruses::Step coarse = scene.detect(0);
	ASSERT_GT(coarse.tests, 100U);
	const Toruses::Step again = scene.detect(0);
	EXPECT_LT(again.tests, coarse.tests / 10);  // of a pair that has no points
	EXPECT_EQ(again.contacts, coarse.contacts);
}

// An answer that is finer than a smaller budget buys costs nothing while the bodies lie still.
TEST(BulletBudget, AFinerAnswerStaysWhileNothingMoves)
{
	Toruses scene(true);
	scene.run(60, 1e9);
	const Toruses::Step full = scene.detect(1e9);
	ASSERT_EQ(full.excess, 0);
	const Toruses::Step tight = scene.detect(300);
	EXPECT_EQ(tight.excess, 0);
	EXPECT_EQ(tight.contacts, full.contacts);
	EXPECT_EQ(tight.tests, 0U);
	scene.run(1, 300);
	EXPECT_GT(scene.look().excess, 0);
}

// What lies still is refined by what is left, some pairs a step, until none misses its metric; then it costs nothing.
TEST(BulletBudget, WhatLiesStillComesDownToItsMetric)
{
	for (const bool ours : {true, false})
		for (const double share : {0.3, 0.6})
		{
			Toruses scene(ours);
			scene.run(120, kOff);
			scene.detect(0);
			const Toruses::Step full = scene.detect(1e9), coarse = scene.detect(0);
			ASSERT_EQ(full.excess, 0);
			ASSERT_GE(coarse.cut, 3);
			const double budget = std::floor(share * double(full.tests));
			int missed = coarse.cut, steps = 0;
			for (; missed > 0 && steps < 100; ++steps)
			{
				const Toruses::Step now = scene.detect(budget);
				EXPECT_LE(double(now.tests), budget) << steps;
				EXPECT_LE(now.cut, missed) << steps;
				missed = now.cut;
			}
			EXPECT_GT(steps, 1) << share;
			EXPECT_LT(steps, 12) << share;
			const Toruses::Step now = scene.detect(budget);
			EXPECT_EQ(now.tests, 0U);
			EXPECT_EQ(now.contacts, full.contacts);
		}
}

TEST(BulletBudget, OneThatCannotBeUsedIsSaidAndNotUsed)
{
	Toruses scene(true);
	scene.run(240, kOff);
	std::vector<std::string> said;
	scene.context.warn = [&said](const std::string& message) { said.push_back(message); };
	const Toruses::Step full = scene.detect(1e9), bad = scene.detect(-1);
	EXPECT_GT(full.contacts, 0u);
	EXPECT_EQ(bad.contacts, full.contacts);
	ASSERT_FALSE(said.empty());
	EXPECT_NE(said[0].find("budget.tests"), std::string::npos) << said[0];
}
}  // namespace clod::test
