// SPDX-License-Identifier: Zlib
// Which facets are contacts, where several are found at one place: of those that overlap the ones on the boundary of the
// difference, of those that meet in a convex ridge the one that the motion crosses last, of those that meet in a valley
// all (README.md, rules).
#pragma once
#include <utility>
#include <vector>

#include "clod/collide/LeastShift.h"
#include "clod/manifold/FacetFinder.h"
#include "clod/manifold/FlushBodies.h"

namespace clod
{
class FacetChoice
{
public:
	// Removes the facets that are no contacts. last: the facets that the solver got in the last step, at that pose.
	void choose(const FacetQuestion& question, const std::vector<FacetRecord>& last, const Transform& lastAFromB,
				std::vector<Facet>& facets, const JoinedBodies& joined = {});
	// The least translation that takes A out of the overlaps that were kept.
	const Vec3& shift() const { return m_shift; }

private:
	bool overlapsAt(const Facet& facet, const Vec3& shift) const;
	Vec3 centerOf(const Facet& facet) const;
	void knowAgain(const std::vector<FacetRecord>& last, const Transform& lastAFromB, std::vector<Facet>& facets);
	bool wentThrough(const Facet& facet, const FacetRecord* known, const std::vector<FacetRecord>& last,
					 const Transform& lastAFromB) const;
	void dropTooDeep(const std::vector<FacetRecord>& last, const Transform& lastAFromB, std::vector<Facet>& facets) const;
	void dropWhatHoldsThrough(std::vector<Facet>& facets);
	void followThrough(std::vector<Facet>& facets);
	void dropInner(std::vector<Facet>& facets);
	double lacking(const Facet& facet) const;
	bool isSatisfied(const Facet& facet) const;
	void takeOut(const Facet& facet);
	bool takeBeside(std::vector<Facet>& facets);
	// ParallelEdges.cpp
	struct Parallels
	{
		std::uint32_t levelA, levelB, edgeA, edgeB, facet;  // one that is of both edges
	};
	void listParallels(const std::vector<Facet>& facets, std::uint32_t index);
	void passParallels(const JoinedBodies& joined, std::vector<Facet>& facets);
	void passParallels(Span<Parallels> ofFacets, const JoinedBodies& joined, std::vector<Facet>& facets);
	void limitWaysOut(std::vector<Facet>& facets) const;
	void dropRidges(std::vector<Facet>& facets);
	bool mayDecide(const Facet& facet) const;
	bool isBeyondRidge(const Facet& best, const Vec3& center, const Facet& other) const;
	void keepValleys(std::vector<Facet>& facets);
	bool isPassed(const Facet& facet) const;
	bool meetInValley(const Facet& contact, const Vec3& centerOfContact, const Facet& other, const Vec3& center) const;
	void removeDropped(std::vector<Facet>& facets) const;

	static constexpr double kTie = 1e-4;  // of the length: heights, now and at the end of the step, that count as equal

	const FacetQuestion* m_question = nullptr;
	std::vector<Parallels> m_parallels;
	struct WayOut
	{
		std::uint64_t feature;
		double distance;
	};
	std::vector<WayOut> m_waysOut;
	// Facets of m_order by their points' coordinate on the axis where these are spread farthest.
	struct Places
	{
		Vec3 axis;
		std::vector<std::pair<double, std::uint32_t>> sorted;  // coordinate, position in m_order
		void sort(const std::vector<Facet>& facets, const std::vector<std::uint32_t>& order, Vec3 Facet::*point);
		// Those whose coordinate is no farther than that from the point's.
		Span<std::pair<double, std::uint32_t>> near(const Vec3& point, double distance) const;
	};

	std::vector<ShiftPlane> m_planes;
	Vec3 m_shift;
	Places m_placesA, m_placesB;
	std::vector<std::uint32_t> m_order, m_beside;
	std::vector<Vec3> m_centers;  // of m_order's
	std::vector<char> m_isKept;
	std::vector<Facet> m_through;
	std::vector<char> m_isKnown;  // was a contact in the last step, too
};
}  // namespace clod
