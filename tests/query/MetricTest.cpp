// SPDX-License-Identifier: GPL-3.0-or-later
// The error metrics: each threshold at its corners, combinations, refusals, and what a query makes of them.
#include "clod/query/Metric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

double thresholdAt(const Metric& metric, const Vec3& center, double radius = 0)
{
	return Threshold(metric, kAnySpeed).at({center, radius});
}

Metric moving(double time, double floor)
{
	Metric metric;
	metric.velocity = {time, floor, {3, 0, 0}, {0, 0, 2}};
	return metric;
}

// A camera of 90 degrees and 100 pixels: a pixel covers 0.02 at distance 1.
Metric seen(double pixels, const Vec3& eye, double nearest = 0.5)
{
	Metric metric;
	metric.view = {pixels, eye, 0.02, nearest};
	return metric;
}

const BodyPair& toruses()
{
	static const BodyPair pair = {body("torus", 900), body("torus", 900)};
	return pair;
}

TEST(Threshold, VelocityIsProportionalToTheSpeedAtThePlaceWithAFloor)
{
	const Metric metric = moving(0.1, 0.05);
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {}), 0.1 * 3);
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {0, 4, 0}), 0.1 * 5);     // 3 - 2 * 4 = -5 along x
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {0, 1.5, 0}), 0.05);      // the instantaneous axis
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {0, 4, 0}, 1), 0.1 * 3);  // the slowest point of a ball
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {0, 4, 0}, 3), 0.05);     // a ball that reaches beyond the axis
	EXPECT_DOUBLE_EQ(thresholdAt(moving(0, 0.05), {0, 4, 0}), 0.05);
	const Threshold slow(metric, 0.5);
	ASSERT_TRUE(slow.isConstant());
	EXPECT_EQ(slow.constant(), 0.05);
	EXPECT_FALSE(Threshold(metric, 0.6).isConstant());
}

TEST(Threshold, ViewFollowsEquationFour)
{
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 10}), {}), 3 * 10 * 0.02);
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 10}), {}, 4), 3 * 6 * 0.02);   // the nearest point of a ball
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, -10}), {}), 3 * 10 * 0.02);    // behind: as far as in front
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 0}), {}), 3 * 0.5 * 0.02);     // the eye at the contact
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 0.2}), {}), 3 * 0.5 * 0.02);   // before the near plane
	EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 1}), {}, 2), 3 * 0.5 * 0.02);  // inside the ball
	EXPECT_EQ(thresholdAt(seen(0, {0, 0, 10}), {}), 0);
}

// The near plane is the nearest that anything is seen from; without one the eye at a contact asks for all there is.
TEST(Threshold, AnEyeAtBehindOrInsideTheContactSeesItFromTheNearPlane)
{
	for (const double nearest : {0.0, 0.5})
	{
		const double closest = 3 * nearest * 0.02;
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 0}, nearest), {}), closest);           // at a point
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 0}, nearest), {}, 2), closest);        // in the middle of a ball
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 1}, nearest), {}, 2), closest);        // inside it
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, -1}, nearest), {}, 2), closest);       // inside, on the other side
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 2}, nearest), {}, 2), closest);        // on it
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, 5}, nearest), {}, 2), 3 * 3 * 0.02);   // before it
		EXPECT_DOUBLE_EQ(thresholdAt(seen(3, {0, 0, -5}, nearest), {}, 2), 3 * 3 * 0.02);  // behind it
	}
	EXPECT_GT(thresholdAt(seen(1e-3, {0, 0, 0}, 0.5), {}), 0);  // a near plane leaves any N > 0 something
}

TEST(Threshold, StrictTakesTheSmallestRelaxedTheLargest)
{
	Metric metric = moving(0.1, 0.05);       // 0.3 at the origin
	metric.view = seen(1, {0, 0, 10}).view;  // 0.2
	metric.weightedDeviation = 0.25;
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {}), 0.2);
	metric.combine = Combine::kRelaxed;
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {}), 0.3);
	const OwnThreshold own = [](const Place& place) { return 0.4 + place.radius; };
	metric.own = &own;
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {}, 0.01), 0.41);
	metric.combine = Combine::kStrict;
	EXPECT_DOUBLE_EQ(thresholdAt(metric, {}), 0.2);
}

TEST(Threshold, NothingUsedAsksForNothing)
{
	for (const Combine combine : {Combine::kStrict, Combine::kRelaxed})
	{
		Metric metric;
		metric.combine = combine;
		const Threshold threshold(metric, 1);
		ASSERT_TRUE(threshold.isConstant());
		EXPECT_EQ(threshold.constant(), kOff);
	}
	// A metric that is not used does not loosen a relaxed one.
	Metric metric;
	metric.combine = Combine::kRelaxed;
	metric.weightedDeviation = 0.1;
	EXPECT_EQ(Threshold(metric, 1).constant(), 0.1);
}

