// SPDX-License-Identifier: Zlib
// The entry point, and the walk over the pair's front that the certificate is of.
#include "clod/distance/SignedGap.h"

#include <cmath>
#include <string>

#include "clod/distance/GapSearch.h"
#include "clod/query/ContactSearch.h"

namespace clod
{
namespace
{
constexpr double kRounding = 1e-15;  // of sums and roots
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class FrontWalk : public GapWalk
{
public:
	FrontWalk(ContactSearch& walk, GapCache::Search& search, GapResult& result)
		: m_walk(walk), m_search(search), m_result(result)
	{
	}
	FoundPairs found() const override
	{
		return {m_walk.largestCover(), m_walk.isOfInput(), m_walk.isCoarsened(), m_walk.rule().thresholds().most};
	}
	double depthInside() override { return m_walk.depthInside(); }
	bool widenToNearest(double& distance) override
	{
		if (m_walk.rule().isOfLeaves()) return false;
		distance = closestDistance(m_walk.context(), m_walk.rule(), m_search.surfaces, m_result.stats);
		m_walk.run(distance);
		return true;
	}

private:
	ContactSearch& m_walk;
	GapCache::Search& m_search;
	GapResult& m_result;
};
}  // namespace

GapCache::GapCache() = default;
GapCache::Search& GapCache::search()
{
	if (!m_search) m_search = std::make_unique<Search>();
	return *m_search;
}
GapCache::~GapCache() = default;
GapCache::GapCache(GapCache&&) noexcept = default;
GapCache& GapCache::operator=(GapCache&&) noexcept = default;
void GapCache::clear()
{
	pair.clear();
	m_search.reset();
}

void GapResult::clear()
{
	ContactResult::clear();
	minDistance = kInfinity;
	errorBound = 0;
}

bool same(const GapSettings& l, const GapSettings& r)
{
	return l.distance == r.distance && l.gapError == r.gapError &&
		   same(static_cast<const ContactSettings&>(l), static_cast<const ContactSettings&>(r));
}

std::string settingsError(const GapSettings& settings)
{
	if (std::string error = settingsError(static_cast<const ContactSettings&>(settings)); !error.empty()) return error;
	if (!(settings.gapError >= 0)) return "gapError is " + std::to_string(settings.gapError) + ", but must be >= 0";
	if (settings.isTrial) return "isTrial is set: a gap cannot be tried, only contacts";
	if (settings.budget.isLimited() && settings.distance)
		return "a budget is set, but distance is too: a gap at any separation cannot be cut short";
	return {};
}

void signedGap(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const GapSettings& settings,
			   GapCache& cache, GapResult& result)
{
	if (isBeyondFloats(aFromB.translation))
	{
		result.clear();
		if (settings.distance)
			result.minDistance = std::hypot(aFromB.translation.x, aFromB.translation.y, aFromB.translation.z);
		result.errorBound = (1 + kRounding) * (a.originRadius() + b.originRadius());
		if (settings.distance) result.errorBound += kRounding * result.minDistance;
		return;
	}
	if (a.isCoarse() || b.isCoarse())
	{
		contacts(a, b, aFromB, settings, cache.pair, result);
		result.minDistance = result.errorBound = kInfinity;
		return;
	}
	PairCache::State& state = cache.pair.state();
	GapCache::Search& search = cache.search();
	result.clear();
	ContactSearch walk(a, b, aFromB, settings, {true, settings.distance, settings.gapError}, state, result);
	if (walk.isStillApart())
	{
		result.errorBound = state.separation.largestCover();
		return;
	}
	walk.run();
	FrontWalk front(walk, search, result);
	certifyGap(walk.context(), settings, front, search, result);
	walk.finish(result.contacts.empty() && result.minDistance == kInfinity);
}
}  // namespace clod
