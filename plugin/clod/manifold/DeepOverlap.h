// SPDX-License-Identifier: Zlib
// Overlaps whose depth no facet tells: what is inside is too far from the surface, or the bodies reach through each
// other with no corner inside, or convex bodies are held by facets on both sides of what they got through.
//
// Where no corner is inside, places on edges that are all near the surface that they came in through become contacts
// that go their mean way out, each as far as it is inside. Else the pair gets one direction out, which
// is kept from step to step. At first it is the mean way out of the corners inside; for convex bodies, and where no
// corner is inside, the shortest way out of the two hulls (the nearest face of the hull of their differences a - b:
// some 300 support values). Each place inside becomes a contact that goes that way, as far as it is out of both hulls,
// or as itself comes out where all go that way. A body that is wholly inside, far from any surface, is looked at as a
// whole.
#pragma once
#include <vector>

#include "clod/manifold/FacetFinder.h"

namespace clod
{
class DeepOverlap
{
public:
	// Appends the contacts, and returns the direction to be kept, from B to A, or zero. kept: the one to go on with,
	// pushed: that of the last step's impulses, or zero. isDeep: one body is known to be inside the other, near a
	// surface or not.
	Vec3 find(const FacetQuestion& question, const std::vector<Contact>& contacts, bool isDeep, const Vec3& kept,
			  const Vec3& pushed, std::vector<Facet>& facets);

	// Are both bodies convex, or nearly so?
	static bool areConvex(const FacetQuestion& question);

private:
	struct Inside
	{
		Vec3 point, way;  // frame A; the way A has to go until the place is outside; length: the depth
		double wall;      // what is inside by no more came in through the surface near it
		std::uint32_t nodeA, nodeB, feature;
		bool ofA;
	};
	static Inside insideAt(const FacetQuestion& question, const Contact& contact, bool ofA, const Vec3& place,
						   const Vec3& there, const ContactSurface::Nearest& near, std::uint32_t feature);
	void probe(const FacetQuestion& question, const Contact& contact, bool ofA, bool atCrossings);
	void probeWhole(const FacetQuestion& question, bool ofA);
	Vec3 meanWay() const;
	bool isShallow(const FacetQuestion& question, const Vec3& way) const;
	std::vector<Inside> m_inside;
};
}  // namespace clod
