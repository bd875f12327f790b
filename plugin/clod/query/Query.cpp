// SPDX-License-Identifier: Zlib
// The entry points: when the last result still holds, what of the cache does, and which settings can be used.
#include "clod/query/Query.h"

#include <string>
#include <tuple>

#include "clod/query/Evaluation.h"
#include "clod/collide/MotionBound.h"

namespace clod
{
PairCache::PairCache() : m_state(std::make_unique<State>()) {}
PairCache::~PairCache() = default;
PairCache::PairCache(PairCache&&) noexcept = default;
PairCache& PairCache::operator=(PairCache&&) noexcept = default;
void PairCache::clear()
{
	m_state = std::make_unique<State>();
}

void QueryResult::clear()
{
	contacts.clear();
	minDistance = std::numeric_limits<double>::infinity();
	errorBound = 0;
	deep = false;
	excess = 0;
	stats = QueryStats{};
}

bool same(const Settings& l, const Settings& r)
{
	// Every field but the metric: one more does not compile before it is named here.
	const auto fields = [](const Settings& settings)
	{
		const auto& [metric, tolerance, sweep, distance, gapError, paper, contactsOnly, budget] = settings;
		const auto& [tests, microseconds] = budget;
		return std::tie(tolerance, sweep, distance, gapError, paper, contactsOnly, tests, microseconds);
	};
	return fields(l) == fields(r) && same(l.metric, r.metric);
}

bool same(const Transform& l, const Transform& r)
{
	for (int i = 0; i < 3; ++i)
		if (l.rotation.row[i] != r.rotation.row[i]) return false;
	return l.translation == r.translation;
}

namespace
{
// A plan's query may have an own threshold: it is the one the plan was made with.
bool sameButOwn(Settings l, Settings r)
{
	if (l.metric.own != r.metric.own) return false;
	l.metric.own = r.metric.own = nullptr;
	return same(l, r);
}
// Drops what was cached for other hierarchies or another kind of traversal, then adds the motion since the last query.
void followMotion(const QueryContext& context, const Settings& settings, PairCache::State& state)
{
	const bool sameBodies = state.a == &context.a && state.b == &context.b && state.hashA == context.a.contentHash() &&
							state.hashB == context.b.contentHash();
	if (!sameBodies)
	{
		state.clearFronts();
		state.a = &context.a;
		state.b = &context.b;
		state.hashA = context.a.contentHash();
		state.hashB = context.b.contentHash();
		state.filled = false;
	}
	else if (state.filled)
	{
		const double motion = motionBound(state.pose, context.pose, context.reachA, context.reachB);
		const double change =
			sweepChange(state.pose, state.settings.sweep, context.pose, context.sweep, motion, context.reachB);
		state.front.move(motion, change);
		state.lastMove = motion + change;
		const bool otherTree =
			state.settings.paper != settings.paper || state.settings.budget.isLimited() != settings.budget.isLimited();
		if (otherTree || !(state.front.motion < 1e5 * context.size))
		{
			state.clearFronts();
		}
	}
	state.pose = context.pose;
}

bool isSamePose(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const PairCache::State& state)
{
	return state.filled && state.a == &a && state.b == &b && state.hashA == a.contentHash() &&
		   state.hashB == b.contentHash() && same(state.aFromB, aFromB);
}

// At the same pose: is the last result that of these settings? One that its budget did not cut short is that of every
// budget large enough.
bool answersAgain(const Settings& settings, const PairCache::State& state)
{
	if (same(state.settings, settings)) return true;
	const double needed = double(state.refinement.needed());
	if (!state.settings.budget.isLimited() || state.last.excess > 0) return false;
	if (!(settings.budget.tests < kInfinity && settings.budget.tests >= needed)) return false;
	Settings before = state.settings;
	before.budget = settings.budget;
	return same(before, settings);
}
void answer(const QueryContext& context, const Settings& settings, PairCache::State& state, QueryResult& result)
{
	if (state.clearance.holds(context, settings))
	{
		state.settings = settings;
		setNothingNear(settings, state.clearance.largestCover(), result);
		result.stats.front = state.last.stats.front;
		result.stats.frontInner = state.last.stats.frontInner;
		result.stats.stillClear = 1;
		return;
	}
	Evaluation(context, settings, state, result).run();
	if (result.contacts.empty() && result.minDistance == kInfinity)
		state.clearance.seek(context, settings, state.lastMove,
							 {state.closest, state.probesA, state.probesB, result.stats});
}
}  // namespace

void query(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const Settings& settings, PairCache& cache,
		   QueryResult& result)
{
	PairCache::State& state = cache.state();
	const bool samePose = isSamePose(a, b, aFromB, state);
	// A plan has moved the cache to its pose; the last result stayed behind.
	const bool wasPlanned = state.planned.has_value();
	if (!(samePose && sameButOwn(state.settings, settings))) state.planned.reset();
	if (samePose && !wasPlanned && answersAgain(settings, state))
	{
		state.settings = settings;
		result = state.last;
		return;
	}
	result.clear();
	if (state.planned)
		Evaluation(*state.planned, settings, state, result).run();
	else
	{
		const QueryContext context(a, b, aFromB, settings.sweep);
		followMotion(context, settings, state);
		answer(context, settings, state, result);
	}
	state.planned.reset();
	state.aFromB = aFromB;
	state.last = result;
}

QueryPlan::QueryPlan(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const Settings& settings,
					 PairCache& cache)
	: m_state(&cache.state())
{
	m_state->planned.emplace(a, b, aFromB, settings.sweep);
	followMotion(*m_state->planned, settings, *m_state);
	const StopRule rule(*m_state->planned, settings.metric, settings.paper);
	m_state->refinement.start(*m_state->planned, rule, settings.tolerance, settings.paper);
	m_state->aFromB = aFromB;
	m_state->settings = settings;
	m_state->filled = true;
}
double QueryPlan::excess() const
{
	return m_state->planned ? m_state->refinement.excess() : 0;
}
double QueryPlan::deviation() const
{
	return m_state->planned ? m_state->refinement.deviation() : 0;
}
std::uint64_t QueryPlan::committed() const
{
	return m_state->planned ? m_state->refinement.committed() : 0;
}
std::uint64_t QueryPlan::answers() const
{
	return m_state->planned ? m_state->refinement.answers() : 0;
}
std::uint64_t QueryPlan::cost() const
{
	return m_state->refinement.cost();
}
void QueryPlan::refine()
{
	m_state->refinement.refine();
}

std::string budgetError(const Budget& budget)
{
	if (!(budget.tests >= 0)) return "budget.tests is " + std::to_string(budget.tests) + ", but must be >= 0";
	if (!(budget.microseconds >= 0))
		return "budget.microseconds is " + std::to_string(budget.microseconds) + ", but must be >= 0";
	return {};
}

std::string settingsError(const Hierarchy& a, const Hierarchy& b, const Settings& settings)
{
	const auto text = [](const char* field, double value)
	{ return std::string(field) + " is " + std::to_string(value); };
	if (!(settings.tolerance >= 0) || settings.tolerance == kInfinity)
		return text("tolerance", settings.tolerance) + ", but must be a finite length >= 0";
	if (!(settings.gapError >= 0)) return text("gapError", settings.gapError) + ", but must be >= 0";
	if (!isFinite(settings.sweep.linear) || !isFinite(settings.sweep.angular)) return "sweep is not finite";
	if (std::string error = metricError(settings.metric); !error.empty()) return error;
	if (std::string error = budgetError(settings.budget); !error.empty()) return error;
	if (settings.budget.isLimited() && settings.distance)
		return "a budget is set, but distance is too: a gap at any separation cannot be cut short";
	if (settings.paper && !(a.isPaperBuild() && b.isPaperBuild()))
		return std::string("paper is set, but hierarchy ") + (a.isPaperBuild() ? "b" : "a") +
			   " was not built with --paper";
	return {};
}
}  // namespace clod
