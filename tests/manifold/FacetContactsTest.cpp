// SPDX-License-Identifier: GPL-3.0-or-later
// Contacts of two boxes where closed forms know them, and of random poses by what must hold: apart, nothing claims a
// depth; a point lies on both surfaces; exchanged bodies have the same contacts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clod/hierarchy/ConvexPiece.h"
#include "clod/manifold/LevelSwitch.h"
#include "clod/manifold/PairSolve.h"
#include "clod/query/Query.h"
#include "tests/manifold/FacetPair.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// About any axis, each part of the quaternion at most so long.
Mat3 someTurn(Random& random, double most)
{
	const double z = uniform(random, -most, most), y = uniform(random, -most, most), x = uniform(random, -most, most);
	return rotationFromQuaternion(x, y, z, 1);
}
}  // namespace

// What lies outside of these boxes is never looked at: they hold features wherever the step may carry them.
TEST(MovedNodes, BoxesHoldFeaturesAllTheWay)
{
	const HierarchyPointer cube = cubeOf();
	Random random(7);
	for (int i = 0; i < 40; ++i)
	{
		const auto some = [&](double most) { return uniform(random, -most, most); };
		const Mat3 turn = someTurn(random, 1);
		FacetQuestion question{contactBody(*cube), contactBody(*cube), at({some(1), 1.1, some(1)}, turn), {}, {}, {}};
		question.aFromBUnforced = question.aFromBThen = question.aFromB;
		question.aFromBUnforced.translation += Vec3{some(0.5), some(0.5), some(0.5)};
		question.aFromBThen.translation += Vec3{some(0.5), some(0.5), some(0.5)};
		question.aFromBThen.rotation = someTurn(random, 0.1) * turn;
		std::vector<Contact> contacts(1);
		contacts[0].nodeA = contacts[0].nodeB = 0;
		ASSERT_EQ(question.b.levelOf(0), 0u);
		MovedNodes nodes;
		nodes.start(question, contacts, false);
		const ContactSurface& surface = question.b.surface(0);
		const auto isHeld = [&](const Box& box, std::uint32_t vertex)
		{
			const Vec3 own = surface.vertices()[vertex], now = question.aFromB * own;
			for (const Vec3& end : {now, question.aFromBThen * own, question.aFromBUnforced * own})
				if (const Vec3 p = now + kPathReach * (end - now); !box.meets({p, p}, 1e-12)) return false;
			return true;
		};
		MovedNode& moved = nodes.of(0);
		nodes.listNear(moved, {{-9, -9, -9}, {9, 9, 9}});
		ASSERT_FALSE(moved.corners.empty() || moved.edges.empty());
		for (const MovedCorner& corner : moved.corners) EXPECT_TRUE(isHeld(corner.box, corner.index)) << i;
		for (const MovedEdge& edge : moved.edges)
			for (const std::uint32_t end : surface.edges()[edge.index].vertex) EXPECT_TRUE(isHeld(edge.box, end)) << i;
	}
}

TEST(FacetContacts, AFlatCubeOnACubeHasTheCornersOfTheCommonRectangle)
{
	for (const int cells : {1, 2, 6})
	{
		const std::vector<ContactPoint> points = FacetPair(cubeOf(cells), cubeOf(cells), at({0.3, 1.0002, 0.2})).points();
		ASSERT_EQ(points.size(), 4u) << cells;
		for (const ContactPoint& point : points)
		{
			EXPECT_NEAR(point.normal.y, -1, 1e-6);
			EXPECT_NEAR(point.height, 0.0002, 1e-6);
			EXPECT_TRUE(std::abs(point.pointOnA.x - 0.5) < 1e-5 || std::abs(point.pointOnA.x + 0.2) < 1e-5);
			EXPECT_TRUE(std::abs(point.pointOnA.z - 0.5) < 1e-5 || std::abs(point.pointOnA.z + 0.3) < 1e-5);
		}
	}
}

