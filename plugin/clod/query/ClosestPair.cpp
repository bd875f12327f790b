// SPDX-License-Identifier: Zlib
// Branch and bound: depth first, the nearest child first, or the nearest pair of all first.
#include "clod/query/ClosestPair.h"

#include <algorithm>
#include <limits>

#include "clod/query/HullCull.h"

namespace clod
{
namespace
{
// Judge: bool paper;
//        bool nearestFirst                      - of all pairs met, not only of the children met last;
//        double best                            - no pair beyond it is looked for;
//        bool counts(Candidate, double above)   - meets a pair: is it to be looked at? May raise its separation to that
//                                                 of the pair above;
//        bool takes(Candidate)                  - its turn has come: still to be looked at?
//        bool isSettled()                       - whatever else there is makes no difference;
//        double limit()                         - pairs whose boxes are farther apart have nothing up to `best`;
//        bool mayAnswer(const Candidate&)       - counts as an accepted one even where it is not, but opened;
//        double ofPair(const Candidate&)        - of an accepted pair.
template <class Judge>
class ClosestPairSearch
{
	using Candidate = ClosestPairScratch::Candidate;

public:
	ClosestPairSearch(const QueryContext& context, const StopRule& rule, Judge& judge, ClosestPairScratch& scratch,
					  QueryStats& stats)
		: m_context(context), m_rule(rule), m_judge(judge), m_stack(scratch.stack), m_stats(stats)
	{
	}

	void run()
	{
		m_stack.clear();
		const std::uint32_t rootA = m_context.a.root();
		push(true, m_context.b.root(), &rootA, 1, 0);
		while (!m_stack.empty() && !m_judge.isSettled())
		{
			const Candidate top = next();
			if (top.separation > m_judge.limit() || !m_judge.takes(top)) continue;
			const bool answers = accepts(top);
			if (answers || m_judge.mayAnswer(top)) m_judge.best = std::min(m_judge.best, m_judge.ofPair(top));
			if (!answers) open(top);
		}
	}

private:
	static bool isFarther(const Candidate& l, const Candidate& r) { return l.separation > r.separation; }
	Candidate next()
	{
		if (Judge::nearestFirst) std::pop_heap(m_stack.begin(), m_stack.end(), isFarther);
		const Candidate top = m_stack.back();
		m_stack.pop_back();
		return top;
	}
	bool accepts(const Candidate& pair)
	{
		const Acceptance acceptance = m_rule.acceptance(pair.a, pair.b);
		if (acceptance != Acceptance::kWhileApart) return acceptance != Acceptance::kNo;
		++m_stats.hullTests;
		return canonicallyApart(m_context, pair.a, pair.b);
	}
	void open(const Candidate& pair)
	{
		const bool opensA = m_rule.opensA(pair.a, pair.b);
		const Span<std::uint32_t> children = m_rule.childrenOf(opensA, opensA ? pair.a : pair.b);
		const std::size_t first = m_stack.size();
		for (std::uint32_t i = 0; i < children.size; i += kBoxLanes)
			push(opensA, opensA ? pair.b : pair.a, children.data + i,
				 std::min(kBoxLanes, std::uint32_t(children.size) - i), pair.separation);
		if (!Judge::nearestFirst) std::sort(m_stack.begin() + std::ptrdiff_t(first), m_stack.end(), isFarther);
	}

	// Pairs of `other` and nodes of the other body, of A or not.
	void push(bool areOfA, std::uint32_t other, const std::uint32_t* nodes, std::uint32_t count, double above)
	{
		m_stats.boxTests += count;
		if (m_judge.paper)
		{
			for (std::uint32_t i = 0; i < count; ++i)
			{
				const std::uint32_t a = areOfA ? nodes[i] : other, b = areOfA ? other : nodes[i];
				const double separation = paperSeparation(m_context, a, b, m_judge.best);
				if (separation <= m_judge.limit()) meet({separation, a, b}, above);
			}
			return;
		}
		float separations[kBoxLanes];
		const float limit = roundDown(m_judge.limit());
		std::uint32_t within = boxSeparations(m_context, areOfA, other, nodes, count, separations, limit);
		for (; within != 0; within &= within - 1)
		{
			const int i = __builtin_ctz(within);
			meet({double(separations[i]), areOfA ? nodes[i] : other, areOfA ? other : nodes[i]}, above);
		}
	}
	void meet(Candidate pair, double above)
	{
		if (!m_judge.counts(pair, above)) return;
		m_stack.push_back(pair);
		if (Judge::nearestFirst) std::push_heap(m_stack.begin(), m_stack.end(), isFarther);
	}

