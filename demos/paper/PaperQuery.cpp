// SPDX-License-Identifier: Zlib
#include "demos/paper/PaperQuery.h"

#include <algorithm>

#include "clod/distance/GapSearch.h"
#include "clod/query/ContactSink.h"
#include "clod/query/InsideTest.h"

namespace clod::demo
{
namespace
{
class PaperWalk : public GapWalk
{
public:
	PaperWalk(const QueryContext& context, const GapSettings& settings, GapResult& result)
		: m_context(context), m_settings(settings), m_rule(context, settings.metric), m_result(result)
	{
	}

	void run()
	{
		visit(m_context.a.root(), m_context.b.root());
		m_rootIsApart = m_pairs.empty();
		while (!m_pairs.empty())
		{
			const auto [a, b] = m_pairs.back();
			m_pairs.pop_back();
			if (accepts(a, b))
				answer(a, b);
			else
				open(a, b);
		}
		sortByNodes(m_result.contacts);
		levelStatistics();
	}

	FoundPairs found() const override
	{
		return {m_largestCover, m_isOfInput, false, m_rule.thresholds().most};
	}
	double depthInside() override
	{
		if (m_rootIsApart) return 0;
		InsideProbes ofA, ofB;
		ofA.prepare(m_context.a);
		ofB.prepare(m_context.b);
		const Transform aFromB{m_context.pose.rotation, m_context.pose.translation};
		return std::max(ofA.depthInside(m_context.b, inverse(aFromB), 0, m_result.stats),
						ofB.depthInside(m_context.a, aFromB, 0, m_result.stats));
	}
	bool widenToNearest(double&) override { return false; }

private:
	bool accepts(std::uint32_t a, std::uint32_t b) const
	{
		const bool areLeaves = m_context.a.node(a).childCount == 0 && m_context.b.node(b).childCount == 0;
		return areLeaves || (m_rule.mayAnswer(a, b) && m_rule.excess(a, b, false) == 0);
	}
	void visit(std::uint32_t a, std::uint32_t b)
	{
		const double drift = double(m_context.a.node(a).hausdorff) + double(m_context.b.node(b).hausdorff);
		++m_result.stats.hullTests;
		if (canonicalDistance(m_context, a, b, m_settings.tolerance + drift).lower - drift > m_settings.tolerance)
			++m_result.stats.front;
		else
			m_pairs.push_back({a, b});
	}
	void open(std::uint32_t a, std::uint32_t b)
	{
		++m_result.stats.frontInner;
		const bool opensA = m_rule.opensA(a, b);
		const Hierarchy& side = opensA ? m_context.a : m_context.b;
		const Node& node = side.node(opensA ? a : b);
		for (std::uint32_t i = 0; i < node.primaryChildCount; ++i)
		{
			const std::uint32_t child = side.children(node)[i];
			visit(opensA ? child : a, opensA ? b : child);
		}
	}
	void answer(std::uint32_t a, std::uint32_t b)
	{
		++m_result.stats.front;
		++m_result.stats.hullTests;
		const Node &nodeA = m_context.a.node(a), &nodeB = m_context.b.node(b);
		m_isOfInput = m_isOfInput && nodeA.childCount == 0 && nodeB.childCount == 0;
		const double cover = double(nodeA.cover) + double(nodeB.cover);
		const HullDistance d = canonicalDistance(m_context, a, b, m_settings.tolerance + cover);
		if (d.lower <= m_settings.tolerance)
			m_result.contacts.push_back({a, b, d.lower, d.upper, d.pointOnA, d.pointOnB, d.normal});
		else if (!(d.lower > m_settings.tolerance + cover))
			m_largestCover = std::max(m_largestCover, cover);
	}
	void levelStatistics()
	{
		if (m_result.contacts.empty()) return;
		std::uint32_t finest = kNone, coarsest = 0;
		for (const Contact& contact : m_result.contacts)
			for (const std::uint32_t level :
				 {m_context.a.node(contact.nodeA).level, m_context.b.node(contact.nodeB).level})
			{
				finest = std::min(finest, level);
				coarsest = std::max(coarsest, level);
			}
		m_result.stats.finestLevel = finest;
		m_result.stats.coarsestLevel = coarsest;
	}

	struct NodePair
	{
		std::uint32_t a, b;
	};
	const QueryContext& m_context;
	const GapSettings& m_settings;
	const StopRule m_rule;
	GapResult& m_result;
	std::vector<NodePair> m_pairs;
	double m_largestCover = 0;
	bool m_rootIsApart = false, m_isOfInput = true;
};
}  // namespace

void paperQuery(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const GapSettings& settings,
				GapResult& result)
{
	result.clear();
	const QueryContext context(a, b, aFromB);
	PaperWalk walk(context, settings, result);
	walk.run();
	GapCache::Search search;
	certifyGap(context, settings, walk, search, result);
}

std::string paperQueryError(const Hierarchy& a, const Hierarchy& b, const GapSettings& settings)
{
	if (std::string error = settingsError(settings); !error.empty()) return error;
	if (settings.budget.isLimited()) return "paper is set, but a budget is too";
	if (a.isPaperBuild() && b.isPaperBuild()) return {};
	return std::string("paper is set, but hierarchy ") + (a.isPaperBuild() ? "b" : "a") + " was not built with --paper";
}
}  // namespace clod::demo