// A cube stands on an equal one, as in a tower that sways: a little aside, leaning, sunk in by less or more. Each corner
// of what they have in common carries, if it is sunk in at all, and nothing sideways does.
TEST(FacetContacts, AnEqualCubeStandsOnAllCornersHoweverItLeans)
{
	const PatchedMesh mesh = boxMesh({1, 1, 1}, {1, 1, 1}, 1);
	PatchedMesh oneHull = mesh;
	std::fill(oneHull.patch.begin(), oneHull.patch.end(), 0u);
	Random random(5);
	for (int i = 0; i < 4000; ++i)
	{
		const HierarchyPointer cube = patchHierarchy(i % 2 == 0 ? mesh : oneHull);
		const double aside = std::pow(10, uniform(random, -6, -2)), lean = std::pow(10, uniform(random, -6, -2.5));
		const double sunk = std::pow(10, uniform(random, -6, -2));
		const auto some = [&](double most) { return uniform(random, -most, most); };
		const Vec3 place{some(aside), 1 - sunk, some(aside)};
		const Transform pose = at(place, someTurn(random, lean));
		const auto depthAt = [&](double x, double z)  // of the upper one's bottom
		{
			const Vec3 up = pose.rotation * Vec3{0, 1, 0}, bottom = pose * Vec3{0, -0.5, 0};
			return 0.5 - bottom.y + (up.x * (x - bottom.x) + up.z * (z - bottom.z)) / up.y;
		};
		const std::vector<ContactPoint> points = FacetPair(cube, cube, pose).points();
		for (const ContactPoint& point : points)
		{
			ASSERT_LT(point.normal.y, -0.99) << "pose " << i;
			ASSERT_GT(point.height, -depthAt(point.pointOnA.x, point.pointOnA.z) - 1e-3) << "pose " << i;
		}
		for (const double x : {-0.5, 0.5})
			for (const double z : {-0.5, 0.5})
			{
				if (depthAt(x, z) < 1e-4) continue;
				const bool isHeld = std::any_of(points.begin(), points.end(),
												[&](const ContactPoint& p)
												{
													const double beside = std::max(std::abs(p.pointOnA.x - x), std::abs(p.pointOnA.z - z));
													return beside < 2e-3 + 2 * (aside + lean);
												});
				ASSERT_TRUE(isHeld) << "pose " << i << ": aside " << aside << ", leaning " << lean << ", sunk in " << sunk;
			}
	}
}

// A cube sunk in askew, and pressed on so fast that it may turn over within the step: with its lowest corner's contact
// alone it sank on one corner after the other.
TEST(FacetContacts, WhatSinksInFastIsHeldByAllThatIsSunkIn)
{
	const Mat3 askew = rotationFromQuaternion(0.015, 0, 0.01, 1);
	const HierarchyPointer wide = patchHierarchy(boxMesh({4, 1, 4}, {1, 1, 1}, 1));
	FacetPair pair(wide, cubeOf(1), at({0, 0.9, 0}, askew));
	pair.move({0, -0.06, 0});
	const std::vector<ContactPoint> points = pair.points();
	EXPECT_EQ(points.size(), 4u);
	for (const ContactPoint& point : points)
	{
		EXPECT_LT(point.normal.y, -0.999);
		EXPECT_NEAR(point.height, point.pointOnB.y - 0.5, 1e-6);
	}
}

TEST(FacetContacts, CrossedEdgesTouchAtOnePoint)
{
	// Both stand on an edge: the lower one's upper edge along x, the upper one's lower edge along z.
	const double c = std::sqrt(0.5);
	const Mat3 aboutX{{{1, 0, 0}, {0, c, -c}, {0, c, c}}}, aboutZ{{{c, -c, 0}, {c, c, 0}, {0, 0, 1}}};
	const Transform worldFromA = at({}, aboutX), worldFromB = at({0.1, 2 * c + 0.0003, 0.05}, aboutZ);
	const std::vector<ContactPoint> points = FacetPair(cubeOf(), cubeOf(), inverse(worldFromA) * worldFromB).points();
	ASSERT_EQ(points.size(), 1u);
	const Vec3 normal = worldFromA.rotation * points[0].normal, place = worldFromA * points[0].pointOnA;
	EXPECT_NEAR(normal.y, -1, 1e-6);
	EXPECT_NEAR(points[0].height, 0.0003, 1e-6);
	EXPECT_NEAR(place.x, 0.1, 1e-5);
	EXPECT_NEAR(place.z, 0, 1e-5);
}

