// SPDX-License-Identifier: Zlib
#include "clod/distance/GapSearch.h"

#include <algorithm>

#include "clod/distance/Constants.h"
#include "clod/distance/GapCertificate.h"
#include "clod/query/ContactSearch.h"

namespace clod
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class GapSearch
{
public:
	GapSearch(const QueryContext& context, const GapSettings& settings, GapWalk& walk, GapCache::Search& search,
			  GapResult& result)
		: m_context(context),
		  m_settings(settings),
		  m_walk(walk),
		  m_search(search),
		  m_result(result),
		  m_found(walk.found())
	{
	}

	void run()
	{
		const bool overlap = overlaps();
		if (overlap && !m_found.isOfInput)
			fromSurfaces();
		else
			fromNodes(overlap);
		if (isTooCoarse()) fromSurfaces();
	}

private:
	bool overlaps() const
	{
		return std::any_of(m_result.contacts.begin(), m_result.contacts.end(),
						   [](const Contact& contact) { return contact.upper <= 0; });
	}
	// The error that the gap may have.
	double limit() const { return std::min(m_settings.gapError, m_settings.metric.maxError); }
	// The nodes prove less than asked for, or, of a gap within the tolerance, than the threshold s0 lets expect
	// wherever it is largest, and the input surfaces prove more. What a budget cut short is left so, but for gapError.
	bool isTooCoarse() const
	{
		const double bound = m_result.errorBound;
		if (m_result.deep || m_isOfSurfaces || m_found.isOfInput) return false;
		if (m_settings.gapError == kInfinity && m_found.isCoarsened) return false;
		if (bound > limit()) return true;
		return !m_result.contacts.empty() && bound > kSharpness * m_found.thresholdAtMost;
	}

	// Gap and bound as far as the accepted pairs prove them.
	void fromNodes(bool overlap)
	{
		const double inside = overlap ? 0 : m_walk.depthInside();
		if (overlap)
			surfacesMeet();
		else if (inside > hiddenDepth())
			setInside(inside);
		else if (inside > 0 && m_found.isCoarsened && !m_settings.distance)
			set({-inside, kInfinity, false});
		else if (inside > 0)
			fromSurfaces();  // which tell whether it is inside wholly, or by what the nodes hide
		else if (!m_result.contacts.empty())
			set(gapApart(m_context, m_result.contacts, m_settings.tolerance, m_found.largestCover));
		else if (m_settings.distance)
			farApart();
		else
			setNothingNear(m_found.largestCover);
	}

	// So deep surfaces may lie in each other although no accepted pair overlaps.
	double hiddenDepth() const
	{
		double most = m_found.largestCover;
		for (const Contact& c : m_result.contacts) most = std::max(most, m_context.coversOf(c.nodeA, c.nodeB));
		return most;
	}

	// Gap and bound of the input surfaces, whatever answered: what exact mode says.
	void fromSurfaces()
	{
		m_isOfSurfaces = true;
		++m_result.stats.gapSearches;
		double known = m_settings.distance ? kInfinity : m_settings.tolerance;
		if (!m_result.contacts.empty()) known = highFromWitnesses(m_context, m_result.contacts);
		const SurfaceDistance distance = surfaceDistance(m_context, known, m_search.surfaces, m_result.stats);
		const double inside = distance.high > 0 ? m_walk.depthInside() : 0;
		if (!(distance.high > 0))
			surfacesMeet();
		else if (inside > 0)
			setInside(inside);
		else if (distance.value < kInfinity)
			set(gapOfSurfaces(distance));
		else
			setNothingNear(0);
	}

	// A depth is searched among the leaves within so much: most are far below the tolerance, and few leaves then take
	// part. One beyond it is looked for as far as the nodes that overlap may have hidden it.
	void surfacesMeet()
	{
		double deviation = 0;
		for (const Contact& contact : m_result.contacts)
			if (contact.upper <= 0)
				deviation = std::max(deviation, double(m_context.a.node(contact.nodeA).deviation) +
													double(m_context.b.node(contact.nodeB).deviation));
		if (m_found.isOfInput) deviation = 0;
		if (!overlaps()) deviation = hiddenDepth();
		const double tolerance = m_settings.tolerance;
		const double farthest = m_settings.distance ? tolerance : tolerance + kHiddenDepth * deviation;
		double found = 0;  // a depth of some point
		for (double range = tolerance > 0 ? kShallow * tolerance : farthest;;
			 range = range < tolerance ? tolerance : 2 * range)
		{
			range = std::min(range, farthest);
			if ((found < range || range == 0) && isDepthWithin(range, found)) return;
			if (range == farthest) break;
		}
		setInside(found);
	}

	// The depth is less than `range`, and set; else some point's is not, or may not be, by `found`.
	bool isDepthWithin(double range, double& found)
	{
		if (m_found.isOfInput && range <= m_settings.tolerance)
		{
			m_search.near.clear();
			for (const Contact& contact : m_result.contacts)
				if (contact.lower <= range) m_search.near.push_back(contact);
		}
		else
		{
			gatherLeafPairs(m_context, range, m_search.surfaces, m_search.near, m_result.stats);
			sortByNodes(m_search.near);
		}
		const PointBoxes counting(m_result.stats);
		DepthAccuracy accuracy = depthAccuracy(range);
		accuracy.enough = range;
		const DepthBound depth =
			nearPenetration(m_context, m_search.near, accuracy, m_search.penetration, m_result.stats);
		found = std::max(found, depth.lower);
		if (!(depth.upper < range)) return false;
		set(gapBetween(-depth.upper, -depth.lower));
		return true;
	}

	// The last per cent of a depth is not worth its cost, unless a limit asks for it.
	DepthAccuracy depthAccuracy(double range) const
	{
		DepthAccuracy accuracy;
		accuracy.absolute = kDepthAccuracy * std::min(m_context.a.asset().radius, m_context.b.asset().radius);
		if (limit() < kInfinity)
		{
			// A coarser answer could not be told from one beyond the range.
			accuracy.absolute =
				std::max(accuracy.absolute, std::min(0.5 * limit(), kShallow * std::min(range, m_settings.tolerance)));
			accuracy.relative = 0;
		}
		if (m_settings.distance || limit() < kInfinity) accuracy.cellLimit *= kMoreCells;
		return accuracy;
	}
	// So deep at some point, perhaps deeper.
	void setInside(double depth)
	{
		if (!m_settings.distance)
		{
			set({-depth, kInfinity, true});
			return;
		}
		const PointBoxes counting(m_result.stats);
		const DepthBound whole =
			wholePenetration(m_context, depthAccuracy(m_settings.tolerance), m_search.penetration, m_result.stats);
		set(gapBetween(-whole.upper, -whole.lower));
		m_result.deep = true;
	}

	// Nothing within the tolerance: the closest accepted pair, then the certificate within its distance.
	void farApart()
	{
		double distance = 0;
		if (limit() < kInfinity || !m_walk.widenToNearest(distance))
		{
			fromSurfaces();
			return;
		}
		m_found = m_walk.found();
		set(gapApart(m_context, m_result.contacts, distance, m_found.largestCover));
		m_result.contacts.clear();
	}

	// The gap is beyond the tolerance, but for the nodes' covers.
	void setNothingNear(double largestCover) { set({kInfinity, largestCover, false}); }
	void set(const Gap& gap)
	{
		m_result.minDistance = gap.value;
		m_result.errorBound = gap.errorBound;
		m_result.deep = gap.deep;
	}

	const QueryContext& m_context;
	const GapSettings& m_settings;
	GapWalk& m_walk;
	GapCache::Search& m_search;
	GapResult& m_result;
	FoundPairs m_found;
	bool m_isOfSurfaces = false;  // the gap, whatever answered
};
}  // namespace

void certifyGap(const QueryContext& context, const GapSettings& settings, GapWalk& walk, GapCache::Search& search,
				GapResult& result)
{
	GapSearch(context, settings, walk, search, result).run();
}
}  // namespace clod
