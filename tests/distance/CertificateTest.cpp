// SPDX-License-Identifier: GPL-3.0-or-later
// The gap and its certified error against triangles: no bound may be exceeded. CLOD_POSES lengthens the tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>

#include "clod/collide/ConvexPolyhedron.h"
#include "clod/distance/DepthSearch.h"
#include "clod/distance/Penetration.h"
#include "clod/hierarchy/ConvexPiece.h"
#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"
#include "tests/query/TriangleGap.h"

namespace
{
using namespace clod;
using namespace clod::test;

struct BoundCounts
{
	int apart = 0, near = 0, overlapping = 0, unproven = 0, broken = 0;
	// The bounds in certified deviations of the pair that is nearest.
	std::vector<double> sharesApart, sharesOverlapping;
};

// The gap by triangles at the poses of a seed: asked for once, whatever the settings.
GapInterval truthOf(std::uint64_t seed, std::size_t index, const BodyPair& pair, const Transform& pose)
{
	static std::map<std::uint64_t, std::vector<GapInterval>> known;
	std::vector<GapInterval>& truths = known[seed];
	if (index == truths.size())
		truths.push_back(triangleGap(pair.a.triangles, pair.b.triangles, pose, 1e-3 * smallerRadius(pair.a, pair.b)));
	return truths.at(index);
}

void checkBounds(const Settings& settings, std::uint64_t seed, BoundCounts& counts)
{
	Random random(seed);
	const int poses = setting("CLOD_POSES", 48);
	std::size_t index = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < poses; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			Settings scaled = settings;
			scaled.tolerance = 0.01 * radius;
			scaled.metric.weightedDeviation *= radius;
			scaled.metric.maxError *= radius;
			const GapResult result = fresh(pair, pose, scaled);
			const GapInterval truth = truthOf(seed, index++, pair, pose);
			const std::string reason = broken(result, truth, scaled.tolerance);
			EXPECT_EQ(reason, "") << pair.a.name << "-" << pair.b.name << " pose " << i << ": "
								  << result.minDistance / radius << " +- " << result.errorBound / radius << ", truth "
								  << truth.low / radius << " to " << truth.high / radius << " of the radius, contacts "
								  << result.contacts.size();
			++(truth.high <= 0 ? counts.overlapping : truth.low > scaled.tolerance ? counts.apart : counts.near);
			counts.unproven += result.errorBound == std::numeric_limits<double>::infinity();
			if (!result.contacts.empty())
			{
				const double share =
					result.errorBound / deviationOfNearest(*pair.a.hierarchy, *pair.b.hierarchy, result);
				(truth.low > 0 ? counts.sharesApart : counts.sharesOverlapping).push_back(share);
			}
			EXPECT_TRUE(result.deep || result.errorBound <= scaled.metric.maxError)
				<< result.errorBound / radius << " after " << result.stats.gapSearches << " searches";
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
double medianOf(std::vector<double> values)
{
	const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
	std::nth_element(values.begin(), middle, values.end());
	return *middle;
}

std::vector<double> joined(std::vector<double> l, const std::vector<double>& r)
{
	l.insert(l.end(), r.begin(), r.end());
	return l;
}

// The bound is meant to be tight: its median at most 1.5 deviations of the nearest pair, while surfaces are apart and
// over all poses, at every threshold and over all of them.
TEST(Certificate, HoldsWithWeightedDeviation)
{
	constexpr double tight = 1.5;
	std::vector<double> all;
	for (const double s0 : {0.035, 0.0035, 1.0})
	{
		BoundCounts counts;
		Settings settings;
		settings.metric.weightedDeviation = s0;
		checkBounds(settings, 4, counts);
		const std::vector<double> shares = joined(counts.sharesApart, counts.sharesOverlapping);
		std::printf("s0 %g: bound / deviation of the nearest pair, median %.2f of %zu, apart %.2f of %zu\n", s0,
					medianOf(shares), shares.size(), medianOf(counts.sharesApart), counts.sharesApart.size());
		EXPECT_LE(medianOf(counts.sharesApart), tight) << s0;
		EXPECT_LE(medianOf(shares), tight) << s0;
		all = joined(all, shares);
	}
	std::printf("median of all %.2f\n", medianOf(all));
	EXPECT_LE(medianOf(all), tight);
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

// The gap within an error of its own: that of exact mode, whatever answers, and the contacts stay as they are.
TEST(Certificate, TheGapOfCoarseContactsIsAsExactAsAskedFor)
{
	Random random(32);
	const int poses = setting("CLOD_POSES", 48);
	int apart = 0, near = 0, overlapping = 0, coarser = 0, cutShort = 0, beyond = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 3 * poses; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, i));
			Settings settings = exactSettings(0.01 * radius);
			settings.distance = i % 2 == 0;
			settings.metric.maxError = 1e-6 * radius;  // of a depth that is searched
			const GapResult exact = fresh(pair, pose, settings);
			settings.metric = Metric{};
			settings.metric.weightedDeviation = (i % 4 < 2 ? 0.035 : 1) * radius;
			const GapResult before = fresh(pair, pose, settings);
			settings.gapError = i % 3 == 0 ? 0 : std::pow(10, uniform(random, -5, -2)) * radius;
			GapResult result = fresh(pair, pose, settings);
			const std::string where = pair.a.name + "-" + pair.b.name + " pose " + std::to_string(i);
			const double error = std::max(settings.gapError, 2e-6 * radius);
			cutShort += result.stats.depthsCutShort > 0;
			if (!result.deep && result.stats.depthsCutShort == 0)
			{
				EXPECT_LE(result.errorBound, error) << where;
			}
			if (exact.minDistance == std::numeric_limits<double>::infinity())
			{
				EXPECT_GT(result.minDistance, settings.tolerance - error) << where;
			}
			else if (result.minDistance == std::numeric_limits<double>::infinity())
			{
				EXPECT_GT(exact.minDistance + exact.errorBound, settings.tolerance - result.errorBound) << where;
				++beyond;
			}
			else if (!exact.deep && !result.deep)
			{
				EXPECT_NEAR(result.minDistance, exact.minDistance, error + exact.errorBound) << where;
			}
			const bool isKnown = exact.minDistance < std::numeric_limits<double>::infinity();
			if (settings.gapError == 0 && !exact.deep && isKnown && exact.minDistance > 0)
			{
				EXPECT_EQ(result.minDistance, exact.minDistance) << where;
			}
			++(exact.minDistance <= 0 ? overlapping : exact.contacts.empty() ? apart : near);
			coarser += before.errorBound > error;
			result.minDistance = before.minDistance;
			result.errorBound = before.errorBound;
			result.deep = before.deep;
			EXPECT_EQ(difference(result, before), "") << where;
		}
	std::printf(
		"apart %d, near %d, overlapping %d; by the nodes coarser %d; depths cut short %d; near, but beyond the "
		"tolerance as far as asked for %d\n",
		apart, near, overlapping, coarser, cutShort, beyond);
	EXPECT_LE(cutShort, overlapping / 1000);  // the limit of cells (README.md, Limits)
	EXPECT_GT(std::min({apart, near, overlapping, coarser}), poses / 2);
}