TEST(Threshold, AnOwnFunctionThatFailsCountsAsZero)
{
	for (const double answer : {std::nan(""), -1.0, -kOff})
	{
		const OwnThreshold own = [answer](const Place&) { return answer; };
		Metric metric;
		metric.own = &own;
		EXPECT_EQ(thresholdAt(metric, {}), 0);
	}
}

// Contact area and resolution at their ends: a file never holds D = 0 (the loader refuses it), the rule is defined all
// the same. Resolution is inside f = s / r^2: r = 0 is stored as the f of the whole body, s = 0 as f = 0.
TEST(StopRule, WeightedDeviationIsDefinedForZeroAreaAndZeroVolume)
{
	Node fine{}, coarse{};
	fine.featureVolume = 0;
	fine.contactArea = 0;
	EXPECT_EQ(StopRule::weightedDeviation(fine, fine), 0);
	coarse.featureVolume = 2;
	coarse.contactArea = 0;
	EXPECT_EQ(StopRule::weightedDeviation(coarse, coarse), kOff);
	fine.contactArea = coarse.contactArea = 4;
	EXPECT_DOUBLE_EQ(StopRule::weightedDeviation(coarse, fine), 2 * (0.25 + 0.25));
}

TEST(Metric, RefusesWhatCannotBeUsedByName)
{
	const double nan = std::nan("");
	const auto with = [](auto change)
	{
		Metric metric = moving(0.1, 0.05);
		metric.view = seen(1, {}).view;
		change(metric);
		return metricError(metric);
	};
	EXPECT_EQ(with([](Metric&) {}), "");
	const auto expectNamed = [](const std::string& error, const char* field)
	{ EXPECT_NE(error.find(field), std::string::npos) << "'" << error << "' names no " << field; };
	for (const double bad : {nan, -1.0})
	{
		expectNamed(with([bad](Metric& m) { m.weightedDeviation = bad; }), "weightedDeviation");
		expectNamed(with([bad](Metric& m) { m.maxError = bad; }), "maxError");
		expectNamed(with([bad](Metric& m) { m.velocity.time = bad; }), "velocity.time");
		expectNamed(with([bad](Metric& m) { m.velocity.floor = bad; }), "velocity.floor");
		expectNamed(with([bad](Metric& m) { m.view.pixels = bad; }), "view.pixels");
		expectNamed(with([bad](Metric& m) { m.view.pixelSize = bad; }), "view.pixelSize");
		expectNamed(with([bad](Metric& m) { m.view.nearest = bad; }), "view.nearest");
	}
	expectNamed(with([](Metric& m) { m.view.pixelSize = 1 / 0.0; }), "view.pixelSize");  // an image of no pixels
	expectNamed(with([nan](Metric& m) { m.velocity.linear.y = nan; }), "velocity.linear");
	expectNamed(with([nan](Metric& m) { m.velocity.angular.z = nan; }), "velocity.angular");
	expectNamed(with([nan](Metric& m) { m.view.eye.x = nan; }), "view.eye");
}

struct CoarseContacts
{
	std::size_t count = 0, tooCoarse = 0;
};

// A witness point of every contact lies in its place: no contact is coarser than `promised` allows there, its formulas
// written down again, for points.
CoarseContacts coarseContacts(const Metric& used, const Metric& promised)
{
	Random random(21);
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	const auto allowed = [&](const Vec3& point)
	{
		const VelocityThreshold& v = promised.velocity;
		const ViewThreshold& w = promised.view;
		if (v.time < kOff) return std::max(v.floor, v.time * length(v.linear + cross(v.angular, point)));
		return w.pixels * w.pixelSize * std::max(w.nearest, length(w.eye - point));
	};
	CoarseContacts found;
	for (int i = 0; i < 24; ++i)
	{
		const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.01, 0.01));
		Settings settings;
		settings.metric = used;
		settings.tolerance = 0.02 * radius;
		for (const Contact& contact : fresh(pair, pose, settings).contacts)
		{
			const Node &a = pair.a.hierarchy->node(contact.nodeA), &b = pair.b.hierarchy->node(contact.nodeB);
			if (a.childCount == 0 && b.childCount == 0) continue;
			++found.count;
			const double s0 = std::max(allowed(contact.pointOnA), allowed(contact.pointOnB));
			found.tooCoarse += StopRule::weightedDeviation(a, b) > s0;
		}
	}
	return found;
}