TEST(FacetContacts, WhatIsMetOnTheWayIsAContactAndWhatIsPassedIsNone)
{
	FacetPair head(cubeOf(), cubeOf(), at({3, 0.1, 0.2}));
	head.move({-2.5, 0, 0});
	const std::vector<ContactPoint> points = head.points();
	ASSERT_FALSE(points.empty());
	double nearest = 10;
	for (const ContactPoint& point : points)
	{
		// The sides that it would only be turned to stay where they are.
		EXPECT_NEAR(point.normal.x, point.rebounds ? -1 : 0, 1e-6);
		EXPECT_GT(point.height, 0);
		if (point.rebounds) nearest = std::min(nearest, point.height);
	}
	EXPECT_NEAR(nearest, 2, 1e-5);
	FacetPair past(cubeOf(), cubeOf(), at({3, 1.05, 0.2}));
	past.move({-2.5, 0, 0});
	EXPECT_TRUE(past.points().empty());
	FacetPair along(cubeOf(), cubeOf(), at({0.7, 1.0003, 0.2}));
	along.move({-2.5, 0, 0});
	const std::vector<ContactPoint> sides = along.points();
	EXPECT_FALSE(sides.empty());
	// The face that it flies along, none that it would hit.
	for (const ContactPoint& point : sides) EXPECT_NEAR(point.normal.x, 0, 1e-6);
}

// B comes down on two of its corners. The two others are higher than it falls: what a third body makes of the step may
// bring them down, but nothing rebounds from them, nor are they there where they would not come down on A.
TEST(FacetContacts, WhatAThirdBodyMayLeadToIsAContactThatDoesNotRebound)
{
	const auto higherOf = [](double aside)
	{
		const double cosine = 0.99, sine = std::sqrt(1 - cosine * cosine);
		const Mat3 tilted{{{cosine, -sine, 0}, {sine, cosine, 0}, {0, 0, 1}}};
		const HierarchyPointer plate = patchHierarchy(boxMesh({4, 1, 4}, {2, 2, 2}, 1));
		FacetPair pair(plate, cubeOf(), at({aside, 0.75 + 0.5 * (cosine + sine), 0}, tilted));
		pair.move({-0.9, -0.28, 0});
		int lower = 0, higher = 0;
		for (const ContactPoint& point : pair.points())
		{
			const bool isHigh = point.height > 0.35;  // than B's middle is, too
			if (point.normal.y > -0.999) continue;  // the plate's border
			EXPECT_EQ(point.rebounds, point.height < 0.3);
			++(isHigh ? higher : lower);
		}
		EXPECT_GT(lower, 0) << aside;
		return higher;
	};
	EXPECT_EQ(higherOf(0.2), 2);
	EXPECT_EQ(higherOf(2.45), 0);
}

// Bodies with margins, beside each other's faces and under these by less than the margin, that are about to part.
TEST(FacetContacts, WhatIsBesideAFaceIsNotUnderItsMargin)
{
	FacetPair pair(cubeOf(), cubeOf(), at({1.02, 1.03, 0.1}));
	pair.rules.margin = 0.05;
	pair.move({-0.2, 0.1, 0});
	for (const ContactPoint& point : pair.points()) EXPECT_GE(point.height, 0);
}

TEST(FacetContacts, TheSecondOrderOfATurningBodyIsInTheConstraint)
{
	// Over its own corner, B turns about z through its middle: the corner leaves its tangent by w^2 r dt^2 / 2.
	FacetPair turning(cubeOf(), cubeOf(), at({0, 1.0002, 0}));
	turning.move({});
	turning.rules.b.angular = {0, 0, 12};
	turning.rules.b.inverseInertia = {{{1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}}};
	const double turn = 12 * turning.rules.timeStep;
	double most = 0;
	for (const ContactPoint& point : turning.points()) most = std::max(most, std::abs(point.bend));
	EXPECT_LT(most, turn * turn);
	EXPECT_GT(most, 0.1 * turn * turn);
}

