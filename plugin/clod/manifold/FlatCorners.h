// SPDX-License-Identifier: Zlib
// Where two flats lie on each other there are as many facets as corners and crossings of edges, and the outermost carry any load
// that all of them do: with one normal, what a rigid motion closes at a place is linear in the place. So a facet is left
// out that lies over what others span, and no lower.
//
// Departs from Bullet's manifolds, which keep four points whatever they leave out: here what is left out is bounded.
#pragma once
#include <vector>

#include "clod/manifold/Facet.h"

namespace clod
{
class FlatCorners
{
public:
	// isNeeded: of each facet. isKnown: those that the solver had in the step before, which are preferred.
	void choose(const std::vector<Facet>& facets, double length, const std::vector<char>& isKnown,
				std::vector<char>& isNeeded);

private:
	struct Place
	{
		double x, y;            // in the plane,
		double distance, then;  // over it
		std::uint32_t facet;
		bool isKnown;
	};
	struct Over  // what the corners span at a place
	{
		double beside = 0;  // how far from what they span; there, at the nearest place of it:
		double distance = 0, then = 0;
	};
	Over over(const Place& place) const;
	double excess(const Place& place, double length) const;
	void addCorner(std::uint32_t place);
	std::vector<Place> m_places;           // of one normal
	std::vector<std::uint32_t> m_corners;  // of them, counterclockwise
	std::vector<std::uint32_t> m_sorted;
};
}  // namespace clod
