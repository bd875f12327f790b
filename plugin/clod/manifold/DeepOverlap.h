// SPDX-License-Identifier: Zlib
// A depth that no facet answers: bodies overlap so far that what is inside has lost sight of the surface, or reach through
// each other with no corner inside, or, convex, are held by facets on either side of what they got through. One direction for
// the pair, kept from the step before; else the mean way out of the corners inside, or, of convex bodies and where there are
// none, the shortest out of the hulls (the nearest face of the hull of their differences a - b: some 300 supports). And a
// contact for each place inside whose own way out does not oppose it. A body that is wholly inside, far from any surface, is
// looked at as a whole.
#pragma once
#include <vector>

#include "clod/manifold/FacetFinder.h"

namespace clod
{
class DeepOverlap
{
public:
	// Appends the contacts, and returns the direction, from B to A; zero where nothing is found inside. kept: a direction
	// to go on with, or zero. isDeep: one body is known to be inside the other, near a surface or not.
	Vec3 find(const FacetQuestion& question, const std::vector<Contact>& contacts, bool isDeep, const Vec3& kept,
			  std::vector<Facet>& facets);

	// Are both all but their hulls?
	static bool areConvex(const FacetQuestion& question);

private:
	struct Inside
	{
		Vec3 point, way;  // frame A; the way A has to go until the place is outside; length: the depth
		std::uint32_t nodeA, nodeB, feature;
		bool ofA;
	};
	void probe(const FacetQuestion& question, const Contact& contact, bool ofA, bool atCrossings);
	void probeWhole(const FacetQuestion& question, bool ofA);
	Vec3 wayOut(const FacetQuestion& question, const Vec3& kept, bool isCrossing, bool areHulls) const;
	std::vector<Inside> m_inside;
};
}  // namespace clod
