// SPDX-License-Identifier: Zlib
// What a pair says about its own contacts: levels, certified error, and what it warns of.
#include <algorithm>

#include "clod/bullet/PairState.h"
#include "clod/query/StopRule.h"

namespace clod
{
namespace
{
constexpr double kUnansweredShare = 2;  // depth found over depth answered by points that is reported as deep
}

void PairState::sayOnce(unsigned bit, const std::string& message)
{
	if ((m_warned & bit) != 0) return;
	m_warned |= bit;
	m_context.say(message);
}

void PairState::warnOnce(bool now, unsigned bit, const char* cause)
{
	if (!now || (m_warned & bit) != 0) return;
	sayOnce(bit, std::string(cause) + " (radius " + std::to_string(m_rules.length) + ", motion of a step " +
					 std::to_string(m_report.motion) + ", hierarchy unit)");
}

// Hulls overlap, and no point tells how deep.
bool PairState::isUnanswered() const
{
	return m_report.points == 0 && !m_context.searchGap && m_partner == Partner::Clod &&
		   std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
					   [](const Contact& contact) { return contact.upper <= 0; });
}

// Of the input surfaces, whatever answers; <= 0: none.
double PairState::searchDepth()
{
	GapSettings settings;
	settings.metric = m_report.metric;
	settings.tolerance = m_report.tolerance;
	if (m_hasBudget) settings.budget = kSpent;
	signedGap(m_shapeA->hierarchy(), m_shapeB->hierarchy(), m_aFromB, settings, m_cache, m_searched);
	m_report.searchTests = m_searched.stats.boxTests + m_searched.stats.hullTests;
	return -m_searched.minDistance;
}

// Under a budget, before it is spent: what a search takes is known only afterwards. So a pair whose last dispatch left
// a depth unanswered searches it now, in case this one does.
void PairState::searchAhead()
{
	m_report.searchTests = 0;
	m_depth.reset();
	if (m_hasBudget && m_wasUnanswered) m_depth = searchDepth();
}

// Is there a depth that the chosen points do not answer? A component inside the other body, a chosen point where its
// face's stored thickness ends, or hulls that overlap without any point: then the gap is searched after all.
bool PairState::deeperThanPoints()
{
	double answered = 0;
	bool atBottom = false;
	for (const ContactCluster& cluster : m_clusters.slots)
		for (int i = 0; i < cluster.count; ++i)
		{
			const ContactPoint& point = cluster.points[std::size_t(i)].point;
			answered = std::max(answered, -point.height);
			atBottom = atBottom || point.atBottom;
		}
	m_wasUnanswered = isUnanswered();
	if (m_result.deep && !m_context.searchGap) return true;
	double depth = -m_result.minDistance;
	if (m_wasUnanswered) depth = m_hasBudget ? m_depth.value_or(0) : searchDepth();
	return atBottom || depth > kUnansweredShare * answered + m_rules.resting;
}

// See PairReport::contactError.
double PairState::errorOfContacts() const
{
	if (m_partner != Partner::Clod) return m_foreignStats.errorBound;
	double error = 0;
	for (const Contact& contact : m_result.contacts)
	{
		const Node& a = m_shapeA->hierarchy().node(contact.nodeA);
		const Node& b = m_shapeB->hierarchy().node(contact.nodeB);
		error = std::max(error, certifiedErrorApart(a, b));
	}
	return error;
}

void PairState::judge()
{
	m_report.candidates = std::uint32_t(m_pool.points().size());
	m_report.points = std::uint32_t(m_clusters.pointCount());
	m_report.clusterCount = 0;
	for (const ContactCluster& cluster : m_clusters.slots) m_report.clusterCount += cluster.count > 0 ? 1 : 0;
	m_report.contactError = errorOfContacts();
	m_report.finestLevel = m_result.stats.finestLevel;
	m_report.coarsestLevel = m_result.stats.coarsestLevel;
	double wall = double(m_shapeA->hierarchy().asset().thinnestWall);
	if (m_partner == Partner::Clod) wall = std::min(wall, double(m_shapeB->hierarchy().asset().thinnestWall));
	m_report.deep = deeperThanPoints();
	m_report.fast = wall > 0 && m_report.motion > wall;
	m_report.loose = wall > 0 && m_report.contactError > wall;
	if (m_isClosestPoints) return;
	warnOnce(m_report.deep, 1, "two bodies overlap deeper than their contacts can prove");
	warnOnce(m_report.fast, 2, "a step moves two bodies farther than their thinnest wall: use smaller steps");
	warnOnce(m_report.loose, 4, "the contact error bound exceeds the thinnest wall: use a stricter metric");
}
}  // namespace clod
