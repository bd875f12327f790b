// SPDX-License-Identifier: Zlib
// Bodies that were made in a sheet (created, or put, half way through it). No facet may tell of a thin wall beneath the
// sheet. Its corners beneath become contacts of the faces that they would have gone in through, as if they had
// (FacetRecord::isThrough): from the side that the body's middle is on or, where the middle is almost in the sheet, the
// side that the forces come from.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/FacetFinder.h"

namespace clod
{
class SheetCrossing
{
public:
	// May there be crossings that no facet tells of? Bodies at rest need not be looked at.
	static bool isDeep(const FacetQuestion& question, const std::vector<Facet>& facets);
	// To which side of a plane does A belong? Decided by the way in of what has gone in through the sheet; else by the
	// forces, where A's middle is almost in the plane; else by the middle. Below zero: beneath. Frame A.
	CLOD_API static double sideOf(const PointRules& rules, const Vec3& normal, double offset, const Vec3& way);
	// Adds contacts for the edges of A that would still cross B, a sheet, after the shift, which leads out of the
	// facets known; and removes overlaps that go against them. was: what it returned in the last dispatch. Returns
	// whether A was made in the sheet.
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
	bool findBeyond(Crossing& crossing);
	std::uint32_t polygonOver(std::uint32_t face, const Vec3& place) const;
	Facet facetOf(const Crossing& crossing) const;

	const FacetQuestion* m_question = nullptr;
	const ContactSurface* m_a = nullptr;
	Transform m_bFromA;
	Vec3 m_way;  // of what went through before, or zero
	std::vector<Crossing> m_crossings;
	std::vector<Facet> m_beyond;
};
}  // namespace clod
