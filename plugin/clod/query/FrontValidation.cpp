// SPDX-License-Identifier: Zlib
// Most fronts are what they were: bodies at rest hardly move. Each entry keeps how much motion the decisions on it and on
// its children can take, and where few have used that up, these alone are made again. If they are the same, so is the
// front, and only its accepted pairs are left to be evaluated. If one is not, the front is made anew (Traversal.cpp).
#include <algorithm>
#include <tuple>

#include "clod/query/Traversal.h"

namespace clod
{
namespace
{
class FrontValidation : private PairDecisions
{
public:
	using PairDecisions::PairDecisions;

	// False, perhaps with some answers given: the front has changed. Precondition: worth trying.
	bool run()
	{
		const bool isSame = areAllAsTheyWere() && giveAnswers();
		if (!isSame)
		{
			m_front.backOff.fail();
			return false;
		}
		m_front.backOff.succeed();
		return finish();
	}
	bool answer() { return giveAnswers() && finish(); }

private:
	bool finish()
	{
		m_stats->frontKept = 1;
		addTo(*m_stats, m_front.counts);
		return true;
	}
	bool areAllAsTheyWere()
	{
		const std::uint32_t testsBefore = m_stats->boxTests + m_stats->hullTests;
		for (std::uint32_t i = 0; i < m_front.slack.ofEntry.size(); ++i)
		{
			if (m_moved < m_front.slack.ofEntry[i]) continue;
			if (!hasTime() || !isAffordable(mostTestsOfDecisions(m_front.entries[i])) || !isAsItWas(i)) return false;
		}
		m_front.slack.spent += m_stats->boxTests + m_stats->hullTests - testsBefore;
		return true;
	}
	// False where one that answered does not now, or the other way round.
	bool giveAnswers()
	{
		if (m_front.slack.answers.empty()) listAnswers();
		m_nearer = m_change + m_partMotion.of(Vec3{}, 2 * m_context.radiusB).farthest();
		for (const std::uint32_t i : m_front.slack.answers)
		{
			const FrontEntry& entry = m_front.entries[i];
			if (isFar(entry))
			{
				++m_stats->skippedBySlack;
				continue;
			}
			if (!hasTime() || !isAffordable(mostTestsOfAnswer())) return false;
			CachedSeparation cached = cachedOf(entry, m_front.hulls);
			const std::uint32_t before = m_stats->hullTests;
			if (answers(entry, cached) != (entry.state == NodePairState::kAnswer)) return false;
			if (m_stats->hullTests == before) continue;
			if (cached.isApart()) m_front.slack.spent += m_stats->hullTests - before;
			if (entry.hull != kNone) m_front.hulls[entry.hull] = carriedBack(cached, entry.b);
		}
		return true;
	}
	// By a bound remembered, less what anything of B can have come nearer, or its node.
	bool isFar(const FrontEntry& entry) const
	{
		if (entry.hull == kNone || entry.whileApart) return false;
		const CachedSeparation& known = m_front.hulls[entry.hull];
		return known.isApart() && (m_sink.skips((1 - 2 * kBoundRounding) * (double(known.lower) - m_nearer)) ||
								   m_sink.skips(double(lowerNow(known, entry.b))));
	}
	// On an entry and its children: boxes, and hulls that cull.
	std::uint64_t mostTestsOfDecisions(const FrontEntry& entry) const
	{
		return 1 + mostTestsOfAnswer() + (isOpen(entry.state) ? childrenOf(entry).size : 0);
	}
	// Are the decisions of the last traversal on entry i, and on its children, those that it would make now?
	bool isAsItWas(std::uint32_t i)
	{
		const FrontEntry& entry = m_front.entries[i];
		m_front.slack.ofEntry[i] = std::numeric_limits<float>::infinity();
		if (i == 0)
		{
			Row row = rowOfRoots();
			measure(row, 1);
			if (row.near == 0) return false;
			keepSlack(0, m_moved, slackOf(row, 1));
		}
		if (!entry.whileApart && entry.state != NodePairState::kAnswer && cullsByHulls(entry))
		{
			CachedSeparation cached = cachedOf(entry, m_front.hulls);
			if (areHullsApart(entry, cached) != (entry.state == NodePairState::kHullsApart)) return false;
			keepSlack(i, m_moved, slackOfHulls(entry, cached));
		}
		if (!isOpen(entry.state)) return true;
		Row row = rowOf(entry);
		const Span<std::uint32_t> children = childrenOf(entry);
		std::uint32_t child = entry.link;
		for (std::uint32_t slot = 0; slot < children.size; slot += kBoxLanes)
		{
			setRow(row, children, slot);
			const std::uint32_t first = child;
			while (child < entry.link + entry.childCount && m_front.entries[child].slot < slot + row.count) ++child;
			measure(row, row.all());
			const Kept kept = keptOf(first, child, slot);
			if (((row.near ^ kept.all) & ~kept.traceless) != 0) return false;
			keepSlack(i, m_moved, slackOf(row, row.near & ~kept.traceless));
		}
		return true;
	}
	// Contacts are then in order, too.
	void listAnswers()
	{
		const std::vector<FrontEntry>& entries = m_front.entries;
		for (std::uint32_t i = 0; i < entries.size(); ++i)
			if (entries[i].state == NodePairState::kAnswer || entries[i].whileApart) m_front.slack.answers.push_back(i);
		std::sort(m_front.slack.answers.begin(), m_front.slack.answers.end(),
				  [&](std::uint32_t l, std::uint32_t r)
				  { return std::tie(entries[l].a, entries[l].b) < std::tie(entries[r].a, entries[r].b); });
	}
	double m_nearer = 0;
};
}  // namespace

bool isWorthValidating(const TraversalSettings& settings, PairFront& front)
{
	if (front.slack.ofEntry.empty() || !settings.sameRule || front.tolerance != settings.tolerance) return false;
	if (front.slack.spent > front.slack.ofEntry.size()) return false;
	const float moved = motionSince(front);
	std::size_t used = 0;
	for (const float slack : front.slack.ofEntry) used += moved < slack ? 0 : 1;
	if (kEntriesADecision * used < front.slack.ofEntry.size()) return true;
	front.backOff.fail();
	return false;
}

bool validateFront(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
				   QueryStats& stats)
{
	return FrontValidation(context, settings, front, sink, stats).run();
}

bool hasAllAnswers(const QueryContext& context, double tolerance, const PairFront& front)
{
	if (front.entries.empty() || !(tolerance < front.tolerance)) return false;
	const double nearer =
		approachBound(front.pose, front.sweep, context.pose, context.sweep, context.radiusA, context.radiusB);
	return tolerance + nearer + kSumRounding * context.size + context.boxes.roundingOfTwo() < front.tolerance;
}

bool answerFromLast(const QueryContext& context, const TraversalSettings& settings, PairFront& front, ContactSink& sink,
					QueryStats& stats)
{
	return FrontValidation(context, settings, front, sink, stats).answer();
}
}  // namespace clod