TEST(FacetContacts, ApartNothingClaimsADepthAndPointsLieOnBothSurfaces)
{
	const HierarchyPointer solids[] = {cubeOf(), patchHierarchy(ballMesh(0.5, 1)), body("torus", 900).hierarchy,
									   patchHierarchy(singleTriangles(ballMesh(0.5, 1)))};
	Random random(11);
	int met = 0;
	for (int i = 0; i < 400; ++i)
	{
		const HierarchyPointer& a = solids[i % 4];
		const HierarchyPointer& b = solids[(i / 4) % 4];
		const ContactSurface &onA = a->derived<ContactSurfaces>().level(0), &onB = b->derived<ContactSurfaces>().level(0);
		const Mat3 turn = randomRotation(random);
		Transform pose = at(randomRotation(random).row[0], turn);
		// Brought together until the vertices are just outside.
		const double reach = double(a->asset().radius) + double(b->asset().radius);
		double apart = reach, near = 0;
		const auto overlaps = [&](double distance)
		{
			Transform moved = pose;
			moved.translation = distance * pose.translation;
			return std::any_of(onB.vertices().begin(), onB.vertices().end(),
							   [&](const Vec3& v) { return onA.isInside(moved * v); }) ||
				   std::any_of(onA.vertices().begin(), onA.vertices().end(),
							   [&](const Vec3& v) { return onB.isInside(inverse(moved) * v); });
		};
		for (int k = 0; k < 30; ++k) (overlaps(0.5 * (apart + near)) ? near : apart) = 0.5 * (apart + near);
		pose.translation = (apart + 1e-5) * pose.translation;
		const FacetPair pair(a, b, pose);
		GapSettings settings;
		settings.metric.exact = settings.distance = true;
		GapCache cache;
		GapResult gap;
		signedGap(*a, *b, pose, settings, cache, gap);
		if (gap.minDistance - gap.errorBound <= 0) continue;  // an edge passes an edge
		for (const ContactPoint& point : pair.points())
		{
			++met;
			EXPECT_GE(point.height, -2e-4 * pair.rules.length) << i;
			EXPECT_NEAR(length(point.normal), 1, 1e-9);
			EXPECT_LT(length(point.pointOnA - point.pointOnB - point.height * point.normal), 1e-9);
			EXPECT_LT(std::abs(onA.nearest(point.pointOnA, 10).distance), 2e-3 * pair.rules.length) << i;
			EXPECT_LT(std::abs(onB.nearest(inverse(pose) * point.pointOnB, 10).distance), 2e-3 * pair.rules.length) << i;
		}
	}
	EXPECT_GT(met, 100);
}

// A ball over a box, near its edges and corners: its contact is the nearest point, once, whatever other features of the box are
// hardly farther. (An edge whose arc is not looked at, or a corner whose cone is not, gives a second one, tilted.)
TEST(FacetContacts, ABallTouchesABoxAtItsNearestPointOnly)
{
	const HierarchyPointer box = cubeOf(), center = convexPiece({{{0, 0, 0}}, {}, 0}, 0.3).value();
	Random random(5);
	int regions[4] = {};
	for (int i = 0; i < 600; ++i)
	{
		// About an edge or a corner, within what a resting contact reaches beyond it.
		Vec3 nearest{0.5, 0.5, i % 3 == 0 ? 0.5 : uniform(random, -0.4, 0.4)}, out;
		for (int k = 0; k < 3; ++k)
		{
			if (std::abs(nearest[k]) < 0.5) continue;
			if (uniform(random, 0, 1) < 0.5)
				out[k] = uniform(random, 0.1, 1);
			else
				nearest[k] -= uniform(random, 0.0005, 0.006);
		}
		if (out == Vec3{}) continue;
		const Vec3 normal = normalized(out);
		FacetPair pair(box, center, at(nearest + 0.3001 * normal));
		pair.rules.length = 0.3;
		pair.rules.resting = kRestingShare * 0.3;
		pair.rules.radiusB = pair.rules.margin = 0.3;
		const std::vector<ContactPoint> points = pair.points();
		ASSERT_EQ(points.size(), 1u) << i;
		EXPECT_NEAR(points[0].height, 0.0001, 1e-7) << i;
		EXPECT_LT(length(points[0].normal + normal), 1e-6) << i;
		EXPECT_LT(length(points[0].pointOnA - nearest), 1e-6) << i;
		++regions[(out.x > 0 ? 1 : 0) + (out.y > 0 ? 1 : 0) + (out.z > 0 ? 1 : 0)];
	}
	for (int region = 1; region < 4; ++region) EXPECT_GT(regions[region], 10) << region;
}