	const QueryContext& m_context;
	const StopRule& m_rule;
	Judge& m_judge;
	std::vector<Candidate>& m_stack;
	QueryStats& m_stats;
};

struct DistanceJudge
{
	const QueryContext& context;
	QueryStats& stats;
	bool paper;
	VisitedPairs& visited;
	double best = std::numeric_limits<double>::infinity();
	static constexpr bool nearestFirst = true;

	// The ways to a pair differ in their largest separation. Nearest first, a pair's first turn comes by the least.
	static bool counts(ClosestPairScratch::Candidate& pair, double above)
	{
		pair.separation = std::max(pair.separation, above);
		return true;
	}
	bool takes(const ClosestPairScratch::Candidate& pair)
	{
		visited.reserve(1);
		return visited.insert(pair.a, pair.b);
	}
	bool isSettled() const { return best <= 0; }
	static bool mayAnswer(const ClosestPairScratch::Candidate&) { return false; }
	double limit() const { return best; }
	double ofPair(const ClosestPairScratch::Candidate& pair) const
	{
		++stats.hullTests;
		const HullDistance distance = canonicalDistance(context, pair.a, pair.b, best);
		return distance.lower <= best ? std::max(pair.separation, distance.upper) : best;
	}
};

struct MotionJudge
{
	const QueryContext& context;
	QueryStats& stats;
	const ClearOf& what;
	double best;
	ClosestPairScratch& scratch;
	static constexpr bool paper = false, nearestFirst = false;
	// Pairs that leave half as much to go as the best are not looked at, and half of the best is the answer: a fifth of
	// the tests, for a search a half more often (README.md).
	static constexpr double kShare = 0.5;

	// Once: its own separation is a bound whichever the way.
	bool counts(const ClosestPairScratch::Candidate& pair, double)
	{
		scratch.visited.reserve(1);
		return scratch.visited.insert(pair.a, pair.b);
	}
	static bool takes(const ClosestPairScratch::Candidate&) { return true; }
	bool isSettled() const { return best <= 0; }
	// Hulls that overlap now may answer as soon as they part.
	bool mayAnswer(const ClosestPairScratch::Candidate& pair) const
	{
		return what.relaxed.acceptance(pair.a, pair.b) != Acceptance::kNo;
	}
	double limit() const { return what.tolerance + kShare * best; }
	double ofPair(const ClosestPairScratch::Candidate& pair)
	{
		++stats.hullTests;
		const double reached =
			what.surfaces ? cullLimit(context.a.node(pair.a), context.b.node(pair.b), what.tolerance) : what.tolerance;
		const SweptBound bound = canonicalSweptBound(context, pair.a, pair.b, reached + best);
		const double motion = std::max(pair.separation - what.tolerance, bound.lower - reached);
		if (motion < best) scratch.ofMotion = {pair.a, pair.b};
		return motion;
	}
};

// Of pairs of leaves: they form a tree, each is met once.
struct LeafJudge
{
	const QueryContext& context;
	QueryStats& stats;
	double best;
	RememberedDirections& directions;
	static constexpr bool paper = false, nearestFirst = false;

	static bool counts(const ClosestPairScratch::Candidate&, double) { return true; }
	static bool takes(const ClosestPairScratch::Candidate&) { return true; }
	static bool mayAnswer(const ClosestPairScratch::Candidate&) { return false; }
	double limit() const { return best; }

protected:
	// From the canonical start, unless a remembered direction shows that the distance is beyond `best`: then that is
	// what comes back, and no more. Tried are the pair's own direction and the last one of the smaller leaf: what that
	// is near lies much the same way.
	HullDistance distanceOf(const ClosestPairScratch::Candidate& pair)
	{
		++stats.hullTests;
		const std::uint32_t a = pair.a, b = pair.b;
		const bool isASmaller = context.a.cullBox(a).radius <= context.b.cullBox(b).radius;
		const std::uint32_t keyA = isASmaller ? a : kNone, keyB = isASmaller ? kNone : b;
		RememberedDirections::Entry &ofPair = directions.at(a, b), &ofSmaller = directions.at(keyA, keyB);
		HullDistance far;
		far.upper = std::numeric_limits<double>::infinity();
		const auto isFar = [&](const RememberedDirections::Entry& known)
		{
			far.lower =
				separationAlong(contactHull(context.a, context.a.node(a)), contactHull(context.b, context.b.node(b)),
								context.pose, toVec3(known.direction));
			return far.lower > best + roomOf(context, a, b, best);
		};
		if (ofPair.isOf(a, b) && isFar(ofPair)) return far;
		if (ofSmaller.isOf(keyA, keyB) && isFar(ofSmaller))
		{
			ofPair = ofSmaller.with(a, b);
			return far;
		}
		// A little beyond: so the direction still tells at the next pose.
		const HullDistance distance = canonicalDistance(context, a, b, 1.1 * best);
		if (distance.lower > best)
		{
			const Vec3& n = distance.normal;
			ofSmaller = {keyA, keyB, {float(n.x), float(n.y), float(n.z)}};
			ofPair = ofSmaller.with(a, b);
		}
		return distance;
	}
};

struct SurfaceJudge : LeafJudge
{
	ClosestPairScratch::Nearest& nearest;
	double value = std::numeric_limits<double>::infinity();

