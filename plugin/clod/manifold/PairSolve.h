// SPDX-License-Identifier: Zlib
// What a pair's contacts alone would make of the coming step: which of many facets carry (a multiplier each), and where
// the bodies end, which is where the second order of each facet is taken. A few Gauss-Seidel sweeps, Coulomb's friction
// in the direction of sliding; of a body that lies alone on another the exact balance besides (BodyBalance.h).
#pragma once
#include <vector>

#include "clod/manifold/BodyBalance.h"
#include "clod/manifold/FacetFinder.h"

namespace clod
{
inline constexpr double kTakenBackShare = 0.2;  // of a depth that a step takes back

// What is asked of the normal velocity: normal . v dt >= -row. height: margins taken off.
inline double velocityRow(double height, double bend)
{
	return height > 0 ? height + bend : kTakenBackShare * height + (bend < 0 ? bend : 0);
}

// How far a facet's two features are from being over each other; at most 0 where they are.
struct Beside
{
	double distance;        // in the facet, along edges
	double way = distance;  // that features have to go, at least
};
Beside besideAt(const FacetQuestion& question, const Facet& facet, const Transform& aFromB);

class PairSolve
{
public:
	// Sets linear, then and multiplier of the facets. Facets that are merely possible become paths where the solved
	// motion meets them; they are removed where it passes beside them, under their planes; the others stay for what
	// third bodies may do.
	void solve(const FacetQuestion& question, std::vector<Facet>& facets);
	// Of A's material relative to B's, as solved last.
	RelativeMotion motion() const { return motionBetween(m_a, m_b, m_timeStep); }
	// By how much more than solved the bodies would have to move to meet one of the facets removed, to first order.
	double spare() const { return m_spare; }
	// How far features come beneath each other by that motion although all rows are met: what these do not know of bodies
	// that turn far.
	double missed() const { return m_missed; }

private:
	struct Row
	{
		Vec3 armA, armB;            // from the middles
		Vec3 normal, turnA, turnB;  // of unit velocities
		Vec3 pushA, pushB;          // change of angular velocity of a unit impulse
		double effectiveMass;
		double wanted = 0;  // the least speed at which the bodies have to part
	};
	void makeRows(const PointRules& rules, const std::vector<Facet>& facets);
	double speedOf(const Row& row) const;
	void push(const Row& row, double impulse);
	void push(const Row& row, const Vec3& impulse);
	void rub(const Row& row, double most, Vec3& friction);
	void sweep(const FacetQuestion& question, const std::vector<Facet>& facets);
	void balance(const FacetQuestion& question, const std::vector<Facet>& facets);
	double moveOn(const FacetQuestion& question, std::vector<Facet>& facets);
	void removePassed(const FacetQuestion& question, std::vector<Facet>& facets);
	std::vector<Row> m_rows;
	std::vector<std::uint32_t> m_acting;  // facets that are more than possible
	std::vector<Vec3> m_frictions;  // of the facets, impulses
	std::vector<double> m_multipliers;
	BodyBalance m_balance;
	bool m_movesA = false, m_movesB = false;  // impulses do
	PairBody m_a, m_b;  // as solved,
	Transform m_after;  // and B in A by it at the end of the step
	double m_timeStep = 0, m_spare = 0, m_missed = 0;
};
}  // namespace clod
