// SPDX-License-Identifier: Zlib
// Branch and bound for the nearest pair of nodes, from the roots and without a front, so that what it finds is a
// function of the pose: depth first, the nearest child first, or the nearest pair of all first. What is nearest, a judge
// says (SeparationCache.cpp, distance/SurfaceDistance.cpp).
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "clod/query/PairFront.h"
#include "clod/query/QueryContext.h"
#include "clod/query/StopRule.h"

namespace clod
{
// Found last: tried first next time, prunes at once, and decides nothing else.
struct NearestPair
{
	std::uint32_t a = kNone, b = kNone;
};
struct NearestPairScratch
{
	struct Candidate
	{
		double separation;  // of the culling volumes
		std::uint32_t a, b;
	};
	std::vector<Candidate> stack;  // or a heap, the nearest at its front
	VisitedPairs visited;
};

// Judge: bool nearestFirst                      - of all pairs met, not only of the children met last;
//        double best                            - no pair beyond it is looked for;
//        bool counts(Candidate, double above)   - meets a pair: is it to be looked at? May raise its separation to that
//                                                 of the pair above;
//        bool takes(Candidate)                  - its turn has come: still to be looked at?
//        bool isSettled()                       - whatever else there is makes no difference;
//        double limit()                         - pairs whose boxes are farther apart have nothing up to `best`;
//        bool affords(std::size_t)              - so many more boxes may be compared; if not, the search is over;
//        bool mayAnswer(const Candidate&)       - counts as an accepted one even where it is not, but opened;
//        double ofPair(const Candidate&)        - of an accepted pair.
template <class Judge>
class NearestPairSearch
{
	using Candidate = NearestPairScratch::Candidate;

public:
	NearestPairSearch(const QueryContext& context, const StopRule& rule, Judge& judge, NearestPairScratch& scratch,
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
			if (!answers && !open(top)) return;
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
	// False where the judge cannot afford it.
	bool open(const Candidate& pair)
	{
		const bool opensA = m_rule.opensA(pair.a, pair.b);
		const Span<std::uint32_t> children = m_rule.childrenOf(opensA, opensA ? pair.a : pair.b);
		if (!m_judge.affords(children.size)) return false;
		const std::size_t first = m_stack.size();
		for (std::uint32_t i = 0; i < children.size; i += kBoxLanes)
			push(opensA, opensA ? pair.b : pair.a, children.data + i,
				 std::min(kBoxLanes, std::uint32_t(children.size) - i), pair.separation);
		if (!Judge::nearestFirst) std::sort(m_stack.begin() + std::ptrdiff_t(first), m_stack.end(), isFarther);
		return true;
	}

	// Pairs of `other` and nodes of the other body, of A or not.
	void push(bool areOfA, std::uint32_t other, const std::uint32_t* nodes, std::uint32_t count, double above)
	{
		m_stats.boxTests += count;
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

// Of these hierarchies, and at these settings: what a cache holds may be of others.
inline bool isAnswer(const QueryContext& context, const StopRule& rule, const NearestPair& pair)
{
	return pair.a < context.a.nodes().size && pair.b < context.b.nodes().size &&
		   rule.acceptance(pair.a, pair.b) == Acceptance::kYes;
}
}  // namespace clod
