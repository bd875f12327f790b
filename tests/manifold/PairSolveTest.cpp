// SPDX-License-Identifier: GPL-3.0-or-later
// What a pair's own solve makes of single facets, beside closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/manifold/FacetPair.h"

namespace clod::test
{
namespace
{
// Two bodies of unit mass in a step of 1/60 s.
FacetQuestion questionOf(const HierarchyPointer& a, const HierarchyPointer& b, const Transform& aFromB)
{
	FacetQuestion question{contactBody(*a), contactBody(*b), aFromB, {}, {}, {}};
	PointRules& rules = question.rules;
	rules.length = std::sqrt(0.75);
	rules.timeStep = 1.0 / 60;
	setUnitMasses(rules);
	rules.b.center = aFromB.translation;
	return question;
}

// The edge of the surface whose middle is there.
std::uint32_t edgeAt(const ContactSurface& surface, const Vec3& middle)
{
	for (std::uint32_t e = 0; e < surface.edges().size(); ++e)
	{
		const auto& [from, to] = surface.edges()[e].vertex;
		if (length(0.5 * (surface.vertices()[from] + surface.vertices()[to]) - middle) < 1e-6) return e;
	}
	return kNone;
}
}  // namespace

// A corner that a step of fast turning carries round another to its far side has not been pushed through it: what its row
// asks of velocities is no more than turning bends a way by.
TEST(PairSolve, CornersThatGoRoundEachOtherAskForNoSpeed)
{
	const HierarchyPointer cube = cubeOf();
	for (const double turn : {0.1, 1.0, 2.5, 3.0})
	{
		FacetQuestion question = questionOf(cube, cube, at({0.1, 0, 0.9}));
		PointRules& rules = question.rules;
		rules.b.angular = {0, 0, turn / rules.timeStep};
		Facet facet{};
		facet.kind = Facet::Kind::kVertexVertex;
		const ContactSurface& surface = question.a.surface(0);
		for (std::uint32_t v = 0; v < surface.vertices().size(); ++v)
		{
			if (length(surface.vertices()[v] - Vec3{0.5, 0.5, 0.5}) < 1e-6) facet.featureA = v;
			if (length(surface.vertices()[v] - Vec3{0.5, 0.5, -0.5}) < 1e-6) facet.featureB = v;
		}
		// B's corner is below A's, and moves beside it; it ends beyond.
		facet.onA = {0.5, 0.5, 0.5};
		facet.onB = question.aFromB * Vec3{0.5, 0.5, -0.5};
		facet.normal = normalized(facet.onA - facet.onB);
		facet.distance = length(facet.onA - facet.onB);
		std::vector<Facet> facets = {facet};
		PairSolve solve;
		solve.solve(question, facets);
		ASSERT_EQ(facets.size(), 1u);
		EXPECT_GE(facets[0].curvature(), -std::min(turn, 0.04 / turn) * 2 * turn) << turn;
	}
}

// An edge lies on another, askew by little. As it goes aside the place where they cross runs along both, and there the edge is
// lower by as much as the body turns.
TEST(PairSolve, EdgesMeetWhereTheirCrossingHasRunTo)
{
	const HierarchyPointer cube = cubeOf(1);
	for (const double askew : {0.02, 0.1, 0.5})
		for (const double turn : {0.002, 0.01})
		{
			const double run = 0.3, way = run * std::tan(askew);
			const Mat3 yaw = rotationFromQuaternion(0, std::sin(askew / 2), 0, std::cos(askew / 2));
			// B's edge passes over the middle of A's.
			FacetQuestion question = questionOf(cube, cube, at(Vec3{0.5, 0.5, 0} - yaw * Vec3{-0.5, -0.5, 0}, yaw));
			PointRules& rules = question.rules;
			Facet facet{};
			facet.kind = Facet::Kind::kEdgeEdge;
			facet.featureA = edgeAt(question.a.surface(0), {0.5, 0.5, 0});
			facet.featureB = edgeAt(question.b.surface(0), {-0.5, -0.5, 0});
			ASSERT_NE(facet.featureA, kNone);
			ASSERT_NE(facet.featureB, kNone);
			facet.normal = {0, -1, 0};
			facet.span({0.5, 0.5, 0}, true);
			rules.b.angular = {turn / rules.timeStep, 0, 0};
			rules.b.linear = Vec3{way / rules.timeStep, 0, 0} - cross(rules.b.angular, facet.onB - rules.b.center);
			std::vector<Facet> facets = {facet};
			PairSolve solve;
			solve.solve(question, facets);
			ASSERT_EQ(facets.size(), 1u);
			EXPECT_NEAR(std::abs(facets[0].then), turn * run, 0.1 * turn * run) << askew << " " << turn;
			EXPECT_NEAR(facets[0].curvature(), facets[0].then, 1e-9) << askew << " " << turn;
		}
}

TEST(PairSolve, AnImpulseBesideBothCentresTurnsBothBodies)
{
	FacetQuestion question{};
	question.rules.length = 1;
	question.rules.timeStep = 0.01;
	setUnitMasses(question.rules);
	question.rules.b.center = {0, 2, 0};
	question.rules.b.linear = {0, -1, 0};
	Facet facet{};
	facet.kind = Facet::Kind::kDeep;
	facet.reach = Facet::Reach::kNear;
	facet.onA = facet.onB = {0.5, 1, 0};
	facet.normal = {0, -1, 0};
	std::vector<Facet> facets = {facet};
	PairSolve solve;
	solve.solve(question, facets);
	// Unit masses and inertias, arms of a half: 1 / (1 + 1 + 1/4 + 1/4) of the closing speed of 1.
	ASSERT_EQ(facets.size(), 1u);
	EXPECT_NEAR(facets[0].multiplier, 0.4, 1e-9);
	EXPECT_NEAR(facets[0].linear, 0, 1e-12);
	EXPECT_NEAR(solve.motion().angular.z, -0.4, 1e-9);
}
}  // namespace clod::test
