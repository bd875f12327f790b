// SPDX-License-Identifier: GPL-3.0-or-later
// The query against brute force: leaf pairs, signed gap, certificate, cache, pruning, monotony, allocation.
// CLOD_WALK_STEPS and CLOD_POSES lengthen the random tests.
#include "clod/query/Query.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "clod/query/MotionBound.h"
#include "clod/query/QueryContext.h"
#include "tests/query/Answers.h"
#include "tests/query/TriangleGap.h"

namespace
{
using namespace clod;
using namespace clod::test;

int setting(const char* name, int standard)
{
	const char* text = std::getenv(name);
	return text ? std::atoi(text) : standard;
}

std::vector<BodyPair> pairs()
{
	return {{body("torus", 900), body("torus", 900)},
			{body("number8", 600), body("sphere", 300)},
			{body("box", 12), body("torus", 900)}};
}

Settings exactSettings(double tolerance)
{
	Settings settings;
	settings.metric.exact = true;
	settings.tolerance = tolerance;
	return settings;
}

// Gap of the smaller radius: a third apart, a third within 1 %, a third overlapping.
double stratifiedGap(Random& random, int i)
{
	if (i % 3 == 0) return uniform(random, 0.011, 0.3);
	if (i % 3 == 1) return uniform(random, 0, 0.01);
	return -uniform(random, 0, i % 2 ? 0.01 : 0.1);
}

TEST(Query, ExactEqualsBruteForceOverAllLeafPairs)
{
	Random random(1);
	std::size_t contacts = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 9; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			const double tolerance = uniform(random, 0, 0.05) * smallerRadius(pair.a, pair.b);
			const QueryResult result = fresh(pair, pose, exactSettings(tolerance));
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			std::size_t found = 0;
			for (std::uint32_t a = 0; a < pair.a.hierarchy->levels()[0].nodeCount; ++a)
				for (std::uint32_t b = 0; b < pair.b.hierarchy->levels()[0].nodeCount; ++b)
				{
					const HullDistance distance = canonicalDistance(context, a, b, tolerance);
					if (distance.lower > tolerance) continue;
					ASSERT_LT(found, result.contacts.size());
					const Contact expected{
						a, b, distance.lower, distance.upper, distance.pointOnA, distance.pointOnB, distance.normal};
					EXPECT_TRUE(sameBits(expected, result.contacts[found])) << pair.a.name << " " << a << "," << b;
					++found;
				}
			EXPECT_EQ(found, result.contacts.size());
			contacts += found;
		}
	EXPECT_GT(contacts, 100u);
}

// The certificate, against triangles. Returns a reason, or nothing.
std::string broken(const QueryResult& result, const GapInterval& truth, double tolerance)
{
	if (result.errorBound == std::numeric_limits<double>::infinity()) return {};
	if (result.minDistance == std::numeric_limits<double>::infinity())
		return truth.high > tolerance - result.errorBound - 1e-9 ? "" : "said to be beyond the tolerance";
	if (result.minDistance - result.errorBound > truth.high + 1e-8) return "gap is smaller than certified";
	if (result.minDistance + result.errorBound < truth.low - 1e-8) return "gap is larger than certified";
	return {};
}

struct BoundCounts
{
	int apart = 0, near = 0, overlapping = 0, unproven = 0, broken = 0;
	std::vector<double> shares;  // of the bounds in the certified deviations of the pair that is nearest
};

double deviationOfNearest(const BodyPair& pair, const QueryResult& result)
{
	const Contact& nearest = *std::min_element(result.contacts.begin(), result.contacts.end(),
											   [](const Contact& l, const Contact& r) { return l.upper < r.upper; });
	return double(pair.a.hierarchy->node(nearest.nodeA).deviation) +
		   double(pair.b.hierarchy->node(nearest.nodeB).deviation);
}

