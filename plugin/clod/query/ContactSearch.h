// SPDX-License-Identifier: Zlib
// One query in progress, from pose to accepted node pairs: what both entry points, contacts() and signedGap(), do
// first.
#pragma once
#include <memory>
#include <optional>

#include "clod/query/ContactSink.h"
#include "clod/query/InsideTest.h"
#include "clod/query/PairFront.h"
#include "clod/query/SeparationCache.h"

namespace clod
{
// What a pair's cache holds between queries.
struct PairCache::State
{
	const Hierarchy* a = nullptr;
	const Hierarchy* b = nullptr;
	std::uint64_t hashA = 0, hashB = 0;
	bool filled = false;
	double threshold = 0, maxError = 0;  // of the rule that the front was made with: constantThreshold, maxError
	BaseLevels base;                     // StopRule::base
	RelativePose pose;  // that the fronts have followed to,
	Sweep sweep;        // with this motion from there
	PairFront front;
	std::unique_ptr<PairFront> outline;  // of the coarsest valid answer, its pairs listed only; where there are budgets
	std::uint32_t quietFor = 0;  // queries that found nothing, one after the other
	std::uint32_t calmFor = kCalm;  // queries that moved by little, one after the other
	double lastMove = 0;  // of front.motion, what came since the last query
	double lastApproach = 0;  // approachBound since then
	SeparationCache separation;
	InsideProbes probesA, probesB;
	NearestPair nearest;

	void clearFronts()
	{
		front.clear();
		separation.forget();
		probesA.clear();
		probesB.clear();
	}
};

// Drops what was cached for other hierarchies, then adds the motion since the fronts were asked last.
void followMotion(const QueryContext& context, PairCache::State& state);

// Lists the pairs of the coarsest valid answer, unless that was done at this very pose. Precondition: motion was
// followed.
Outline outline(const QueryContext& context, double tolerance, PairCache::State& state);

struct TraversalSettings;

class ContactSearch
{
public:
	ContactSearch(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
				  const AskedGap& gap, PairCache::State& state, ContactResult& result);
	ContactSearch(const ContactSearch&) = delete;
	ContactSearch& operator=(const ContactSearch&) = delete;

	// Nothing is near, by what was found before: there is nothing to run.
	bool isStillApart() const { return m_isStillApart; }
	// Fills the contact list, sorted. False: a trial that failed. Precondition: not still apart.
	bool run() { return run(m_settings.tolerance); }
	bool run(double tolerance);
	// Level statistics and what coarsening leaves; then, if nothing is near, how far the bodies may move. Always last.
	void finish(bool isNothingNear);

	const QueryContext& context() const { return m_context; }
	const StopRule& rule() const { return *m_rule; }
	// Of the last run. The largest cover_a + cover_b of the accepted pairs that are no contacts.
	double largestCover() const { return m_largestCover; }
	bool overlaps() const;
	bool isOfInput() const { return m_isOfInput; }  // every accepted pair is of level 0: nothing finer exists
	bool isCoarsened() const { return m_settings.metric.coarsening > 1 || m_result.stats.cutShort > 0 || !hasInput(); }
	bool hasInput() const { return m_context.hasInput(); }
	// > 0: a point of one body is inside the other by so much: one of a component that is wholly inside, if it is more
	// than hiddenDepth(). Precondition: nothing overlaps.
	double depthInside();
	// So deep input surfaces may lie in each other although no accepted pair overlaps: cover_a + cover_b at most.
	double hiddenDepth() const;

private:
	std::optional<double> traverseFront(double tolerance);
	double answerCoarsest(double tolerance);
	void remember(const StopRule& rule);
	void countQuiet(bool isNothingNear);
	bool isMovingOn() const;
	bool isOfSinglePiece() const;
	double lookAhead(const StopRule& rule, const WorkLimit& limit) const;
	std::optional<double> traverseBy(const StopRule& rule, double tolerance, const WorkLimit& limit);
	void tellExcess();
	using Walk = bool(const QueryContext&, const TraversalSettings&, PairFront&, ContactSink&, QueryStats&);
	std::optional<double> answerFrom(Walk& walk, const TraversalSettings& settings, double tolerance);
	void sort();
	bool rootIsApart() const;
	double leastApart() const;
	ContactSink sinkOf(const StopRule& rule, double tolerance) const;

	const ContactSettings& m_settings;
	const AskedGap m_gap;
	PairCache::State& m_state;
	ContactResult& m_result;
	WorkLimit m_limit;
	const QueryContext m_context;
	std::optional<StopRule> m_rule;
	double m_tolerance = 0;  // of the last run
	double m_largestCover = 0, m_leastApart = 0;
	const PairFront* m_answered;  // the front that gave the answers
	bool m_isStillApart = false, m_isOfInput = true;
};
}  // namespace clod
