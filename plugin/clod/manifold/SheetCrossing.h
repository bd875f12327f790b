// SPDX-License-Identifier: Zlib
// Bodies that were made in a sheet. Of thin walls no facet may tell: nothing of them is near above what is beneath. Their
// corners beneath are contacts of the faces that they would have gone in through, as if they had (FacetRecord::isThrough), from
// the side that the body's middle is on, or, where it is all but in the sheet, against the forces.
#pragma once
#include <vector>

#include "clod/manifold/FacetFinder.h"

namespace clod
{
class SheetCrossing
{
public:
	// May there be more to tell of than facets do? What rests need not be asked.
	static bool isDeep(const FacetQuestion& question, const std::vector<Facet>& facets);
	// To which side of a face, or of what lies across such a normal, does A belong: by the way of what has gone in through the
	// sheet, the forces where its middle is all but in it, or its middle? Below zero: beneath. Frame A.
	static double sideOf(const PointRules& rules, const Vec3& normal, double offset, const Vec3& way);
	// Adds the contacts of edges of A that would cross B, a sheet, even were A moved by the shift, which is out of the facets
	// that are known; and removes overlaps that go against it. was: in the last dispatch. Is it made in?
	bool find(const FacetQuestion& question, const std::vector<Contact>& contacts, const Vec3& shift, bool was,
			  std::vector<Facet>& facets);

private:
	struct Crossing
	{
		std::uint32_t nodeA, edge, beyond;  // beyond: the edge's vertex on the other side
		std::uint32_t face;                 // of B, looking to the side that it belongs to
		bool operator<(const Crossing& other) const { return edge < other.edge; }
		bool operator==(const Crossing& other) const { return edge == other.edge; }
	};
	bool leadsOut(const Vec3& shift, const std::vector<Facet>& facets) const;
	void collect(const std::vector<Contact>& contacts);
	template <class Each>
	void forEachCrossed(std::uint32_t edge, const Vec3& shift, Each each) const;
	bool crossesAny(std::uint32_t edge, const Vec3& shift) const;
	bool findBeyond(Crossing& crossing);
	std::uint32_t faceToSide(std::uint32_t face) const;
	std::uint32_t polygonOver(std::uint32_t face, const Vec3& place) const;
	Facet facetOf(const Crossing& crossing) const;
	static void add(const Facet& facet, std::vector<Facet>& facets);

	const FacetQuestion* m_question = nullptr;
	const ContactSurface* m_a = nullptr;
	Transform m_bFromA;
	Vec3 m_way;  // of what went through before, or zero
	std::vector<Crossing> m_crossings;
	std::vector<Facet> m_beyond;
};
}  // namespace clod