void checkBounds(const Settings& settings, std::uint64_t seed, BoundCounts& counts)
{
	Random random(seed);
	const int poses = setting("CLOD_POSES", 12);
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < poses; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			Settings scaled = settings;
			scaled.tolerance = 0.01 * radius;
			scaled.metric.weightedDeviation *= radius;
			scaled.metric.maxError *= radius;
			const QueryResult result = fresh(pair, pose, scaled);
			const GapInterval truth = triangleGap(pair.a.triangles, pair.b.triangles, pose, 1e-3 * radius);
			const std::string reason = broken(result, truth, scaled.tolerance);
			EXPECT_EQ(reason, "") << pair.a.name << "-" << pair.b.name << " pose " << i << ": "
								  << result.minDistance / radius << " +- " << result.errorBound / radius << ", truth "
								  << truth.low / radius << " to " << truth.high / radius << " of the radius, contacts "
								  << result.contacts.size();
			++(truth.high <= 0 ? counts.overlapping : truth.low > scaled.tolerance ? counts.apart : counts.near);
			counts.unproven += result.errorBound == std::numeric_limits<double>::infinity();
			if (!result.contacts.empty()) counts.shares.push_back(result.errorBound / deviationOfNearest(pair, result));
			EXPECT_TRUE(result.deep || result.errorBound <= scaled.metric.maxError)
				<< result.errorBound / radius << " after " << result.stats.restarts << " restarts";
			if (result.deep && !scaled.distance && scaled.metric.exact)
			{
				EXPECT_LT(truth.low, -0.98 * scaled.tolerance);
			}
			if (scaled.metric.exact && scaled.distance)
			{
				EXPECT_LE(result.errorBound, 0.01 * std::abs(result.minDistance) + 3e-4 * radius);
			}
		}
	std::printf("apart %d, near %d, overlapping %d, unproven %d\n", counts.apart, counts.near, counts.overlapping,
				counts.unproven);
	EXPECT_GT(counts.apart, 0);
	EXPECT_GT(counts.near, 0);
	EXPECT_GT(counts.overlapping, 0);
}

TEST(Certificate, HoldsInExactMode)
{
	BoundCounts counts;
	checkBounds(exactSettings(0), 2, counts);
}
TEST(Certificate, HoldsInExactModeAtAnyDistanceAndDepth)
{
	BoundCounts counts;
	Settings settings = exactSettings(0);
	settings.distance = true;
	checkBounds(settings, 3, counts);
	EXPECT_EQ(counts.unproven, 0);
}
TEST(Certificate, HoldsWithWeightedDeviation)
{
	for (const double s0 : {0.035, 0.0035, 1.0})
	{
		BoundCounts counts;
		Settings settings;
		settings.metric.weightedDeviation = s0;
		checkBounds(settings, 4, counts);
		std::nth_element(counts.shares.begin(), counts.shares.begin() + std::ptrdiff_t(counts.shares.size() / 2),
						 counts.shares.end());
		const double median = counts.shares[counts.shares.size() / 2];
		std::printf("s0 %g: bound / deviation of the nearest pair, median %.2f of %zu\n", s0, median,
					counts.shares.size());
	}
}
TEST(Certificate, HoldsWithMaxError)
{
	for (const double limit : {0.05, 0.005})
	{
		BoundCounts counts;
		Settings settings;
		settings.metric.maxError = limit;
		checkBounds(settings, 5, counts);
	}
}

TEST(Certificate, TheCheckSeesPlantedFaults)
{
	QueryResult result;
	result.minDistance = 1;
	result.errorBound = 0.1;
	EXPECT_EQ(broken(result, {0.95, 0.95}, 0.5), "");
	EXPECT_NE(broken(result, {0.85, 0.85}, 0.5), "");
	EXPECT_NE(broken(result, {1.15, 1.15}, 0.5), "");
	result.minDistance = std::numeric_limits<double>::infinity();
	EXPECT_NE(broken(result, {-0.2, 0.2}, 0.5), "");
	EXPECT_EQ(broken(result, {0.45, 0.45}, 0.5), "");
}

TEST(TriangleGap, KnowsTwoBoxes)
{
	const Body& box = body("box", 12);
	const Vec3 half =
		toVec3({box.hierarchy->asset().boxMax[0], box.hierarchy->asset().boxMax[1], box.hierarchy->asset().boxMax[2]});
	Transform pose;
	pose.translation = {2 * half.x + 0.25 * half.x, 0, 0};
	const double accuracy = 1e-3 * half.x;
	EXPECT_NEAR(triangleGap(box.triangles, box.triangles, pose, accuracy).low, 0.25 * half.x, 1e-5 * half.x);
	pose.translation = {2 * half.x - 0.1 * half.x, 0.3 * half.y, 0.2 * half.z};
	const GapInterval deep = triangleGap(box.triangles, box.triangles, pose, accuracy);
	EXPECT_LE(deep.low, -0.1 * half.x + 1e-5 * half.x);
	EXPECT_GE(deep.high, -0.1 * half.x - 1e-5 * half.x);
	EXPECT_LT(deep.high - deep.low, 3 * accuracy);
}

