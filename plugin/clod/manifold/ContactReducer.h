// SPDX-License-Identifier: Zlib
// From facets to the few points that a solver gets, in groups of at most four: those that carry by the pair's own solve
// and those that carried in the step before come first, then what is farthest from all chosen. A point goes on as the
// one of the same two features, or the nearest; it keeps its group.
#pragma once
#include <array>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "clod/manifold/FacetFinder.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
class ContactReducer
{
public:
	// The most points of bodies that are open to each other: more cost a solver time, and hold nothing better. Where one
	// holds the other from opposing sides, as a hole does a pin, each side needs its own.
	static constexpr std::uint32_t kMostOpen = 32;
	// points: one a facet, in their order. previous: with B's motion and impulses.
	void reduce(const std::vector<Facet>& facets, const std::vector<ContactPoint>& points, const ClusterSet& previous,
				const PointRules& rules, ClusterSet& next);
	// How many points the last reduction made, and of which facet each.
	std::size_t count() const { return m_chosen.size(); }
	std::uint32_t facetOf(std::size_t slot, std::size_t index) const { return m_facetOf[slot][index]; }
	bool isChosen(std::size_t facet) const { return m_candidates[facet].isChosen; }

private:
	static constexpr std::uint32_t kMostPoints = kMaxClusters * kClusterPoints;
	struct Candidate
	{
		std::uint32_t previous = kNone;
		double weight = 0;  // > 0: carries or carried
		double apart = 0;   // from all chosen, of one that may yet be; see distanceBetween
		bool isChosen = false, isOfFlat = false, isLow = false;  // of the flat's points
	};
	struct Load
	{
		std::uint32_t candidate = 0;
		double load = 0;
	};
	bool holdFromOpposingSides() const;
	void match(const ClusterSet& previous);
	void thinOutFlats();
	void carryLoad();
	std::size_t unload(std::array<Load, 4>& loads) const;
	bool isNew(std::uint32_t i) const { return m_candidates[i].previous == kNone; }
	double lowest(std::uint32_t i) const;
	void choose(bool foundOnce);
	void spread(bool withPossible, double highest = std::numeric_limits<double>::infinity());
	void take(std::uint32_t i);
	void place(const ClusterSet& previous, ClusterSet& next);
	double distanceBetween(std::uint32_t i, std::uint32_t j) const;

	const std::vector<Facet>* m_facets = nullptr;
	const std::vector<ContactPoint>* m_points = nullptr;
	double m_length = 1;
	std::uint32_t m_most = kMostPoints;
	std::vector<Candidate> m_candidates;
	std::vector<char> m_isNeeded;
	std::vector<std::uint32_t> m_chosen, m_order, m_carrying;
	std::vector<std::pair<double, std::uint32_t>> m_byNormal;  // its x, sorted
	std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> m_links;  // squared distance, old point, candidate
	std::array<std::array<std::uint32_t, kClusterPoints>, kMaxClusters> m_facetOf{};
};
}  // namespace clod
