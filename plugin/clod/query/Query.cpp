// SPDX-License-Identifier: Zlib
// The entry point: when the last result still holds, and which settings can be used.
#include "clod/query/Query.h"

#include <string>
#include <tuple>

#include "clod/query/ContactSearch.h"

namespace clod
{
PairCache::PairCache(bool remembers) : m_state(std::make_unique<State>())
{
	if (remembers) m_state->last = std::make_unique<ContactResult>();
}
PairCache::~PairCache() = default;
PairCache::PairCache(PairCache&&) noexcept = default;
PairCache& PairCache::operator=(PairCache&&) noexcept = default;
void PairCache::clear()
{
	*this = PairCache(m_state->last != nullptr);
}

void PairCache::giveBack()
{
	m_state->front.giveBack();
	m_state->outline.reset();
}

void ContactResult::clear()
{
	contacts.clear();
	deep = false;
	excess = 0;
	stats = QueryStats{};
}

bool same(const ContactSettings& l, const ContactSettings& r)
{
	// Every field but the metric: one more does not compile before it is named here.
	const auto fields = [](const ContactSettings& settings)
	{
		const auto& [metric, tolerance, sweep, budget] = settings;
		const auto& [tests, microseconds] = budget;
		return std::tie(tolerance, sweep, tests, microseconds);
	};
	return fields(l) == fields(r) && same(l.metric, r.metric);
}

bool same(const Transform& l, const Transform& r)
{
	for (int i = 0; i < 3; ++i)
		if (l.rotation.row[i] != r.rotation.row[i]) return false;
	return l.translation == r.translation;
}

void contacts(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
			  PairCache& cache, ContactResult& result)
{
	PairCache::State& state = cache.state();
	if (isSamePose(a, b, aFromB, state) && state.hasLast && answersAgain(settings, *state.last, state))
	{
		state.settings = settings;
		result = *state.last;
		result.stats.boxTests = result.stats.hullTests = 0;
		return;
	}
	result.clear();
	ContactSearch search(a, b, aFromB, settings, {}, state, result);
	if (!search.isStillApart())
	{
		search.run();
		result.deep = search.hasInput() && !search.overlaps() && search.depthInside() > 0;
		search.finish(result.contacts.empty() && !result.deep);
	}
	if (state.last) *state.last = result;
	state.hasLast = state.last != nullptr;
}

void evaluate(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, std::vector<Contact>& contacts)
{
	const QueryContext context(a, b, aFromB);
	for (Contact& contact : contacts)
	{
		const HullDistance distance =
			canonicalDistance(context, contact.nodeA, contact.nodeB, std::numeric_limits<double>::infinity());
		contact = {contact.nodeA,     contact.nodeB,     distance.lower, distance.upper,
				   distance.pointOnA, distance.pointOnB, distance.normal};
	}
}

Outline outlineCoarsest(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
						PairCache& cache)
{
	PairCache::State& state = cache.state();
	const QueryContext context(a, b, aFromB, settings.sweep);
	followMotion(context, state);
	if (state.separation.holds(context, settings, {})) return {};
	return outline(context, settings, settings.tolerance, state);
}

std::string levelsError(const Hierarchy& a, const Hierarchy* b, const Metric& metric)
{
	const std::uint32_t finest = std::max(a.finestLevel(), b ? b->finestLevel() : 0);
	if (finest == 0) return {};
	const std::string loaded = "levels from " + std::to_string(finest) + " on were loaded of a body";
	if (metric.exact) return "exact contacts are of level 0, but " + loaded;
	const auto sum = [&](float Level::*bound)
	{ return double(a.levels()[0].*bound) + (b ? double(b->levels()[0].*bound) : 0); };
	const double kept = std::max(sum(&Level::maxCover), sum(&Level::maxProtrude));
	if (!(kept > metric.maxError)) return {};
	return "an error of " + std::to_string(metric.maxError) + " at most is asked for, but " + loaded + ": " +
		   std::to_string(kept);
}

std::string budgetError(const Budget& budget)
{
	if (!(budget.tests >= 0)) return "budget.tests is " + std::to_string(budget.tests) + ", but must be >= 0";
	if (!(budget.microseconds >= 0))
		return "budget.microseconds is " + std::to_string(budget.microseconds) + ", but must be >= 0";
	return {};
}

std::string settingsError(const ContactSettings& settings)
{
	if (!(settings.tolerance >= 0 && std::isfinite(settings.tolerance)))
		return "tolerance is " + std::to_string(settings.tolerance) + ", but must be a finite length >= 0";
	if (!isFinite(settings.sweep.linear) || !isFinite(settings.sweep.angular)) return "sweep is not finite";
	if (std::string error = metricError(settings.metric); !error.empty()) return error;
	return budgetError(settings.budget);
}
}  // namespace clod