// Random motion of a step: up to a tenth of the radius, half of it by turning.
Sweep randomSweep(Random& random, double radius)
{
	const double size = std::pow(10, uniform(random, -4, -1));
	return {size * radius * randomDirection(random), size * randomDirection(random)};
}

TEST(Query, CachedEqualsFreshBitForBit)
{
	Random random(6);
	const int steps = setting("CLOD_WALK_STEPS", 500);
	int withContacts = 0, deep = 0, stillClear = 0;
	std::uint64_t cachedTests = 0, freshTests = 0;
	for (const BodyPair& pair : pairs())
	{
		const double radius = smallerRadius(pair.a, pair.b);
		PairCache cache;
		QueryResult result;
		Settings settings = exactSettings(0.01 * radius);
		Transform pose = poseWithGap(random, pair.a, pair.b, 0);
		for (int step = 0; step < steps; ++step)
		{
			const double size = std::pow(10, uniform(random, -6, -1));
			if (random() % 40 == 0)
				pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.05, 0.05));
			else if (random() % 10)
			{
				pose.rotation = randomRotation(random, size) * pose.rotation;
				pose.translation += size * radius * randomDirection(random);
			}
			if (random() % 30 == 0)
			{
				settings = Settings{};
				settings.tolerance = uniform(random, 0, 0.03) * radius;
				settings.metric.exact = random() % 3 == 0;
				if (random() % 2) settings.metric.weightedDeviation = std::pow(10, uniform(random, -4, 0)) * radius;
				if (random() % 3 == 0) settings.metric.maxError = std::pow(10, uniform(random, -3, -1)) * radius;
				settings.distance = random() % 3 == 0;
				settings.contactsOnly = !settings.distance && random() % 2;
			}
			// Half of the steps look ahead, mostly along a motion that changes little.
			if (random() % 20 == 0) settings.sweep = random() % 2 ? randomSweep(random, radius) : Sweep{};
			if (!settings.sweep.isZero())
				settings.sweep.linear += 1e-3 * length(settings.sweep.linear) * randomDirection(random);
			if (random() % 100 == 0) cache.clear();
			query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
			const QueryResult expected = fresh(pair, pose, settings);
			ASSERT_EQ(difference(result, expected), "")
				<< pair.a.name << " step " << step << ": " << result.minDistance << " +- " << result.errorBound
				<< " deep " << result.deep << ", fresh " << expected.minDistance << " +- " << expected.errorBound
				<< ", contacts " << result.contacts.size() << ", exact " << settings.metric.exact << ", distance "
				<< settings.distance << ", restarts " << result.stats.restarts << "," << expected.stats.restarts
				<< ", point queries " << result.stats.pointQueries << "," << expected.stats.pointQueries;
			withContacts += !result.contacts.empty();
			deep += result.deep;
			stillClear += int(result.stats.stillClear);
			cachedTests += result.stats.boxTests;
			freshTests += expected.stats.boxTests;
		}
	}
	std::printf("%d steps with contacts, %d deep, %d still clear, box tests %.0f %% of fresh\n", withContacts, deep,
				stillClear, 100.0 * double(cachedTests) / double(freshTests));
	EXPECT_GT(withContacts, steps);
	EXPECT_GT(stillClear, steps / 20);
	EXPECT_LT(cachedTests, freshTests);
}

