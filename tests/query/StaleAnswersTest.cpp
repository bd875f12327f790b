// SPDX-License-Identifier: GPL-3.0-or-later
// An answer that no longer holds is not given: scripted histories in which one thing alone changes, each against a
// query without any cache, and each seen to have another answer.
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

// A pair asked again and again, with one cache.
struct History
{
	BodyPair pair;
	Transform pose;
	Settings settings;
	GapCache cache{};
	GapResult result{};

	// What differs from an answer without a cache, or nothing.
	std::string ask()
	{
		query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
		return difference(result, fresh(pair, pose, settings));
	}
	// Goes on by so little, again and again, until nothing is looked at any more, or for long.
	bool settle(const Vec3& step)
	{
		for (int i = 0; i < 40; ++i)
		{
			pose.translation += step;
			if (!ask().empty()) return false;
			if (result.stats.stillApart) return true;
		}
		return true;
	}
};

const Body& cubeBody()
{
	return body("cube");
}
const Body& rodBody()
{
	return body("rod");
}
// About the middle of B, which stays where it is.
Sweep turning(const Vec3& angular, const Transform& pose)
{
	return {-cross(angular, pose.translation), angular};
}

// A rod lies over a cube, half a side apart. Nothing moves but what the step to come is said to bring.
TEST(StaleAnswers, BodiesApartAreLookedAtOnceTheirSweepBringsThemTogether)
{
	const Transform over{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 1.5, 0}};
	const Sweep away{{0, 0.3, 0}, {}};
	const struct
	{
		const char* name;
		Sweep before, after;
	} cases[] = {{"moves", {}, {{0, -0.45, 0}, {}}},
				 {"turns", {}, turning({0, 0, 0.6}, over)},
				 {"turns the other way", {}, turning({0, 0, -0.6}, over)},
				 {"comes back", away, {{0, -0.45, 0}, {}}},
				 {"moves and turns", away, {{0, -0.2, 0}, {0, 0, 0.3}}}};
	for (const auto& c : cases)
		for (const bool isExact : {true, false})
			for (const bool contactsOnly : {true, false})
			{
				Settings settings = exactSettings(0.01);
				settings.metric.exact = isExact;
				if (!isExact) settings.metric.maxError = 0.05;
				settings.contactsOnly = contactsOnly;
				settings.sweep = c.before;
				History history{{cubeBody(), rodBody()}, over, settings};
				const std::string where =
					std::string(c.name) + (isExact ? ", exact" : "") + (contactsOnly ? "" : ", gap");
				EXPECT_EQ(history.ask(), "") << where;
				ASSERT_TRUE(history.settle({1e-4, 0, 0})) << where;
				ASSERT_EQ(history.result.stats.stillApart, 1u) << where;
				for (int again = 0; again < 3; ++again)
				{
					history.settings.sweep = c.after;
					EXPECT_EQ(history.ask(), "") << where;
					EXPECT_FALSE(fresh(history.pair, history.pose, history.settings).contacts.empty()) << where;
					history.settings.sweep = c.before;
					EXPECT_EQ(history.ask(), "") << where;
					EXPECT_TRUE(history.result.contacts.empty()) << where;
				}
			}
}

// Bodies near each other: what the front has kept is of another sweep.
TEST(StaleAnswers, AFrontIsLookedAtAgainWhenTheSweepChanges)
{
	Random random(71);
	int others = 0;
	const Body &box = body("box", 12), &torus = body("torus", 900);
	for (const BodyPair& pair : {BodyPair{torus, torus}, BodyPair{box, torus}})
		for (int i = 0; i < 30; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings = exactSettings(0.01 * radius);
			settings.contactsOnly = true;
			settings.metric.exact = i % 2 == 0;
			if (i % 2 == 1) settings.metric.weightedDeviation = 0.02 * radius;
			History history{pair, poseWithGap(random, pair.a, pair.b, 0.005), settings};
			ASSERT_EQ(history.ask(), "");
			ASSERT_TRUE(history.settle(1e-9 * radius * randomDirection(random)));
			const std::size_t before = history.result.contacts.size();
			const Vec3 turn = 0.02 * randomDirection(random);
			history.settings.sweep =
				i % 4 < 2 ? Sweep{0.02 * radius * randomDirection(random), {}} : turning(turn, history.pose);
			EXPECT_EQ(history.ask(), "") << pair.a.name << " " << i;
			others += history.result.contacts.size() != before;
		}
	EXPECT_GT(others, 20);
}