TEST(FacetContacts, AHalfSpaceHoldsCornersAtAnyDepth)
{
	const HierarchyPointer box = cubeOf();
	const ContactSurface ground({0, 1, 0}, 0, {}, 1);
	FacetContacts facets;
	FacetMemory memory;
	ClusterSet none, set;
	PointRules rules;
	rules.resting = 1e-3;
	const std::vector<Contact> contacts{{0, 0, 0, 0, {}, {}, {}}};
	const Transform aFromB = at({0, 0.1, 0});  // the ground is 0.6 over the box's lower side
	facets.find(contactBody(*box), contactBody(ground), aFromB, rules,
				contacts, none, memory);
	facets.settle(contacts, false);
	facets.reduce(set);
	int deep = 0;
	for (const ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
			deep += std::abs(cluster.points[std::size_t(i)].point.height + 0.6) < 1e-6 ? 1 : 0;
	EXPECT_GT(deep, 0);
}

// Of all directions, sampled: is one off every facet?
TEST(FacetContacts, ABodyIsHeldBetweenFacetsThatLeaveNoWayOut)
{
	Random random(11);
	const auto direction = [&]
	{ return normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}); };
	std::vector<Vec3> ways;
	for (int i = 0; i < 4000; ++i) ways.push_back(direction());
	FacetQuestion question;
	int held = 0, free = 0;
	for (int i = 0; i < 400; ++i)
	{
		std::vector<Facet> facets(std::size_t(1 + i % 6));
		const Vec3 middle = direction();
		for (Facet& facet : facets)
		{
			facet.kind = Facet::Kind::kVertexFace;
			facet.distance = -1e-3;
			const double share = uniform(random, 0, 1.5);
			facet.normal = normalized(direction() + share * middle);
		}
		double best = -1;  // sine
		for (const Vec3& way : ways)
		{
			double least = 1;
			for (const Facet& facet : facets) least = std::min(least, dot(facet.normal, way));
			best = std::max(best, least);
		}
		Facet far = facets[0];
		far.distance = 1;
		far.normal = -far.normal;
		facets.push_back(far);  // does not touch
		const bool isFree = best > 0.225, isHeld = best < 0.17;  // what was sampled is a little less than the best
		if (isFree || isHeld)
		{
			EXPECT_EQ(isHeldBetween(question, facets), isHeld) << i;
		}
		(isFree ? free : held) += 1;
	}
	EXPECT_GT(held, 40);
	EXPECT_GT(free, 40);
	EXPECT_FALSE(isHeldBetween(question, {}));
}

// A tooth between two flanks that lean: held where they lean by less than 13 degrees, jammed up to 27 where it is pressed in
// on one side at least, and touches on both.
TEST(FacetContacts, WhatIsPressedBetweenFlanksJams)
{
	FacetQuestion question;
	question.rules.length = 1;
	question.rules.margin = 1e-3;
	question.rules.resting = 1e-3;
	for (const double lean : {5.0, 12.0, 14.0, 20.0, 26.0, 28.0, 45.0})
		for (const double height : {-1e-2, -2e-4, 0.5e-3, 1.9e-3, 3e-3})
			for (const bool isOther : {false, true})
			{
				std::vector<Facet> facets(2);
				for (const int side : {0, 1})
				{
					facets[std::size_t(side)].kind = Facet::Kind::kVertexFace;
					facets[std::size_t(side)].distance = side == 1 && isOther ? -0.5e-4 : height;
					const double angle = lean * std::acos(-1.0) / 180;
					facets[std::size_t(side)].normal = {side == 0 ? std::cos(angle) : -std::cos(angle), std::sin(angle), 0};
				}
				const bool isHeld = lean < 13 && height < 2e-3;
				EXPECT_EQ(isHeldBetween(question, facets), isHeld) << lean << " " << height;
				const bool isPressed = height < 0;
				EXPECT_EQ(isJammedBetween(question, facets), isHeld || (lean < 27 && isPressed)) << lean << " " << height;
			}
}