// Bodies that come near each other, turning, past each other or into contact: not looked at while they are apart, and
// no step too long.
TEST(Query, BodiesApartAreLeftAloneUntilTheyCanTouch)
{
	Random random(16);
	int stillClear = 0, total = 0, contacts = 0;
	for (const BodyPair& pair : pairs())
		for (int approach = 0; approach < setting("CLOD_APPROACHES", 6); ++approach)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings = exactSettings(0.01 * radius);
			settings.metric.exact = approach % 3 == 0;
			if (approach % 3 == 1) settings.metric.weightedDeviation = 0.1 * radius;
			if (approach % 3 == 2) settings.metric.maxError = 0.05 * radius;
			settings.contactsOnly = true;
			if (approach % 2) settings.sweep.linear = 0.002 * radius * randomDirection(random);
			Transform pose = poseWithGap(random, pair.a, pair.b, 0.2);
			const Vec3 towards = -normalized(pose.translation);
			PairCache cache;
			QueryResult result;
			for (int step = 0; step < 150; ++step)
			{
				pose.rotation = randomRotation(random, 1e-3) * pose.rotation;
				pose.translation += 0.002 * radius * (towards + 0.3 * randomDirection(random));
				query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
				ASSERT_EQ(difference(result, fresh(pair, pose, settings)), "")
					<< pair.a.name << " approach " << approach << " step " << step;
				stillClear += int(result.stats.stillClear);
				contacts += !result.contacts.empty();
				++total;
			}
		}
	std::printf("%d queries, %d still clear, %d with contacts\n", total, stillClear, contacts);
	EXPECT_GT(stillClear, total / 3);
	EXPECT_GT(contacts, total / 10);
}

TEST(Query, TheComparisonSeesOneBit)
{
	const BodyPair pair = pairs()[0];
	Random random(7);
	const Transform pose = poseWithGap(random, pair.a, pair.b, -0.001);
	const QueryResult result = fresh(pair, pose, exactSettings(0.01 * smallerRadius(pair.a, pair.b)));
	ASSERT_FALSE(result.contacts.empty());
	QueryResult fault = result;
	fault.contacts.back().upper = std::nextafter(fault.contacts.back().upper, 1e300);
	EXPECT_EQ(difference(result, result), "");
	EXPECT_NE(difference(result, fault), "");
	fault = result;
	fault.contacts.pop_back();
	EXPECT_NE(difference(result, fault), "");
}

// B's frame when a share of the sweep is done: points move on straight lines, so this is no rotation.
Transform sweptPose(const Transform& pose, const Sweep& sweep, double share)
{
	Transform moved = pose;
	const Mat3 columns = transposed(pose.rotation);
	Mat3 turned;
	for (int i = 0; i < 3; ++i) turned.row[i] = columns.row[i] + share * cross(sweep.angular, columns.row[i]);
	moved.rotation = transposed(turned);
	moved.translation += share * sweep.of(pose.translation);
	return moved;
}

TEST(BoxSeparation, IsALowerBoundAndLipschitz)
{
	Random random(8);
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		const double radius = smallerRadius(pair.a, pair.b);
		for (int i = 0; i < 600; ++i)
		{
			Transform pose{randomRotation(random), uniform(random, 0, 2) * radius * randomDirection(random)};
			const std::uint32_t n = std::uint32_t(random() % a.nodes().size),
								m = std::uint32_t(random() % b.nodes().size);
			Sweep sweep = i % 2 ? randomSweep(random, radius) : Sweep{};
			const auto separation = [&](const QueryContext& context)
			{ return boxSeparation(context.boxes, a.cullBox(n), b.cullBox(m)); };
			const QueryContext here(a, b, pose, sweep);
			const double before = separation(here);
			for (const double share : {0.0, 0.3, 0.7, 1.0})
			{
				const QueryContext onTheWay(a, b, sweptPose(pose, sweep, share));
				EXPECT_LE(before, canonicalDistance(onTheWay, n, m, 1e300).upper) << share;
			}
			EXPECT_LE(separation(here), separation(QueryContext(a, b, pose)));
			pose.rotation = randomRotation(random, 0.05) * pose.rotation;
			pose.translation += 0.02 * radius * randomDirection(random);
			const Sweep old = sweep;
			if (i % 2) sweep.linear += 0.1 * length(sweep.linear) * randomDirection(random);
			if (i % 4 == 3) sweep.angular += 0.1 * length(sweep.angular) * randomDirection(random);
			const QueryContext there(a, b, pose, sweep);
			const double motion = motionBound(here.pose, there.pose, here.reachA, here.reachB);
			const double change = sweepChange(here.pose, old, there.pose, sweep, motion, here.reachB);
			EXPECT_LE(std::abs(separation(there) - before), motion + change + here.boxes.roundingOfTwo());
		}
	}
}

