// SPDX-License-Identifier: Zlib
// The entry point, which way round two bodies are asked, and which settings can be used.
#include "clod/query/Query.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "clod/query/Constants.h"
#include "clod/query/ContactSearch.h"

namespace clod
{
PairCache::PairCache() : m_state(std::make_unique<State>()) {}
PairCache::~PairCache() = default;
PairCache::PairCache(PairCache&&) noexcept = default;
PairCache& PairCache::operator=(PairCache&&) noexcept = default;
void PairCache::clear()
{
	*this = PairCache();
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
		const auto& [metric, tolerance, sweep, budget, isTrial, signsOnly] = settings;
		const auto& [tests, microseconds, now] = budget;
		return std::tie(tolerance, sweep, tests, microseconds, now, isTrial, signsOnly);
	};
	return fields(l) == fields(r) && same(l.metric, r.metric);
}

namespace
{
// A body of much larger pieces, a box or a floor, is asked as body A: what turns are then the other's small nodes, and no
// corners far from any contact.
bool isAskedFromB(const Hierarchy& a, const Hierarchy& b)
{
	return pieceOf(b) > kMuchLarger * pieceOf(a);
}

// The settings of the other way round. Lives as long as the query.
class ExchangedSettings
{
public:
	ExchangedSettings(const ContactSettings& settings, const Transform& aFromB, const Transform& bFromA) : m_settings(settings)
	{
		const Mat3& turn = bFromA.rotation;
		m_settings.sweep = {-(turn * settings.sweep.of(aFromB.translation)), -(turn * settings.sweep.angular)};
		Metric& metric = m_settings.metric;
		const VelocityThreshold& velocity = settings.metric.velocity;  // it has no sign
		metric.velocity.linear = turn * (velocity.linear + cross(velocity.angular, aFromB.translation));
		metric.velocity.angular = turn * velocity.angular;
		metric.view.eye = bFromA * settings.metric.view.eye;
		if (!metric.own) return;
		m_own = [&own = *settings.metric.own, &aFromB](const Place& place)
		{ return own({aFromB * place.center, place.radius}); };
		metric.own = &m_own;
	}
	ExchangedSettings(const ExchangedSettings&) = delete;
	ExchangedSettings& operator=(const ExchangedSettings&) = delete;
	const ContactSettings& get() const { return m_settings; }

private:
	ContactSettings m_settings;
	OwnThreshold m_own;
};

void exchange(std::vector<Contact>& contacts, const Transform& aFromB)
{
	for (Contact& contact : contacts)
	{
		std::swap(contact.nodeA, contact.nodeB);
		const Vec3 onA = aFromB * contact.pointOnB;
		contact.pointOnB = aFromB * contact.pointOnA;
		contact.pointOnA = onA;
		contact.normal = -(aFromB.rotation * contact.normal);
	}
}

void contactsInOrder(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
					 PairCache& cache, ContactResult& result)
{
	result.clear();
	ContactSearch search(a, b, aFromB, settings, {}, cache.state(), result);
	if (search.isStillApart()) return;
	if (!search.run()) return search.finish(false);
	const double inside = search.hasInput() && !search.overlaps() ? search.depthInside() : 0;
	result.deep = inside > 0 && inside > search.hiddenDepth();
	search.finish(result.contacts.empty() && inside == 0);
}

void evaluateInOrder(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, std::vector<Contact>& contacts)
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

Outline outlineInOrder(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
					   PairCache::State& state)
{
	const QueryContext context(a, b, aFromB, settings.sweep);
	followMotion(context, state);
	if (state.separation.holds(context, settings, {})) return {};
	return outline(context, settings.tolerance, state);
}
}  // namespace

bool isBeyondFloats(const Vec3& apart)
{
	return std::max({std::abs(apart.x), std::abs(apart.y), std::abs(apart.z)}) > kLongest;
}

void contacts(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
			  PairCache& cache, ContactResult& result)
{
	if (isBeyondFloats(aFromB.translation)) return result.clear();
	if (!isAskedFromB(a, b)) return contactsInOrder(a, b, aFromB, settings, cache, result);
	const Transform bFromA = inverse(aFromB);
	contactsInOrder(b, a, bFromA, ExchangedSettings(settings, aFromB, bFromA).get(), cache, result);
	exchange(result.contacts, aFromB);
}

void evaluate(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, std::vector<Contact>& contacts)
{
	if (!isAskedFromB(a, b)) return evaluateInOrder(a, b, aFromB, contacts);
	const Transform bFromA = inverse(aFromB);
	exchange(contacts, bFromA);
	evaluateInOrder(b, a, bFromA, contacts);
	exchange(contacts, aFromB);
}

Outline outlineCoarsest(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
						PairCache& cache)
{
	if (isBeyondFloats(aFromB.translation)) return {};
	if (!isAskedFromB(a, b)) return outlineInOrder(a, b, aFromB, settings, cache.state());
	const Transform bFromA = inverse(aFromB);
	return outlineInOrder(b, a, bFromA, ExchangedSettings(settings, aFromB, bFromA).get(), cache.state());
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
	if (!budget.now) return "budget.now is null, but must be a clock";
	return {};
}

std::string settingsError(const ContactSettings& settings)
{
	if (!(settings.tolerance >= 0 && settings.tolerance <= kLongest))
		return "tolerance is " + std::to_string(settings.tolerance) + ", but must be a length >= 0 that floats hold";
	if (!isFinite(settings.sweep.linear) || !isFinite(settings.sweep.angular)) return "sweep is not finite";
	if (isBeyondFloats(settings.sweep.linear) || isBeyondFloats(settings.sweep.angular))
		return "sweep is longer than floats hold";
	if (std::string error = metricError(settings.metric); !error.empty()) return error;
	return budgetError(settings.budget);
}
}  // namespace clod