	bool isSettled() const { return best <= 0; }
	double ofPair(const ClosestPairScratch::Candidate& pair)
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
	double ofPair(const ClosestPairScratch::Candidate& pair)
	{
		const HullDistance d = distanceOf(pair);
		if (d.lower <= best) pairs.push_back({pair.a, pair.b, d.lower, d.upper, d.pointOnA, d.pointOnB, d.normal});
		return best;
	}
};

// Of these hierarchies, and at these settings: what a cache holds may be of others.
bool isAnswer(const QueryContext& context, const StopRule& rule, const ClosestPairScratch::Nearest& pair)
{
	return pair.a < context.a.nodes().size && pair.b < context.b.nodes().size &&
		   rule.acceptance(pair.a, pair.b) == Acceptance::kYes;
}

StopRule leafRule(const QueryContext& context)
{
	Metric exact;
	exact.exact = true;
	return StopRule(context, exact, false);
}
}  // namespace

double closestDistance(const QueryContext& context, const StopRule& rule, bool paper, ClosestPairScratch& scratch,
					   QueryStats& stats)
{
	scratch.visited.clear();
	DistanceJudge judge{context, stats, paper, scratch.visited};
	ClosestPairSearch<DistanceJudge>(context, rule, judge, scratch, stats).run();
	return judge.best;
}

SurfaceDistance surfaceDistance(const QueryContext& context, double known, ClosestPairScratch& scratch,
								QueryStats& stats)
{
	const StopRule rule = leafRule(context);
	const std::uint32_t before = stats.hullTests;
	SurfaceJudge judge{{context, stats, known, scratch.directions}, scratch.ofSurfaces};
	const auto [a, b] = scratch.ofSurfaces;
	if (isAnswer(context, rule, scratch.ofSurfaces)) judge.best = std::min(known, judge.ofPair({0, a, b}));
	ClosestPairSearch<SurfaceJudge>(context, rule, judge, scratch, stats).run();
	scratch.directions.reserve(stats.hullTests - before);
	// No bracket is wider than an evaluation's accuracy, and what was not evaluated is beyond the best.
	const double low = std::min(judge.value, judge.best) - kHullDistanceAccuracy * context.size;
	return {judge.best > 0 ? std::max(0.0, low) : 0, judge.best, judge.value};
}

void gatherLeafPairs(const QueryContext& context, double tolerance, ClosestPairScratch& scratch,
					 std::vector<Contact>& pairs, QueryStats& stats)
{
	pairs.clear();
	GatherJudge judge{{context, stats, tolerance, scratch.directions}, pairs};
	ClosestPairSearch<GatherJudge>(context, leafRule(context), judge, scratch, stats).run();
}

double clearMotion(const QueryContext& context, const ClearOf& what, double cap, ClosestPairScratch& scratch,
				   QueryStats& stats)
{
	scratch.visited.clear();
	MotionJudge judge{context, stats, what, cap, scratch};
	const auto [a, b] = scratch.ofMotion;
	if (isAnswer(context, what.relaxed, scratch.ofMotion))
	{
		++stats.boxTests;
		judge.best = std::min(
			cap, judge.ofPair({boxSeparation(context.boxes, context.a.cullBox(a), context.b.cullBox(b)), a, b}));
	}
	ClosestPairSearch<MotionJudge>(context, what.strict, judge, scratch, stats).run();
	return judge.best > 0 ? MotionJudge::kShare * judge.best : judge.best;
}
}  // namespace clod