TEST(BoxSeparation, IsTheSameInEveryLaneFromEitherSideOnAnyMachine)
{
	Random random(9);
	for (const BodyPair& pair : pairs())
	{
		const Hierarchy &a = *pair.a.hierarchy, &b = *pair.b.hierarchy;
		const double radius = smallerRadius(pair.a, pair.b);
		for (int i = 0; i < 400; ++i)
		{
			const Transform pose{randomRotation(random), uniform(random, 0, 2) * radius * randomDirection(random)};
			const QueryContext context(a, b, pose, i % 2 ? randomSweep(random, radius) : Sweep{});
			const CullBox& one = a.cullBox(std::uint32_t(random() % a.nodes().size));
			const CullBox* others[kBoxLanes];
			for (const CullBox*& other : others) other = &b.cullBox(std::uint32_t(random() % b.nodes().size));
			const std::uint32_t count = 1 + std::uint32_t(random() % kBoxLanes);
			float row[kBoxLanes], plain[kBoxLanes], single[kBoxLanes];
			boxSeparations(context.boxes, one, true, others, count, row);
			boxSeparationsPlain(context.boxes, one, true, others, count, plain);
			for (std::uint32_t k = 0; k < count; ++k)
			{
				const CullBox* const ofA[] = {&one};
				boxSeparations(context.boxes, *others[k], false, ofA, 1, single);
				ASSERT_EQ(row[k], plain[k]);
				ASSERT_EQ(row[k], single[0]);
			}
		}
	}
}

TEST(Hierarchy, WideChildrenReachEveryLeafOnce)
{
	for (const BodyPair& pair : pairs())
		for (const Hierarchy* h : {pair.a.hierarchy.get(), pair.b.hierarchy.get()})
		{
			std::vector<std::uint32_t> open{h->root()};
			std::vector<int> reached(h->nodes().size, 0);
			while (!open.empty())
			{
				const std::uint32_t node = open.back();
				open.pop_back();
				++reached[node];
				EXPECT_EQ(h->wideChildren(node).empty(), h->node(node).childCount == 0);
				EXPECT_LE(h->wideChildren(node).size,
						  std::max<std::size_t>(kWideChildren, h->node(node).primaryChildCount));
				for (const std::uint32_t child : h->wideChildren(node)) open.push_back(child);
			}
			for (std::uint32_t node = 0; node < h->levels()[0].nodeCount; ++node) EXPECT_EQ(reached[node], 1) << node;
		}
}

// Leaf pairs that come within the tolerance somewhere on B's way, by brute force.
std::size_t missingOnTheWay(const BodyPair& pair, const Transform& pose, const Settings& settings,
							const QueryResult& result, std::size_t& onlyOnTheWay)
{
	std::size_t missing = 0;
	for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
	{
		const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, sweptPose(pose, settings.sweep, share));
		for (std::uint32_t a = 0; a < pair.a.hierarchy->levels()[0].nodeCount; ++a)
			for (std::uint32_t b = 0; b < pair.b.hierarchy->levels()[0].nodeCount; ++b)
			{
				if (canonicalDistance(context, a, b, settings.tolerance).upper > settings.tolerance) continue;
				const bool found =
					std::any_of(result.contacts.begin(), result.contacts.end(),
								[&](const Contact& contact) { return contact.nodeA == a && contact.nodeB == b; });
				missing += !found;
				onlyOnTheWay += found && share > 0;
			}
	}
	return missing;
}

TEST(Query, SweepFindsEveryPairOnTheWay)
{
	Random random(10);
	std::size_t onlyOnTheWay = 0, missedWithout = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 20; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, 0, 0.03));
			Settings settings = exactSettings(0.002 * radius);
			const QueryResult without = fresh(pair, pose, settings);
			settings.sweep = {0.03 * radius * randomDirection(random), 0.03 * randomDirection(random)};
			const QueryResult result = fresh(pair, pose, settings);
			EXPECT_EQ(missingOnTheWay(pair, pose, settings, result, onlyOnTheWay), 0u) << pair.a.name << " " << i;
			std::size_t ignored = 0;
			missedWithout += missingOnTheWay(pair, pose, settings, without, ignored);
		}
	EXPECT_GT(onlyOnTheWay, 50u);
	EXPECT_GT(missedWithout, 50u);  // the brute force sees what a query of the pose alone leaves out
}