// Corners low over faces that they are not over yet: a joint's flanks, unless the bodies go far to be over them.
TEST(FacetContacts, WhatIsMetOnlyByGoingFarHoldsNothing)
{
	FacetQuestion question;
	question.rules.length = 2;
	question.rules.timeStep = 0.5;
	for (const Facet::Reach reach :
		 {Facet::Reach::kNear, Facet::Reach::kOverlap, Facet::Reach::kPath, Facet::Reach::kPossible})
		for (const double way : {0.0, 0.9, 1.1})
		{
			std::vector<Facet> facets(2);
			for (Facet& facet : facets)
			{
				facet.kind = Facet::Kind::kVertexFace;
				facet.reach = reach;
				facet.distance = -1e-3;
			}
			facets[0].normal = {1, 0, 0};
			facets[1].normal = {-1, 0, 0};
			question.rules.b.linear = {0, way / question.rules.timeStep, 0};
			const bool isHeld = reach <= Facet::Reach::kOverlap || way < 1;
			EXPECT_EQ(isHeldBetween(question, facets), isHeld) << int(reach) << " " << way;
			EXPECT_EQ(isJammedBetween(question, facets), isHeld) << int(reach) << " " << way;
		}
}

// Two cubes, B so high over A, now asked for on the finest level, and on A's second one before.
struct AfterASwitch
{
	HierarchyPointer cube = cubeOf();
	FacetQuestion question;
	std::vector<Contact> contacts = std::vector<Contact>(1);
	SwitchMemory memory;
	LevelSwitch levels;

	explicit AfterASwitch(double height)
	{
		const Transform pose = at({0, height, 0});
		question = {contactBody(*cube), contactBody(*cube), pose, pose, pose, {}};
		question.rules.length = 1;
		question.rules.timeStep = 1.0 / 240;
		contacts[0].nodeA = contacts[0].nodeB = 0;
		memory.asked = {{1, 0}};
	}
	void apply(const std::vector<FacetRecord>& reduced, const ClusterSet& previous, std::vector<Facet>& facets)
	{
		levels.apply(question, contacts, reduced, previous, false, memory, facets);
	}
};

// Its features are a held point's no longer: none of them is looked up as what had gone in through a face.
TEST(LevelSwitch, WhatIsHeldHasGoneInThroughNothing)
{
	AfterASwitch pair(2);
	FacetRecord record{};
	record.kind = Facet::Kind::kVertexFace;
	record.isThrough = true;
	record.levelA = 1;
	ClusterSet previous;
	previous.slots[0].count = 1;
	HeldPoint& old = previous.slots[0].points[0];
	old.impulse = 1;
	old.point.normal = {0, -1, 0};
	old.point.pointOnA = old.point.pointOnB = {0, 1, 0};
	std::vector<Facet> facets;
	pair.apply({record}, previous, facets);
	ASSERT_EQ(facets.size(), 1u);
	EXPECT_EQ(facets[0].kind, Facet::Kind::kHeld);
	EXPECT_FALSE(facets[0].isThrough);
}

// An overlap that came with a level is less by as much in each step, although the bodies stay where they are.
TEST(LevelSwitch, AnOverlapIsLeftThoughBodiesStay)
{
	AfterASwitch pair(0.99);
	const PointRules& rules = pair.question.rules;
	const double depth = 0.01, aStep = switchSpeed(rules) * rules.timeStep;
	ASSERT_GT(aStep, 0);
	double left = depth;
	for (int i = 0; i < 3; ++i)
	{
		Facet facet{};
		facet.kind = Facet::Kind::kFaceVertex;
		facet.normal = {0, -1, 0};
		facet.distance = -depth;
		std::vector<Facet> facets{facet};
		pair.apply({}, {}, facets);
		EXPECT_NEAR(facets[0].slowOverlap, left, 1e-9) << i;
		left -= aStep;
	}
	for (int i = 0; i < 2 * depth / aStep; ++i) pair.memory.passStep(rules);
	EXPECT_EQ(pair.memory.overlap, 0);
}
}  // namespace clod::test
