// SPDX-License-Identifier: Zlib
// A pair's contacts in one dispatch, and when those of the last one are the answer already: two bodies that stay where
// they are cost what writing their manifolds costs.
#include <tuple>

#include "clod/bullet/PairState.h"

namespace clod
{
namespace
{
constexpr int kLeakRounds = 3;          // reductions after dropping leaking points
constexpr double kTestsPerPending = 8;  // what a pair that was not refined would have taken

// Every field: one more does not compile before it is named here.
auto fieldsOf(const PointRules& rules)
{
	const auto& [length, resting, margin, motion] = rules;
	const auto& [linear, angular, timeStep] = motion;
	return std::tie(length, resting, margin, linear, angular, timeStep);
}
}  // namespace

// The pose, how the bodies move, and what is asked: all as in the last dispatch? Then its points are the answer.
bool PairState::answersAgain() const
{
	return m_hasQuestion && m_partner == Partner::Clod && !m_context.budget.isLimited() &&
		   same(m_question.aFromB, m_aFromB) && fieldsOf(m_question.rules) == fieldsOf(m_rules) &&
		   same(m_question.settings, querySettings()) && m_question.withGap == m_context.searchGap;
}

// The gap besides the contacts only where it is asked for: it costs a search of the input surfaces.
void PairState::ask(const GapSettings& settings)
{
	const Hierarchy &a = m_shapeA->hierarchy(), &b = m_shapeB->hierarchy();
	if (m_context.searchGap)
	{
		signedGap(a, b, m_aFromB, settings, m_cache, m_result);
		return;
	}
	contacts(a, b, m_aFromB, settings, m_cache.pair, m_result);
	m_result.minDistance = m_result.errorBound = std::numeric_limits<double>::infinity();
}

// Returns when the query ended.
Clock::time_point PairState::findPoints()
{
	const Clock::time_point start = Clock::now();
	if (m_partner != Partner::Clod)
	{
		m_report.queryMicroseconds = 0;
		clipForeign();
		return start;
	}
	GapSettings settings = querySettings();
	settings.budget = chooseBudget();
	ask(settings);
	const Clock::time_point end = Clock::now();
	m_report.queryMicroseconds = microsecondsBetween(start, end);
	const QueryStats& stats = m_result.stats;
	const double tests = double(stats.boxTests) + stats.hullTests + m_report.searchTests;
	if (settings.budget.isLimited()) m_context.setDemand(m_report, tests + kTestsPerPending * stats.pending);
	m_pool.start(m_shapeA->hierarchy(), m_shapeB->hierarchy(), m_aFromB, m_result.contacts, m_rules);
	return end;
}

// Clusters; chosen points that turn out to be leaks are dropped and the choice made again.
void PairState::reduce()
{
	ClusterRules rules;
	rules.length = m_rules.length;
	rules.margin = m_rules.margin;
	rules.tolerance = m_rules.resting / m_rules.length;
	m_previous = m_clusters;
	carryWithB(m_previous, m_aFromB * inverse(m_oldAFromB));
	m_oldAFromB = m_aFromB;
	m_report.leaks = 0;
	m_reducer.reduce(m_pool, m_previous, rules, m_clusters);
	if (m_partner != Partner::Clod || m_pool.points().empty()) return;
	m_leakCheck.start(m_result.contacts);
	for (int round = 0; round < kLeakRounds; ++round)
	{
		std::uint32_t leaks = 0;
		for (int slot = 0; slot < kMaxClusters; ++slot)
			for (int i = 0; i < m_clusters.slots[std::size_t(slot)].count; ++i)
			{
				const ContactPoint& point = m_clusters.slots[std::size_t(slot)].points[std::size_t(i)].point;
				if (!m_leakCheck.leaks(m_shapeA->hierarchy(), m_shapeB->hierarchy(), m_aFromB, point, m_rules.margin))
					continue;
				m_pool.drop(m_reducer.candidateOf(slot, i));
				++leaks;
			}
		if (leaks == 0) return;
		m_report.leaks += leaks;
		m_reducer.reduce(m_pool, m_previous, rules, m_clusters);
	}
}

// Every point continues the one in its place.
void PairState::linkToThemselves()
{
	for (std::uint32_t slot = 0; slot < kMaxClusters; ++slot)
		for (std::uint32_t i = 0; i < kClusterPoints; ++i)
			m_clusters.slots[slot].points[i].previous = slot * kClusterPoints + i;
}

// A pair that was apart and is costs no more than it must: nothing is copied, and the clock not read again.
void PairState::answer()
{
	const Clock::time_point found = findPoints();
	const bool staysEmpty = m_pool.isEmpty() && m_clusters.pointCount() == 0;
	if (staysEmpty)
	{
		m_oldAFromB = m_aFromB;
		m_report.leaks = 0;
	}
	else
		reduce();
	judge();
	m_report.contactMicroseconds = staysEmpty ? 0 : microsecondsSince(found);
	m_question = {m_aFromB, querySettings(), m_rules, m_context.searchGap};
	// What a budget cut short answers only under that budget: the next dispatch asks anew, with what it may cost then.
	m_hasQuestion = !(m_result.excess > 0);
}
}  // namespace clod