// Points are moved from one frame into the other: no depth is known better than that.
TEST(Certificate, ADepthHasRoomForRounding)
{
	Random random(45);
	int proven = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 100; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose{randomRotation(random), randomVector(random, 0.5 * radius, 2 * radius)};
			for (const bool distance : {false, true})
			{
				Settings settings = exactSettings(0.02 * radius);
				settings.distance = distance;
				const GapResult result = fresh(pair, pose, settings);
				if (!(result.minDistance < 0) || result.errorBound == kOff) continue;
				++proven;
				const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
				ASSERT_GE(result.errorBound, context.pose.rounding) << pair.a.name << ", pose " << i;
			}
		}
	EXPECT_GT(proven, 100);
}

TEST(Certificate, TheCheckSeesPlantedFaults)
{
	GapResult result;
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
// While two hulls are apart only cover and protrusion bound what their distance is wrong by (StopRule.h).
TEST(Certificate, PairsBeyondTheLimitOfAnOverlapAnswerOnlyApart)
{
	Random random(31);
	int onlyApart = 0, overlapping = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 60; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			Settings settings;
			settings.tolerance = 0.02 * radius;
			settings.metric.maxError = std::pow(10, uniform(random, -2, -0.5)) * radius;
			settings.contactsOnly = true;
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.02, 0.01));
			for (const Contact& contact : fresh(pair, pose, settings).contacts)
			{
				const Node &a = pair.a.hierarchy->node(contact.nodeA), &b = pair.b.hierarchy->node(contact.nodeB);
				ASSERT_LE(certifiedErrorApart(a, b), settings.metric.maxError);
				overlapping += contact.lower <= 0;
				if (certifiedError(a, b) <= settings.metric.maxError) continue;
				ASSERT_GT(contact.lower, 0) << pair.a.name << " pose " << i;
				++onlyApart;
			}
		}
	std::printf("%d contacts count as apart only, %d overlap\n", onlyApart, overlapping);
	EXPECT_GT(onlyApart, 50);
	EXPECT_GT(overlapping, 50);
}
// What is left aside as hardly deeper than the deepest found must count in the bound: with a coarse accuracy it does.
TEST(Certificate, ADepthKnownRoughlyIsStillBounded)
{
	Random random(81);
	int rough = 0;
	PenetrationScratch scratch;
	QueryStats stats;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 40; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, uniform(random, -0.3, -0.05));
			const QueryContext context(*pair.a.hierarchy, *pair.b.hierarchy, pose);
			DepthAccuracy fine, coarse;
			fine.relative = 1e-4;
			coarse.relative = 3;
			const DepthBound truth = wholePenetration(context, fine, scratch, stats);
			const DepthBound bound = wholePenetration(context, coarse, scratch, stats);
			ASSERT_LE(bound.lower, truth.upper + 1e-9 * radius) << pair.a.name << " pose " << i;
			ASSERT_GE(bound.upper, truth.lower - 1e-9 * radius) << pair.a.name << " pose " << i;
			rough += bound.upper > 1.1 * bound.lower;
		}
	EXPECT_GT(rough, 30);
}

