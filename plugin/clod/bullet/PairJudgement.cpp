// SPDX-License-Identifier: Zlib
// What a pair says about its own contacts: levels, certified error, depth, and what it warns of.
#include <algorithm>

#include "clod/bullet/PairState.h"
#include "clod/query/StopRule.h"

namespace clod
{
namespace
{
constexpr double kUnansweredShare = 2;  // depth found over depth answered by points that is reported as deep
}

void PairState::sayOnce(unsigned cause, const std::string& message)
{
	if ((m_warned & cause) != 0) return;
	m_warned |= cause;
	m_context.say(message);
}

void PairState::warnOnce(bool now, unsigned cause, const char* what)
{
	if (!now || (m_warned & cause) != 0) return;
	double radius = double(m_report.hierarchyA->asset().radius);
	if (m_report.hierarchyB) radius = std::min(radius, double(m_report.hierarchyB->asset().radius));
	sayOnce(cause, std::string(what) + " (radius " + std::to_string(radius) + ", motion of a step " +
					   std::to_string(m_report.motion) + ", hierarchy unit)");
}

// Hulls overlap, and no point tells how deep.
bool PairState::hasUnanswered(const PairPose& pose) const
{
	return m_clusters.pointCount() == 0 && !m_context.searchGap && pose.isOfTwo() &&
		   std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
					   [](const Contact& contact) { return contact.upper <= 0; });
}

// Of the input surfaces, whatever answers; <= 0: none.
double PairState::searchDepth(const PairPose& pose)
{
	GapSettings settings;
	settings.metric = m_report.metric;
	settings.tolerance = pose.tolerance;
	if (m_hasBudget) settings.budget = {0, kOff};
	signedGap(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache, m_searched);
	m_report.searchTests = m_searched.stats.boxTests + m_searched.stats.hullTests;
	return -m_searched.minDistance;
}

// Under a budget, before it is spent: what a search takes is known only afterwards. So a pair whose last dispatch left
// a depth unanswered searches it now, in case this one does.
void PairState::searchAhead(const PairPose& pose)
{
	m_report.searchTests = 0;
	m_depth.reset();
	if (m_hasBudget && m_wasUnanswered) m_depth = searchDepth(pose);
}

// The query's own, or searched where hulls overlap and no point answers.
double PairState::depthKnown(const PairPose& pose)
{
	m_wasUnanswered = hasUnanswered(pose);
	if (!m_wasUnanswered) return -m_result.minDistance;
	return m_hasBudget ? m_depth.value_or(0) : searchDepth(pose);
}

// Is there a depth that the chosen points do not answer? A component inside the other body, a chosen point where its
// face's stored thickness ends, or one known by other means.
bool PairState::deeperThanPoints(double depth) const
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
	if (m_result.deep && !m_context.searchGap) return true;
	return atBottom || depth > kUnansweredShare * answered;
}

// See PairReport::contactError.
double PairState::errorOfContacts(const PairPose& pose) const
{
	if (!pose.isOfTwo()) return m_foreignStats.errorBound;
	double error = 0;
	for (const Contact& contact : m_result.contacts)
	{
		const Node& a = pose.hierarchyA().node(contact.nodeA);
		const Node& b = pose.hierarchyB().node(contact.nodeB);
		error = std::max(error, certifiedErrorApart(a, b));
	}
	return error;
}

void PairState::report(const PairPose& pose, double depth)
{
	m_report.candidates = std::uint32_t(m_pool.points().size());
	m_report.points = std::uint32_t(m_clusters.pointCount());
	m_report.clusterCount = 0;
	for (const ContactCluster& cluster : m_clusters.slots) m_report.clusterCount += cluster.count > 0 ? 1 : 0;
	m_report.contactError = errorOfContacts(pose);
	m_report.finestLevel = m_result.stats.finestLevel;
	m_report.coarsestLevel = m_result.stats.coarsestLevel;
	const double wall = pose.thinnestWall();
	m_report.deep = deeperThanPoints(depth - pose.rules.resting);
	m_report.fast = wall > 0 && m_report.motion > wall;
	m_report.loose = wall > 0 && m_report.contactError > wall;
	if (m_isClosestPoints) return;
	warnOnce(m_report.deep, 1, "two bodies overlap deeper than their contacts can prove");
	warnOnce(m_report.fast, 2, "a step moves two bodies farther than their thinnest wall: use smaller steps");
	warnOnce(m_report.loose, 4, "the contact error bound exceeds the thinnest wall: use a stricter metric");
}
}  // namespace clod