// One field of the settings, from one value to another.
struct Change
{
	const char* name;
	double gap;  // of the pose, of the radius
	std::function<void(Settings&, double radius)> before, after;
};
std::vector<Change> changes(const OwnThreshold& fine, const OwnThreshold& coarse)
{
	const auto none = [](Settings&, double) {};
	const auto tolerance = [](double share) { return [share](Settings& s, double r) { s.tolerance = share * r; }; };
	const auto size = [](double share)
	{ return [share](Settings& s, double r) { s.metric.weightedDeviation = share * r; }; };
	const auto velocity = [](double speed)
	{ return [speed](Settings& s, double r) { s.metric.velocity = {1, 1e-3 * r, {speed * r, 0, 0}, {}}; }; };
	const auto view = [](double away)
	{ return [away](Settings& s, double r) { s.metric.view = {1, {0, 0, away * r}, 1e-3, 0.01 * r}; }; };
	const auto own = [](const OwnThreshold& which) { return [&which](Settings& s, double) { s.metric.own = &which; }; };
	return {{"tolerance, contacts", 0.005, tolerance(0.01), tolerance(0.03)},
			{"tolerance, none at first", 0.02, tolerance(0.005), tolerance(0.04)},
			{"tolerance, overlapping", -0.004, tolerance(0.001), tolerance(0.02)},
			{"sweep", 0.02, none, [](Settings& s, double r) { s.sweep.linear = {0.03 * r, 0.03 * r, 0.03 * r}; }},
			{"distance", 0.1, none, [](Settings& s, double) { s.distance = true; }},
			{"error of the gap", 0.005, none, [](Settings& s, double) { s.gapError = 0; }},
			{"contacts only", -0.004, none, [](Settings& s, double) { s.contactsOnly = true; }},
			{"coarsening", 0.005, none, [](Settings& s, double) { s.metric.coarsening = 50; }},
			{"coarsening without end", 0.005, size(0.001), [](Settings& s, double) { s.metric.coarsening = kOff; }},
			{"exact", 0.005, none, [](Settings& s, double) { s.metric.exact = true; }},
			{"size", 0.005, size(0.035), size(0.001)},
			{"certified error", 0.005, none, [](Settings& s, double r) { s.metric.maxError = 1e-3 * r; }},
			{"velocity", 0.005, velocity(0), velocity(1)},
			{"view", 0.005, view(2), view(500)},
			{"own", 0.005, own(fine), own(coarse)}};
}

// There and back, at the very pose and a hair from it.
TEST(StaleAnswers, EverySettingThatChangesIsAnsweredAnew)
{
	const BodyPair pair{body("torus", 900), body("torus", 900)};
	const double radius = smallerRadius(pair.a, pair.b);
	const OwnThreshold fine = [radius](const Place&) { return 1e-3 * radius; };
	const OwnThreshold coarse = [radius](const Place&) { return 0.3 * radius; };
	for (const Change& change : changes(fine, coarse))
		for (const double hair : {0.0, 1e-9})
			for (const bool contactsOnly : {false, true})
			{
				Random random(72);
				int others = 0;
				for (int i = 0; i < 6; ++i)
				{
					Settings settings;
					settings.tolerance = 0.01 * radius;
					settings.metric.weightedDeviation = 0.035 * radius;
					settings.contactsOnly = contactsOnly;
					if (std::string(change.name) == "distance") settings.contactsOnly = false;
					Settings after = settings;
					change.before(settings, radius);
					change.after(after, radius);
					if (after.metric.velocity.time < kOff || after.metric.view.pixels < kOff || after.metric.own)
						settings.metric.weightedDeviation = after.metric.weightedDeviation = kOff;
					History history{pair, poseWithGap(random, pair.a, pair.b, change.gap), settings};
					std::optional<GapResult> last;
					for (int turn = 0; turn < 5; ++turn)
					{
						history.settings = turn % 2 == 0 ? settings : after;
						history.pose.translation += hair * radius * Vec3{1, 0, 0};
						ASSERT_EQ(history.ask(), "") << change.name << ", hair " << hair << ", turn " << turn;
						others += last && !difference(*last, history.result).empty();
						last = history.result;
					}
				}
				// Where only contacts are asked for, some settings change nothing.
				EXPECT_TRUE(others > 6 || contactsOnly) << change.name << ", hair " << hair << ": " << others;
			}
}
}  // namespace