// A convex body is one leaf, of as many faces as it has. Its depth is that of the search that knows no leaves, and takes
// few points where faces lie flat on each other.
TEST(Certificate, ConvexBodiesOfManyFacesAreOneLeaf)
{
	Random random(82);
	std::vector<Vec3> prism, pebble;
	for (int i = 0; i < 200; ++i)
		prism.push_back({std::cos(0.0314 * i), std::sin(0.0314 * i), i % 2 == 0 ? -0.4 : 0.4});
	for (int i = 0; i < 300; ++i) pebble.push_back(randomDirection(random));
	std::vector<Body> bodies;
	for (const auto& points : {prism, pebble})
		bodies.push_back(bodyOf("convex", convexPiece(convexPolyhedron(points, 65535), 0).value()));
	DepthAccuracy fine;
	fine.relative = 1e-4;
	PenetrationScratch scratch;
	for (int i = 0; i < 24; ++i)
	{
		const BodyPair pair{bodies[0], bodies[std::size_t(i % 2)]};
		Transform pose = poseWithGap(random, pair.a, pair.b, -uniform(random, 0.001, 0.2));
		if (i % 6 == 0) pose = {randomRotation(random, 1e-3), {0.1, 0.2, 0.795}};
		const GapResult result = fresh(pair, pose, exactSettings(0.5));
		QueryStats stats;
		const DepthBound truth =
			wholePenetration(QueryContext(*pair.a.hierarchy, *pair.b.hierarchy, pose), fine, scratch, stats);
		ASSERT_FALSE(result.deep) << i;
		EXPECT_LE(result.minDistance - result.errorBound, -truth.lower + 1e-9) << i;
		EXPECT_GE(result.minDistance + result.errorBound, -truth.upper - 1e-9) << i;
		EXPECT_LE(result.errorBound, 0.01 * std::abs(result.minDistance)) << i;
		EXPECT_LT(result.stats.pointQueries, i % 6 == 0 ? 1000u : 20000u) << i;
	}
}
}  // namespace
