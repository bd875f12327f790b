// SPDX-License-Identifier: Zlib
// The contact points of a pair, made of facets of its Minkowski difference: facets are found (FacetFinder.h) and chosen
// (FacetChoice.h), it is worked out which of them carry (PairSolve.h), and they are reduced to what a solver gets
// (ContactReducer.h). Where no facet tells a depth there is a way out (DeepOverlap.h).
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/ContactReducer.h"
#include "clod/manifold/DeepOverlap.h"
#include "clod/manifold/FacetChoice.h"
#include "clod/manifold/FacetFinder.h"
#include "clod/manifold/FlushBodies.h"
#include "clod/manifold/LevelSwitch.h"
#include "clod/manifold/PairSolve.h"
#include "clod/manifold/SheetCrossing.h"

namespace clod
{
// What lasts of a pair from step to step, besides its points. All else is scratch.
struct FacetMemory
{
	std::vector<FacetRecord> reduced;  // those that the solver got, in the order of its points,
	Transform aFromB;                  // and where
	SwitchMemory levels;
	Vec3 through;                // mean normal of those that what is through went in by, frame B; zero: nothing is
	bool isMadeIn = false;       // while what is through a sheet was there from the beginning (SheetCrossing.h)
	Vec3 wayOut;                 // while there is a depth that no facet answers: the points say nothing of it but this
	bool isDeep() const { return wayOut != Vec3{}; }
};

// Is a body held between its contacts, like a pin in its hole, so that no direction leads out of all that touch or
// overlap, or may in this step unless it goes far? The play is then of the order of the margins, and a level that
// deviates by more jams although it keeps its error bound.
CLOD_API bool isHeldBetween(const FacetQuestion& question, const std::vector<Facet>& facets);
// Or is it pressed in somewhere, like a tooth between flanks, so that only a direction at a sharp angle to these leads
// out?
CLOD_API bool isJammedBetween(const FacetQuestion& question, const std::vector<Facet>& facets);

// For any number of pairs, one after the other.
class CLOD_API FacetContacts
{
public:
	// The facets of the accepted pairs. previous: with B's motion and impulses; it and the memory are needed until
	// reduce(). goesOn: the facets that the solver got last stay, as nothing but the motion of the rules has changed.
	// joined: other bodies that may be touched where edges of these go on in them.
	void find(const ContactBody& a, const ContactBody& b, const Transform& aFromB, const PointRules& rules,
			  const std::vector<Contact>& contacts, const ClusterSet& previous, FacetMemory& memory,
			  bool goesOn = false, const JoinedBodies& joined = {});
	// Would the facets found last hold the bodies however they move?
	bool holdBetween() const { return isHeldBetween(m_question, m_facets); }
	bool jamBetween() const { return isJammedBetween(m_question, m_facets); }
	// Makes contacts of those found last. isDeep: one body is known to be inside the other.
	void settle(const std::vector<Contact>& contacts, bool isDeep);
	// Of A's material relative to B's, frame A: the coming step's, as these contacts alone would have it.
	const RelativeMotion& expectedMotion() const { return m_expected; }
	std::size_t size() const { return m_facets.size(); }
	// Of those found last, the ones a solver gets.
	void reduce(ClusterSet& next);
	// By how much a motion may differ from the expected one, at the bodies' farthest points, before it meets facets
	// that are not among the reduced ones.
	double spare() const { return m_spare; }
	// How deep the bodies come by the expected motion though a solver meets all rows (PairSolve::missed).
	double missed() const { return m_missed; }
	// Does a point of the reduced set go on as it was named?
	bool isHeld(std::size_t slot, std::size_t point) const
	{
		return m_facets[m_reducer.facetOf(slot, point)].kind == Facet::Kind::kHeld;
	}

private:
	void takeUpWhatStays(const std::vector<Contact>& contacts);
	void takeUpAside(const FacetRecord& record);
	void takeUpThrough(const ContactPoint& point, const FacetRecord& record);
	void takeUp();
	ContactPoint pointOf(const Facet& facet) const;
	void nameFaces(const Facet& facet, const Transform& bFromA, ContactPoint& point) const;
	void dropWhatJams();
	void answerDepth(const std::vector<Contact>& contacts, bool isDeep);

	FacetQuestion m_question;
	std::vector<Facet> m_facets, m_deepFacets;
	const ClusterSet* m_previous = nullptr;
	FacetMemory* m_memory = nullptr;
	bool m_goesOn = false;
	std::vector<ContactPoint> m_points;
	FacetFinder m_finder;
	FacetChoice m_choice;
	LevelSwitch m_switch;
	DeepOverlap m_deep;
	SheetCrossing m_sheet;
	RelativeMotion m_expected;
	double m_spare = 0, m_missed = 0;
	PairSolve m_solve;
	ContactReducer m_reducer;
};
}  // namespace clod
