// SPDX-License-Identifier: Zlib
#include "clod/bullet/Context.h"

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>

#include "clod/bullet/PairState.h"

namespace clod
{
namespace
{
constexpr int kAsked = 1000;  // before this many boxes a program may still be setting up its world
std::atomic<int> g_unregistered{0};  // boxes asked for; negative once a dispatcher is registered
}  // namespace

void warnIfUnregistered()
{
	if (g_unregistered.load(std::memory_order_relaxed) < 0) return;
	if (g_unregistered.fetch_add(1, std::memory_order_relaxed) != kAsked) return;
	std::fprintf(stderr, "clod: bodies of btClodShape are in a world, but no dispatcher was registered: "
						 "they touch nothing. Call btClodCollisionAlgorithm::registerAlgorithm or clod::setUpWorld\n");
}

void Context::noteRegistration()
{
	g_unregistered.store(std::numeric_limits<int>::min(), std::memory_order_relaxed);
}

Context::Context() : warn([](const std::string& message) { std::fprintf(stderr, "clod: %s\n", message.c_str()); }) {}
Context::~Context() = default;

void Context::add(PairState* pair)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_pairs.push_back(pair);
}

void Context::remove(PairState* pair)
{
	const PairReport* report = &pair->lastReport();
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_demand -= report->demand;
	if (!report->isPlanned) m_unplannedDemand -= report->demand;
	m_pairs.erase(std::find(m_pairs.begin(), m_pairs.end(), pair));
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

void Context::say(unsigned cause, const std::string& message)
{
	const std::lock_guard<std::recursive_mutex> lock(m_saying);
	const int said = ++m_said[cause];
	const auto handler = warn;  // one that replaces itself goes on to its end
	if (!handler || said > kMostMessages) return;
	handler(said < kMostMessages ? message : message + " (further pairs of which the same holds are not told of)");
}

// By index, and not locked during a visit: pairs may come, as those of a contactTest do, and go.
PairState* Context::pairAt(std::size_t index) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	return index < m_pairs.size() ? m_pairs[index] : nullptr;
}

void Context::forEachPair(const std::function<void(const PairReport&)>& visit) const
{
	std::size_t index = 0;
	while (const PairState* pair = pairAt(index++)) visit(pair->lastReport());
}

StepReport Context::lastStep() const
{
	StepReport sum;
	forEachPair([&sum](const PairReport& pair) { addTo(sum, pair); });
	return sum;
}
}  // namespace clod
