// SPDX-License-Identifier: Zlib
#include "clod/distance/SurfaceDistance.h"

#include "clod/distance/Constants.h"
#include "clod/query/HullCull.h"

namespace clod
{
namespace
{
struct DistanceJudge
{
	const QueryContext& context;
	QueryStats& stats;
	VisitedPairs& visited;
	double best = std::numeric_limits<double>::infinity();
	static constexpr bool nearestFirst = true;

	// The ways to a pair differ in their largest separation. Nearest first, a pair's first turn comes by the least.
	static bool counts(NearestPairScratch::Candidate& pair, double above)
	{
		pair.separation = std::max(pair.separation, above);
		return true;
	}
	bool takes(const NearestPairScratch::Candidate& pair)
	{
		visited.reserve(1);
		return visited.insert(pair.a, pair.b);
	}
	bool isSettled() const { return best <= 0; }
	static bool affords(std::size_t) { return true; }
	static bool mayAnswer(const NearestPairScratch::Candidate&) { return false; }
	double limit() const { return best; }
	double ofPair(const NearestPairScratch::Candidate& pair) const
	{
		++stats.hullTests;
		const HullDistance distance = canonicalDistance(context, pair.a, pair.b, best);
		return distance.lower <= best ? std::max(pair.separation, distance.upper) : best;
	}
};

// Of pairs of leaves: they form a tree, each is met once.
struct LeafJudge
{
	const QueryContext& context;
	QueryStats& stats;
	double best;
	SeparatingAxes& axes;
	static constexpr bool nearestFirst = false;

	static bool counts(const NearestPairScratch::Candidate&, double) { return true; }
	static bool takes(const NearestPairScratch::Candidate&) { return true; }
	static bool affords(std::size_t) { return true; }
	static bool mayAnswer(const NearestPairScratch::Candidate&) { return false; }
	double limit() const { return best; }

protected:
	// From the canonical start, unless a cached axis shows that the distance is beyond `best`: then that is what comes
	// back, and no more. Tried are the pair's own axis and the last one of the smaller leaf: what that is near lies
	// much the same way.
	HullDistance distanceOf(const NearestPairScratch::Candidate& pair)
	{
		++stats.hullTests;
		const std::uint32_t a = pair.a, b = pair.b;
		const bool isASmaller = context.a.cullBox(a).radius <= context.b.cullBox(b).radius;
		const std::uint32_t keyA = isASmaller ? a : SeparatingAxes::kNobody;
		const std::uint32_t keyB = isASmaller ? SeparatingAxes::kNobody : b;
		SeparatingAxes::Entry &ofPair = axes.at(a, b), &ofSmaller = axes.at(keyA, keyB);
		HullDistance far;
		far.upper = std::numeric_limits<double>::infinity();
		const auto isFar = [&](const Float3& axis)
		{
			far.lower = separationAlong(contactHull(context.a, context.a.node(a)),
										contactHull(context.b, context.b.node(b)), context.pose, toVec3(axis));
			return isBeyond(context, a, b, far.lower, best);
		};
		if (ofPair.isOf(a, b) && isFar(ofPair.axis)) return far;
		if (ofSmaller.isOf(keyA, keyB) && isFar(ofSmaller.axis))
		{
			ofPair = {a, b, ofSmaller.axis};
			return far;
		}
		const HullDistance distance = canonicalDistance(context, a, b, kBeyondBest * best);
		if (distance.lower > best)
		{
			ofSmaller = {keyA, keyB, toFloat3(distance.normal)};
			ofPair = {a, b, ofSmaller.axis};
		}
		return distance;
	}
};

struct SurfaceJudge : LeafJudge
{
	NearestPair& nearest;
	double value = std::numeric_limits<double>::infinity();

	bool isSettled() const { return best <= 0; }
	double ofPair(const NearestPairScratch::Candidate& pair)
	{
		const HullDistance distance = distanceOf(pair);
		if (distance.lower > best) return best;
		if (distance.upper < value) nearest = {pair.a, pair.b};
		value = std::min(value, distance.upper);
		if (distance.upper <= 0) return 0;
		return distance.upper + (double(context.a.node(pair.a).protrude) + double(context.b.node(pair.b).protrude));
	}
};

struct GatherJudge : LeafJudge
{
	std::vector<Contact>& pairs;

	static bool isSettled() { return false; }
	double ofPair(const NearestPairScratch::Candidate& pair)
	{
		const HullDistance d = distanceOf(pair);
		if (d.lower <= best) pairs.push_back({pair.a, pair.b, d.lower, d.upper, d.pointOnA, d.pointOnB, d.normal});
		return best;
	}
};
}  // namespace

double closestDistance(const QueryContext& context, const StopRule& rule, NearestPairScratch& scratch,
					   QueryStats& stats)
{
	scratch.visited.clear();
	DistanceJudge judge{context, stats, scratch.visited};
	NearestPairSearch<DistanceJudge>(context, rule, judge, scratch, stats).run();
	return judge.best;
}

SurfaceDistance surfaceDistance(const QueryContext& context, double known, SurfaceSearchScratch& scratch,
								QueryStats& stats)
{
	const StopRule rule = StopRule::ofLeaves(context);
	const std::uint32_t before = stats.hullTests;
	SurfaceJudge judge{{context, stats, known, scratch.axes}, scratch.nearest};
	const auto [a, b] = scratch.nearest;
	if (isAnswer(context, rule, scratch.nearest)) judge.best = std::min(known, judge.ofPair({0, a, b}));
	NearestPairSearch<SurfaceJudge>(context, rule, judge, scratch, stats).run();
	scratch.axes.reserve(stats.hullTests - before);
	// No bracket is wider than an evaluation's accuracy, and what was not evaluated is beyond the best.
	const double low = std::min(judge.value, judge.best) - kHullDistanceAccuracy * context.size;
	return {judge.best > 0 ? std::max(0.0, low) : 0, judge.best, judge.value};
}

void gatherLeafPairs(const QueryContext& context, double tolerance, SurfaceSearchScratch& scratch,
					 std::vector<Contact>& pairs, QueryStats& stats)
{
	pairs.clear();
	GatherJudge judge{{context, stats, tolerance, scratch.axes}, pairs};
	NearestPairSearch<GatherJudge>(context, StopRule::ofLeaves(context), judge, scratch, stats).run();
}
}  // namespace clod