void expectKept(const Metric& metric, const Metric& looser)
{
	const CoarseContacts contacts = coarseContacts(metric, metric);
	EXPECT_EQ(contacts.tooCoarse, 0u) << "of " << contacts.count;
	EXPECT_GT(contacts.count, 50u);
	EXPECT_GT(coarseContacts(looser, metric).tooCoarse, 0u);  // the check sees a planted fault
}

TEST(Metric, NoContactIsCoarserThanItsSpeedAllows)
{
	const double radius = smallerRadius(toruses().a, toruses().b);
	Metric metric, looser;
	metric.velocity = {1, 1e-3 * radius, {0.05 * radius, 0, 0}, {0, 0.1, 0.05}};
	looser.velocity = {30, 1e-3 * radius, {0.05 * radius, 0, 0}, {0, 0.1, 0.05}};
	expectKept(metric, looser);
}

TEST(Metric, NoContactIsCoarserThanItsDistanceAllows)
{
	const double radius = smallerRadius(toruses().a, toruses().b);
	const Vec3 eye = {0, 0, 3 * radius};
	expectKept(seen(1, eye, 0.01 * radius), seen(30, eye, 0.01 * radius));
}

// The eye beside one of two contacts of a pair: that one is finer, in the same query.
TEST(Metric, TheNearerContactIsFiner)
{
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	// Two toruses on each other touch all round.
	Settings settings;
	settings.metric.exact = true;
	settings.distance = true;
	Transform pose;
	pose.translation = {0, 1.2 * radius, 0};
	for (int i = 0; i < 50; ++i)
	{
		const double gap = fresh(pair, pose, settings).minDistance;
		if (gap < 1e-3 * radius) break;
		pose.translation.y -= 0.9 * gap;
	}
	settings = Settings{};
	settings.tolerance = 0.05 * radius;
	settings.metric = seen(1, {radius, 0.3 * radius, 0}, 0);
	double levels[2] = {0, 0};
	int counts[2] = {0, 0};
	for (const Contact& contact : fresh(pair, pose, settings).contacts)
	{
		const int far = contact.pointOnA.x < 0 ? 1 : 0;
		levels[far] += pair.a.hierarchy->node(contact.nodeA).level + pair.b.hierarchy->node(contact.nodeB).level;
		++counts[far];
	}
	ASSERT_GT(counts[0], 5);
	ASSERT_GT(counts[1], 5);
	EXPECT_LT(levels[0] / counts[0] + 0.5, levels[1] / counts[1]);
}

// The eye in a contact: what it lies in is of the input surface, unless a near plane keeps it away.
TEST(Metric, AnEyeInAContactAsksForTheInputSurfaceWithoutANearPlane)
{
	Random random(26);
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	int inside = 0, coarse = 0;
	for (int i = 0; i < 12; ++i)
	{
		const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0, 0.005));
		Settings settings = exactSettings(0.02 * radius);
		const GapResult exact = fresh(pair, pose, settings);
		ASSERT_FALSE(exact.contacts.empty());
		const Vec3 eye = exact.contacts[0].pointOnA;
		for (const double nearest : {0.0, 0.1 * radius})
		{
			settings.metric = seen(10, eye, nearest);
			for (const Contact& contact : fresh(pair, pose, settings).contacts)
			{
				const Node &a = pair.a.hierarchy->node(contact.nodeA), &b = pair.b.hierarchy->node(contact.nodeB);
				const double deviation = StopRule::weightedDeviation(a, b);
				const OrientedBox &boxA = pair.a.hierarchy->cullBox(contact.nodeA),
							  &boxB = pair.b.hierarchy->cullBox(contact.nodeB);
				const bool isA = boxA.radius <= boxB.radius;  // the place is the ball of the smaller box
				const Vec3 center = isA ? centerOf(boxA) : pose * centerOf(boxB);
				if (length(eye - center) > double(isA ? boxA.radius : boxB.radius)) continue;
				inside += nearest == 0;
				coarse += nearest > 0 && deviation > 0;
				const bool isOfLeaves = a.childCount == 0 && b.childCount == 0;
				EXPECT_TRUE(isOfLeaves || deviation <= 10 * nearest * 0.02) << "near plane " << nearest / radius;
			}
		}
	}
	EXPECT_GT(inside, 10);
	EXPECT_GT(coarse, 10);
}