TEST(Query, PrunesNothingWithinTheTolerance)
{
	// Whatever is within the tolerance by brute force over the nodes of each single level is found there too.
	Random random(9);
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 6; ++i)
		{
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			const double tolerance = 0.02 * smallerRadius(pair.a, pair.b);
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			double nearest = 1e300;
			for (const auto& s : pair.a.triangles)
				for (const auto& t : pair.b.triangles)
				{
					if (length(s[0] - pose * t[0]) > 3 * smallerRadius(pair.a, pair.b)) continue;
					nearest = std::min(nearest, triangleDistance(s, {pose * t[0], pose * t[1], pose * t[2]}));
				}
			for (const double s0 : {0.0, 0.01, 0.1})
			{
				Settings settings;
				settings.tolerance = tolerance;
				settings.metric.weightedDeviation = s0 * smallerRadius(pair.a, pair.b);
				const QueryResult result = fresh(pair, pose, settings);
				double lowest = tolerance;
				for (const Contact& contact : result.contacts)
					lowest = std::min(lowest, contact.lower - double(pair.a.hierarchy->node(contact.nodeA).cover) -
												  double(pair.b.hierarchy->node(contact.nodeB).cover));
				if (result.contacts.empty() && result.minDistance > 0) lowest = tolerance - result.errorBound;
				EXPECT_LE(lowest, nearest + 1e-9) << pair.a.name << " s0 " << s0;
			}
		}
}

TEST(Query, LargerThresholdNeverOpensMore)
{
	Random random(10);
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 6; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			std::uint32_t opened = kNone;
			for (double s0 = 1e-5; s0 < 10; s0 *= 2)
			{
				Settings settings;
				settings.tolerance = 0.01 * radius;
				settings.metric.weightedDeviation = s0 * radius;
				const QueryResult result = fresh(pair, pose, settings);
				EXPECT_LE(result.stats.frontInner, opened);
				opened = result.stats.frontInner;
			}
		}
}

TEST(Query, OneBodyInsideTheOtherIsNeverApart)
{
	const Body& small = body("number8", 600);
	const double ratio =
		4 * double(small.hierarchy->asset().radius) / double(body("sphere", 300).hierarchy->asset().radius);
	const Body& large = body("sphere", 300, {ratio, false});
	const double radius = small.hierarchy->asset().radius;
	for (const bool distance : {false, true})
	{
		Settings settings = exactSettings(0.001 * radius);
		settings.distance = distance;
		const QueryResult result = fresh({large, small}, Transform{}, settings);
		EXPECT_LT(result.minDistance, 0);
		EXPECT_TRUE(result.deep);
		EXPECT_EQ(std::isfinite(result.errorBound), distance);
	}
}

// Two ways to cull, one answer: hulls grown by their drift (paper eq. 1), or culling boxes.
TEST(Query, PaperCullingFindsTheSameLeafPairs)
{
	Random random(11);
	const Body& torus = body("torus", 900, {1, true});
	std::size_t contacts = 0;
	for (int i = 0; i < 6; ++i)
	{
		const Transform pose = poseWithGap(random, torus, torus, stratifiedGap(random, i));
		Settings settings = exactSettings(0.02 * smallerRadius(torus, torus));
		const QueryResult boxes = fresh({torus, torus}, pose, settings);
		settings.paper = true;
		ASSERT_EQ(settingsError(*torus.hierarchy, *torus.hierarchy, settings), "");
		EXPECT_EQ(difference(fresh({torus, torus}, pose, settings), boxes), "");
		contacts += boxes.contacts.size();
	}
	EXPECT_GT(contacts, 10u);
}

TEST(Query, RefusesBadSettings)
{
	const Hierarchy& h = *body("box", 12).hierarchy;
	Settings settings = exactSettings(0.1);
	EXPECT_EQ(settingsError(h, h, settings), "");
	settings.tolerance = -1;
	EXPECT_NE(settingsError(h, h, settings).find("tolerance"), std::string::npos);
	settings.tolerance = std::nan("");
	EXPECT_NE(settingsError(h, h, settings).find("tolerance"), std::string::npos);
	settings.tolerance = 0;
	settings.paper = true;
	EXPECT_NE(settingsError(h, h, settings).find("paper"), std::string::npos);
	settings.paper = false;
	settings.metric.maxError = -1;
	EXPECT_NE(settingsError(h, h, settings).find("maxError"), std::string::npos);
}
}  // namespace
