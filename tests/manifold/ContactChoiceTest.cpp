// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs that are not clipped cost nothing in what is chosen: against the same choice from all points of all pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "clod/manifold/ContactClusters.h"
#include "tests/query/Questions.h"

namespace clod::test
{
namespace
{
// Two bodies about in touch, moving towards or along each other, as an adapter asks for their contacts.
struct Touch
{
	const Hierarchy *a, *b;
	Transform aFromB;
	PointRules rules;
	ClusterRules clusters;
	GapResult result;
};

// The same bodies with the same motion elsewhere.
Touch touchAt(const Transform& aFromB, const Touch& touch)
{
	Touch moved = touch;
	moved.aFromB = aFromB;
	Settings settings = exactSettings(touch.rules.margin + touch.rules.resting);
	settings.sweep = {-kPredictionSlack * touch.rules.motion.linear, -kPredictionSlack * touch.rules.motion.angular};
	settings.contactsOnly = true;
	GapCache cache;
	query(*moved.a, *moved.b, aFromB, settings, cache, moved.result);
	return moved;
}

// Every third stands still; the others go up to 10^fastest radii in the step.
Touch touchOf(Random& random, const BodyPair& pair, int i, double fastest = -1.7)
{
	Touch touch;
	touch.a = pair.a.hierarchy.get();
	touch.b = pair.b.hierarchy.get();
	const double radius = smallerRadius(pair.a, pair.b);
	touch.aFromB = poseWithGap(random, pair.a, pair.b, uniform(random, -0.002, 0.002));
	touch.rules.length = touch.clusters.length = radius;
	touch.rules.resting = kRestingShare * radius;
	touch.rules.margin = touch.clusters.margin = kSkinShare * radius;
	const double speed = i % 3 == 0 ? 0 : std::pow(10, uniform(random, -4, fastest)) * radius;
	touch.rules.motion = {speed * randomDirection(random), speed / radius * randomDirection(random), 1};
	return touchAt(touch.aFromB, touch);
}

void start(CandidatePool& pool, const Touch& touch)
{
	pool.start(*touch.a, *touch.b, touch.aFromB, touch.result.contacts, touch.rules);
}
void clipAll(CandidatePool& pool)
{
	for (std::uint32_t i = 0; i < pool.pairs().size(); ++i)
		if (!pool.isClipped(i)) pool.clip(i);
}

auto fieldsOf(const ContactPoint& p)
{
	const auto of = [](const Vec3& v) { return std::make_tuple(v.x, v.y, v.z); };
	return std::make_tuple(p.faceA, p.faceB, of(p.pointOnA), of(p.pointOnB), of(p.normal), p.height, p.predicted);
}
using Points = std::multiset<decltype(fieldsOf(ContactPoint{}))>;
Points pointsFrom(const CandidatePool& pool, std::size_t first)
{
	Points points;
	for (std::size_t i = first; i < pool.points().size(); ++i) points.insert(fieldsOf(pool.points()[i]));
	return points;
}

double lowestOf(const ClusterSet& set)
{
	double lowest = 1e9;
	for (const ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
			lowest = std::min(lowest, cluster.points[std::size_t(i)].point.predicted);
	return lowest;
}

bool holds(const ClusterSet& set, const ContactPoint& point, const ClusterRules& rules)
{
	for (const ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
		{
			const ContactPoint& other = cluster.points[std::size_t(i)].point;
			if (length(other.pointOnA - point.pointOnA) <= 2 * rules.clusterRadius * rules.length &&
				dot(other.normal, point.normal) >= 0.8)
				return true;
		}
	return false;
}
// How many points of a set another has too.
int inTheSamePlaces(const ClusterSet& set, const ClusterSet& other)
{
	std::set<std::pair<double, double>> places;
	const auto nameOf = [](const ContactPoint& point) { return std::pair(point.pointOnA.x, point.pointOnA.y); };
	const auto visit = [](const ClusterSet& of, const auto& see)
	{
		for (const ContactCluster& cluster : of.slots)
			for (int i = 0; i < cluster.count; ++i) see(cluster.points[std::size_t(i)].point);
	};
	visit(other, [&](const ContactPoint& point) { places.insert(nameOf(point)); });
	int count = 0;
	visit(set, [&](const ContactPoint& point) { count += places.count(nameOf(point)) > 0 ? 1 : 0; });
	return count;
}
}  // namespace

// Clipped in parts, a pair gives points of the whole: the same faces the same, and about a place all of them.
TEST(CandidatePool, PartsOfAPairGiveItsPoints)
{
	Random random(31);
	int parts = 0, nearParts = 0, near = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 120; ++i)
		{
			const Touch touch = touchOf(random, pair, i);
			CandidatePool whole, part;
			start(whole, touch);
			start(part, touch);
			for (std::uint32_t k = 0; k < whole.pairs().size(); ++k)
			{
				const std::size_t first = whole.points().size();
				whole.clip(k);
				const Points all = pointsFrom(whole, first);
				if (all.empty()) continue;
				const ContactPoint point = whole.points()[first + random() % (whole.points().size() - first)];
				const auto isPart = [&](std::size_t from)
				{
					const Points some = pointsFrom(part, from);
					EXPECT_GT(some.count(fieldsOf(point)), 0U);
					EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
				};
				std::size_t before = part.points().size();
				part.clipAsBefore(point);
				isPart(before);
				// Dropped, a point stays so when its faces are clipped again.
				for (std::size_t j = before; j < part.points().size(); ++j)
					if (fieldsOf(part.points()[j]) == fieldsOf(point)) part.drop(std::uint32_t(j));
				const std::size_t again = part.points().size();
				part.clipAsBefore(point);
				for (std::size_t j = again; j < part.points().size(); ++j)
					EXPECT_TRUE(!(fieldsOf(part.points()[j]) == fieldsOf(point)) || part.isDropped(std::uint32_t(j)));
				// What the step carries there is not looked for where it is now.
				if (i % 3 != 0 || point.height > touch.rules.resting) continue;
				before = part.points().size();
				const double unit = 0.001 * touch.rules.length;
				const PointClipper::Near place{point.pointOnA, point.pointOnB, unit, 2 * unit, 4 * unit};
				++parts;
				if (!part.isNear(k, place)) continue;
				++nearParts;
				part.clip(k, &place);
				isPart(before);
				for (std::size_t j = first; j < whole.points().size(); ++j)
				{
					const ContactPoint& other = whole.points()[j];
					if (length(other.pointOnA - place.onA) > 0.5 * unit || other.height > touch.rules.resting) continue;
					EXPECT_EQ(pointsFrom(part, before).count(fieldsOf(other)), all.count(fieldsOf(other)));
					++near;
				}
			}
		}
	EXPECT_GT(parts, 200);
	EXPECT_GE(nearParts, parts * 99 / 100);  // feet of prisms over sharp edges lie beyond their nodes
	EXPECT_GT(near, parts);
}

// What stands for the points of a pair: about the lowest of them, and for none only where there is none, or hardly.
TEST(CandidatePool, EstimatesTellTheLowestPoint)
{
	Random random(32);
	std::vector<double> lowerBy;
	int unlikely = 0, wrong = 0;
	const BodyPair cupAndSpoon{body("cup", 3000), body("spoon", 3000)};
	for (const BodyPair& pair : {pairs()[0], cupAndSpoon})
		for (int i = 0; i < 600; ++i)
		{
			const Touch touch = touchOf(random, pair, i, -1);
			CandidatePool pool;
			start(pool, touch);
			for (std::uint32_t k = 0; k < pool.pairs().size(); ++k)
			{
				const std::size_t first = pool.points().size();
				pool.clip(k);
				double lowest = 1e9;
				for (std::size_t j = first; j < pool.points().size(); ++j)
					lowest = std::min(lowest, pool.points()[j].predicted);
				const PairEstimate& estimate = pool.pairs()[k];
				if (!estimate.isLikely)
				{
					++unlikely;
					wrong += lowest < 0 ? 1 : 0;
				}
				else if (lowest < 1e9)
					lowerBy.push_back((estimate.lowest - lowest) / touch.rules.length);
			}
		}
	ASSERT_GT(lowerBy.size(), 1000U);
	std::sort(lowerBy.begin(), lowerBy.end());
	EXPECT_GT(lowerBy[lowerBy.size() / 2], -0.01);
	EXPECT_LT(lowerBy[lowerBy.size() * 95 / 100], 0.0005);
	EXPECT_LT(lowerBy[lowerBy.size() * 99 / 100], 0.002);
	EXPECT_GT(unlikely, 20);
	EXPECT_LE(wrong, unlikely / 50);
}

// The deepest point is among the chosen, and every place that all points would give is held, though at rest many pairs
// are not clipped once there is something to remember.
TEST(ContactReducer, ChoosesAsFromAllPoints)
{
	Random random(33);
	int poses = 0, higher = 0, thenHigher = 0, fewer = 0, places = 0, missing = 0;
	std::size_t pairsSeen = 0, clipped = 0;
	std::vector<BodyPair> all = pairs();
	all.push_back({body("cup", 3000), body("spoon", 3000)});
	for (const BodyPair& pair : all)
		for (int i = 0; i < 100; ++i)
		{
			const Touch touch = touchOf(random, pair, i);
			ContactReducer reducer;
			ClusterSet none, eagerly, some, again;
			CandidatePool eager, lazy, next;
			start(eager, touch);
			clipAll(eager);
			reducer.reduce(eager, none, touch.clusters, eagerly);
			start(lazy, touch);
			reducer.reduce(lazy, none, touch.clusters, some);
			EXPECT_EQ(eagerly.pointCount() > 0, some.pointCount() > 0);
			carryWithB(some, Transform{});
			start(next, touch);
			reducer.reduce(next, some, touch.clusters, again);
			// Where both remember the same, after a step that nobody expected.
			Transform deeper = sweptPose(touch.aFromB, randomSweep(random, 0.05 * touch.rules.length), 1);
			deeper.translation += 0.002 * touch.rules.length * some.slots[0].normal;
			const Touch moved = touchAt(deeper, touch);
			ClusterSet then, eagerlyThen;
			start(lazy, moved);
			reducer.reduce(lazy, some, touch.clusters, then);
			start(eager, moved);
			clipAll(eager);
			reducer.reduce(eager, some, touch.clusters, eagerlyThen);
			thenHigher += lowestOf(then) > lowestOf(eagerlyThen) + 0.0005 * touch.rules.length ? 1 : 0;
			if (i % 3 == 0) pairsSeen += next.pairs().size();
			for (std::uint32_t k = 0; k < next.pairs().size(); ++k) clipped += i % 3 == 0 && next.isClipped(k) ? 1 : 0;
			if (eagerly.pointCount() == 0) continue;
			++poses;
			higher += lowestOf(some) > lowestOf(eagerly) + 0.0005 * touch.rules.length ? 1 : 0;
			fewer += some.pointCount() < eagerly.pointCount() ? 1 : 0;
			for (const ContactCluster& cluster : eagerly.slots)
				for (int k = 0; k < cluster.count; ++k)
				{
					++places;
					missing += holds(again, cluster.points[std::size_t(k)].point, touch.clusters) ? 0 : 1;
				}
		}
	EXPECT_GT(poses, 150);
	EXPECT_LE(higher, poses / 50);
	EXPECT_EQ(thenHigher, 0);
	EXPECT_LE(fewer, poses / 10);
	EXPECT_LE(missing, places / 50);
	EXPECT_LT(3 * clipped, 2 * pairsSeen);
}

// A point that bears a load goes on: at the same pose it is the same, whether the faces that made it are known or not,
// and where the bodies creep it has a successor.
TEST(ContactReducer, FollowsLoadedPoints)
{
	Random random(34);
	int loaded = 0, kept = 0, same = 0, found = 0;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 100; ++i)
		{
			const Touch touch = touchOf(random, pair, 0);
			ContactReducer reducer;
			const ClusterSet none;
			ClusterSet before;
			CandidatePool pool;
			start(pool, touch);
			reducer.reduce(pool, none, touch.clusters, before);
			if (before.pointCount() == 0) continue;
			for (ContactCluster& cluster : before.slots)
				for (ClusterPoint& point : cluster.points) point.impulse = 1;
			const auto next = [&](ClusterSet& old, const Transform& pose)
			{
				carryWithB(old, pose * inverse(touch.aFromB));
				const Touch moved = touchAt(pose, touch);
				ClusterSet after;
				start(pool, moved);
				reducer.reduce(pool, old, touch.clusters, after);
				return after;
			};
			same += inTheSamePlaces(next(before, touch.aFromB), before);
			ClusterSet lost = before;
			for (ContactCluster& cluster : lost.slots)
				for (ClusterPoint& point : cluster.points) point.point.nodeA = point.point.nodeB = kNone;
			found += inTheSamePlaces(next(lost, touch.aFromB), before);
			Transform pose = touch.aFromB;
			pose.translation += 0.002 * touch.rules.length * cross(randomDirection(random), before.slots[0].normal);
			const ClusterSet after = next(before, pose);
			std::set<std::uint32_t> continued;
			for (const ContactCluster& cluster : after.slots)
				for (int k = 0; k < cluster.count; ++k) continued.insert(cluster.points[std::size_t(k)].previous);
			continued.erase(kNone);
			loaded += before.pointCount();
			kept += int(continued.size());
		}
	EXPECT_GT(loaded, 200);
	EXPECT_GE(kept, loaded * 8 / 10) << kept << " of " << loaded;
	EXPECT_GE(same, loaded * 95 / 100) << same << " of " << loaded;
	EXPECT_GE(found, loaded * 97 / 100) << found << " of " << loaded;
}
}  // namespace clod::test