TEST(Metric, AtRestTheVelocityMetricIsItsFloor)
{
	Random random(22);
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	for (int i = 0; i < 6; ++i)
	{
		const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.01, 0.01));
		Settings floor, rest;
		floor.tolerance = rest.tolerance = 0.01 * radius;
		floor.metric.weightedDeviation = 0.003 * radius;
		rest.metric.velocity = {0.3 / 240, 0.003 * radius, {1e-3 * radius, 0, 0}, {0, 1e-3, 0}};
		const GapResult expected = fresh(pair, pose, floor), result = fresh(pair, pose, rest);
		EXPECT_EQ(difference(result, expected), "");
		EXPECT_EQ(result.stats.boxTests, expected.stats.boxTests);
		EXPECT_EQ(result.stats.hullTests, expected.stats.hullTests);
		// Moving never costs more than resting.
		rest.metric.velocity.linear = {300 * radius, 0, 0};
		const GapResult fast = fresh(pair, pose, rest);
		EXPECT_LE(fast.stats.frontInner, expected.stats.frontInner);
	}
}

double largestErrorApart(const BodyPair& pair, const GapResult& result)
{
	double largest = 0;
	for (const Contact& contact : result.contacts)
		largest = std::max(
			largest, certifiedErrorApart(pair.a.hierarchy->node(contact.nodeA), pair.b.hierarchy->node(contact.nodeB)));
	return largest;
}

// Of the gap, and of every contact.
TEST(Metric, MaxErrorIsAHardLimitUnderEveryCombination)
{
	Random random(23);
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	for (int i = 0; i < 12; ++i)
	{
		const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0, 0.01));
		Settings settings;
		settings.tolerance = 0.02 * radius;
		settings.metric = seen(1000, {0, 0, 100 * radius});
		settings.metric.combine = i % 2 ? Combine::kRelaxed : Combine::kStrict;
		settings.metric.weightedDeviation = 10 * radius;
		const GapResult coarse = fresh(pair, pose, settings);  // whose hulls may be too far apart for a contact
		const double loose = coarse.contacts.empty() ? coarse.errorBound : largestErrorApart(pair, coarse);
		settings.metric.maxError = 0.002 * radius;
		const GapResult result = fresh(pair, pose, settings);
		EXPECT_TRUE(result.deep || result.errorBound <= settings.metric.maxError);
		EXPECT_GT(loose, settings.metric.maxError);
		EXPECT_LE(largestErrorApart(pair, result), settings.metric.maxError);
	}
}

// Metrics that change from step to step, and with the pose: caches never show.
TEST(Metric, CachedEqualsFreshUnderChangingMetrics)
{
	Random random(24);
	const BodyPair& pair = toruses();
	const double radius = smallerRadius(pair.a, pair.b);
	double share = 0.01;
	const OwnThreshold own = [&](const Place& place) { return share * (radius + std::abs(place.center.x)); };
	GapCache cache;
	GapResult result;
	Settings settings;
	Transform pose = poseWithGap(random, pair.a, pair.b, 0);
	int withContacts = 0, coarse = 0;
	for (int step = 0; step < 600; ++step)
	{
		const double size = std::pow(10, uniform(random, -6, -2));
		if (random() % 60 == 0)
			pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.02, 0.02));
		else if (random() % 8)
		{
			pose.rotation = randomRotation(random, size) * pose.rotation;
			pose.translation += size * radius * randomDirection(random);
		}
		if (step % 20 == 0)
		{
			settings = Settings{};
			settings.tolerance = uniform(random, 0, 0.02) * radius;
			const std::uint64_t used = random() % 16;
			if (used & 1) settings.metric.weightedDeviation = std::pow(10, uniform(random, -3, 0)) * radius;
			if (used & 2) settings.metric.velocity = {0.3, std::pow(10, uniform(random, -4, -2)) * radius, {}, {}};
			if (used & 4) settings.metric.view = {uniform(random, 0, 3), {}, 0.01, 0.01 * radius};
			if (used & 8) settings.metric.own = &own;
			if (random() % 2) settings.metric.combine = Combine::kRelaxed;
			if (random() % 3 == 0) settings.metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
			settings.contactsOnly = random() % 2;
		}
		const Vec3 direction = randomDirection(random);
		settings.metric.velocity.linear = std::pow(10, uniform(random, -6, 0)) * radius * direction;
		settings.metric.velocity.angular = size * randomDirection(random);
		if (random() % 4) settings.metric.view.eye = randomVector(random, 0, 5 * radius);
		share = std::pow(10, uniform(random, -4, 0));
		query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
		ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "") << "step " << step;
		withContacts += !result.contacts.empty();
		coarse += result.stats.coarsestLevel > 0;
	}
	EXPECT_GT(withContacts, 200);
	EXPECT_GT(coarse, 100);
}
}  // namespace
