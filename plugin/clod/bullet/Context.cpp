// SPDX-License-Identifier: Zlib
#include "clod/bullet/Context.h"

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace clod
{
Context::Context() : warn([](const std::string& message) { std::fprintf(stderr, "clod: %s\n", message.c_str()); }) {}
Context::~Context() = default;

void Context::add(const PairReport* report)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_pairs.push_back(report);
}

void Context::remove(const PairReport* report)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_demand -= report->demand;
	if (!report->isPlanned) m_unplannedDemand -= report->demand;
	m_pairs.erase(std::find(m_pairs.begin(), m_pairs.end(), report));
}

void Context::setDemand(PairReport& report, double tests)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_demand += tests - report.demand;
	if (!report.isPlanned) m_unplannedDemand += tests - report.demand;
	report.demand = tests;
}

void Context::setPlanned(PairReport& report)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	if (!report.isPlanned) m_unplannedDemand -= report.demand;
	report.isPlanned = true;
}

// A pair that is new counts as the average of the others.
Budget Context::shareOf(const PairReport& report) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	const double pairs = double(m_pairs.size());
	const double own = report.demand > 0 ? report.demand : m_demand / std::max(1.0, pairs - 1);
	const double all = report.demand > 0 ? m_demand : m_demand + own;
	const double share = all > 0 ? own / all : 1 / pairs;
	const auto part = [share](double whole) { return whole < kOff ? share * whole : kOff; };
	return {std::floor(part(budget.tests)), part(budget.microseconds)};
}

double Context::unplannedShare() const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	return budget.tests < kOff && m_demand > 0 ? budget.tests * m_unplannedDemand / m_demand : 0;
}

void Context::say(const std::string& message) const
{
	const std::lock_guard<std::recursive_mutex> lock(m_saying);
	const auto handler = warn;  // one that replaces itself goes on to its end
	if (handler) handler(message);
}

// By index, and not locked during a visit: pairs may come, as those of a contactTest do, and go.
const PairReport* Context::pairAt(std::size_t index) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	return index < m_pairs.size() ? m_pairs[index] : nullptr;
}

void Context::forEachPair(const std::function<void(const PairReport&)>& visit) const
{
	std::size_t index = 0;
	while (const PairReport* report = pairAt(index++)) visit(*report);
}

StepStatistics Context::lastStep() const
{
	StepStatistics sum;
	forEachPair(
		[&sum](const PairReport& pair)
		{
			const std::string name = "pair " + std::to_string(sum.pairs);
			++sum.pairs;
			sum.pairsInContact += pair.points > 0 ? 1 : 0;
			sum.candidates += pair.candidates;
			sum.points += pair.points;
			sum.clusters += pair.clusterCount;
			sum.leaks += pair.leaks;
			if (pair.result)
			{
				sum.nodePairs += std::uint32_t(pair.result->contacts.size());
				sum.front += pair.result->stats.front;
				sum.hullTests += pair.result->stats.hullTests;
				sum.pending += pair.result->stats.pending;
				sum.excess = std::max(sum.excess, pair.result->excess);
				sum.boxTests += pair.result->stats.boxTests;
			}
			sum.searchTests += pair.searchTests;
			sum.queryMicroseconds += pair.queryMicroseconds;
			sum.contactMicroseconds += pair.contactMicroseconds;
			sum.keptPairs += pair.kept ? 1 : 0;
			sum.deepPairs += pair.deep ? 1 : 0;
			sum.fastPairs += pair.fast ? 1 : 0;
			sum.loosePairs += pair.loose ? 1 : 0;
			if (!pair.notFinite.empty()) sum.warnings.push_back(name + ": no contacts, as " + pair.notFinite);
			if (!pair.metricError.empty()) sum.warnings.push_back(name + ": exact, as " + pair.metricError);
			if (pair.deep) sum.warnings.push_back(name + ": penetration deeper than the contacts can prove");
			if (pair.fast) sum.warnings.push_back(name + ": one step moves farther than the thinnest wall");
			if (pair.loose) sum.warnings.push_back(name + ": the error bound exceeds the thinnest wall");
		});
	return sum;
}
}  // namespace clod
