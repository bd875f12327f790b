// SPDX-License-Identifier: GPL-3.0-or-later
// What a pair reports of its answer, reckoned once more from its contacts: levels, certified error, and when that is
// too loose for a wall.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include <LinearMath/btIDebugDraw.h>

#include "clod/manifold/PartnerContacts.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
std::shared_ptr<const Hierarchy> ring()
{
	return body("ring").hierarchy;
}
constexpr double kPlate = 0.5, kThinPlate = 0.01;  // thick

// A torus that lies on something whose top is at height 0, or a hair above it.
struct Lying : BulletWorld
{
	btRigidBody& body = addBody(addShape(ring()), 1, {0.1, 0.3, -0.05});

	explicit Lying(btCollisionShape* ground, double thickness)
	{
		addBody(*ground, 0, {0, -0.5 * thickness, 0});
		world.getDispatchInfo().m_timeStep = btScalar(timeStep);
	}
	PairReport with(const ContactMetric& metric)
	{
		context.worldMetric = metric;
		world.performDiscreteCollisionDetection();
		PairReport report;
		context.forEachPair([&](const PairReport& pair) { report = pair; });
		return report;
	}
};

struct Drawn : btIDebugDraw
{
	struct Line
	{
		btVector3 from, to, color;
	};
	std::vector<Line> lines;
	void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override
	{
		lines.push_back({from, to, color});
	}
	void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
	void reportErrorWarning(const char*) override {}
	void draw3dText(const btVector3&, const char*) override {}
	void setDebugMode(int) override {}
	int getDebugMode() const override { return 0; }
};

// Is that line an edge of a level's hulls, in that level's colour?
bool isEdgeOf(const Hierarchy& hierarchy, double scale, const btTransform& worldFromBody, const Drawn::Line& line)
{
	const auto isAt = [&](const Vec3& vertex, const btVector3& end)
	{
		const btVector3 place(btScalar(scale * vertex.x), btScalar(scale * vertex.y), btScalar(scale * vertex.z));
		return (worldFromBody * place).distance(end) < btScalar(1e-5);
	};
	for (const Node& node : hierarchy.nodes())
	{
		const HullView hull = hierarchy.hull(node);
		bool hasFrom = false, hasTo = false;
		for (std::uint32_t v = 0; v < hull.count; ++v)
		{
			hasFrom = hasFrom || isAt(hull.vertex(v), line.from);
			hasTo = hasTo || isAt(hull.vertex(v), line.to);
		}
		if (hasFrom && hasTo && colorOf(node.level, hierarchy) == line.color) return true;
	}
	return false;
}

struct ByHand
{
	std::uint32_t finest = kNone, coarsest = 0;
	double error = 0;
};
ByHand byHand(const PairReport& pair)
{
	ByHand sums;
	for (const AcceptedPair& contact : pair.result->pairs)
	{
		const Node &a = pair.hierarchyA->node(contact.nodeA), &b = pair.hierarchyB->node(contact.nodeB);
		sums.finest = std::min({sums.finest, a.level, b.level});
		sums.coarsest = std::max({sums.coarsest, a.level, b.level});
		sums.error = std::max({sums.error, double(a.cover) + double(b.cover), double(a.protrude) + double(b.protrude)});
	}
	return sums;
}
}  // namespace

TEST(PairReport, LevelsAndErrorAreThoseOfTheContacts)
{
	btClodShape ground(body("plate").hierarchy);
	Lying scene(&ground, kPlate);
	int mixed = 0;
	for (const double share : {0.0, 0.01, 0.5, 1.0, 3.0, 10.0})
	{
		const PairReport report = scene.with(ContactMetric::deviationShare(share));
		ASSERT_FALSE(report.result->pairs.empty());
		const ByHand expected = byHand(report);
		EXPECT_EQ(report.finestLevel, expected.finest) << share;
		EXPECT_EQ(report.coarsestLevel, expected.coarsest) << share;
		EXPECT_DOUBLE_EQ(report.contactError, expected.error) << share;
		mixed += expected.finest < expected.coarsest;
	}
	EXPECT_GT(mixed, 2);
}

// The ground is a compound's child, and a torus as large as it is asked in its own unit.
TEST(PairReport, LevelsAreDrawnWhereTheBodiesAre)
{
	const auto plate = body("plate").hierarchy;
	btClodShape child(plate);
	child.setLocalScaling({2, 2, 2});
	btCompoundShape ground;
	const btTransform groundFromChild(btQuaternion(btVector3(0, 1, 0), btScalar(0.7)), btVector3(btScalar(0.3), 0, 0));
	ground.addChildShape(groundFromChild, &child);
	for (const double share : {0.0, 3.0})
		for (const double scale : {1.0, 2.0})
		{
			Lying scene(&ground, 2 * kPlate);
			scene.body.getCollisionShape()->setLocalScaling(btVector3(1, 1, 1) * btScalar(scale));
			scene.body.getWorldTransform().getOrigin() *= btScalar(scale);
			const PairReport report = scene.with(ContactMetric::deviationShare(share));
			const btTransform worldFromChild = scene.bodies[1]->getWorldTransform() * groundFromChild;
			Drawn drawn;
			drawLevels(report, drawn);
			int ofTorus = 0, ofGround = 0;
			bool isFine = true;
			for (const Drawn::Line& line : drawn.lines)
			{
				const bool isTorus = isEdgeOf(*ring(), scale, scene.body.getWorldTransform(), line);
				const bool isGround = isEdgeOf(*plate, 2, worldFromChild, line);
				EXPECT_TRUE(isTorus || isGround);
				ofTorus += isTorus;
				ofGround += isGround;
				isFine = isFine && line.color == colorOf(0, *ring());
			}
			EXPECT_GT(ofTorus, 3);
			EXPECT_GT(ofGround, 3);
			EXPECT_EQ(isFine, share == 0);
		}
	Drawn nothing;
	drawLevels(PairReport(), nothing);
	EXPECT_TRUE(nothing.lines.empty());
}

// Against a plane only the torus has levels: those of the points' nodes are between the two reported.
TEST(PairReport, LevelsAgainstAPlaneAreThoseOfThePoints)
{
	btStaticPlaneShape ground(btVector3(0, 1, 0), 0);
	Lying scene(&ground, 0);
	std::uint32_t coarsest = 0;
	for (const double share : {0.0, 0.01, 0.1, 1.0})
	{
		const PairReport report = scene.with(ContactMetric::deviationShare(share));
		ASSERT_GT(report.points, 0u);
		EXPECT_GT(report.result->stats.boxTests, 0u);
		EXPECT_LE(report.finestLevel, report.coarsestLevel);
		for (const HeldPoint& held : report.clusters->points())
		{
			const std::uint32_t level = report.hierarchyA->node(held.point.nodeA).level;
			EXPECT_GE(level, report.finestLevel);
			EXPECT_LE(level, report.coarsestLevel);
		}
		coarsest = std::max(coarsest, report.coarsestLevel);
	}
	EXPECT_GT(coarsest, 1u);
}

// A plane has no error: what is certified is what the torus lacks, or has too much of, whichever is more.
TEST(PairReport, TheErrorAgainstAPlaneIsThatOfTheNodesThatAnswer)
{
	int byProtrusion = 0;
	for (const char* name : {"ring", "cup-3000", "spoon-3000", "plate"})
	{
		const Hierarchy& hierarchy = *body(name).hierarchy;
		const OrientedBox& box = hierarchy.cullBox(hierarchy.root());
		for (const double share : {0.0, 0.03, 0.3, 3.0})
			for (const Vec3& normal : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{0, -1, 0}})
			{
				Metric metric;
				metric.weightedDeviation = share * double(hierarchy.asset().radius);
				PartnerContacts partner;
				PartnerStats stats;
				std::vector<Contact> contacts;
				partner.withHalfSpace(hierarchy, normal, dot(normal, toVec3(box.center)), metric, 0, contacts, stats);
				ASSERT_FALSE(contacts.empty());
				double cover = 0, protrude = 0;
				for (const Contact& contact : contacts)
				{
					cover = std::max(cover, double(hierarchy.node(contact.nodeA).cover));
					protrude = std::max(protrude, double(hierarchy.node(contact.nodeA).protrude));
				}
				EXPECT_EQ(stats.errorBound, std::max(cover, protrude)) << name << " " << share;
				byProtrusion += protrude > cover;
			}
	}
	EXPECT_GT(byProtrusion, 0);
}

// Above a triangle, in it, beneath it and beside it: what is neither in it nor beneath it, as far as is asked, is known
// to be apart, by no more than it is.
TEST(PairReport, TrianglesApartFromAHullAreKnownToBe)
{
	const Hierarchy& hierarchy = *body("sphere-300").hierarchy;
	const double radius = double(hierarchy.asset().radius), far = 0.5 * radius;
	const auto upperOf = [&](const Vec3& place, double side)
	{
		PartnerContacts partner;
		PartnerStats stats;
		std::vector<Contact> contacts;
		Triangle triangle{Vec3{-far, 0, -far}, Vec3{far, 0, far}, Vec3{far, 0, -far}};
		for (Vec3& corner : triangle) corner += place;
		NearTriangles near;
		near.add(triangle);
		partner.withTriangles(hierarchy, near, {}, [&](const Vec3&, double) { return side; }, 3 * radius, {}, radius, contacts, stats);
		double least = 1e9;
		for (const Contact& contact : contacts) least = std::min(least, contact.upper);
		EXPECT_FALSE(contacts.empty());
		return least;
	};
	const double above = 1;
	EXPECT_GT(upperOf({0, -1.2 * radius, 0}, above), 0.15 * radius);
	EXPECT_LE(upperOf({0, -1.2 * radius, 0}, above), 0.25 * radius);
	EXPECT_EQ(upperOf({0, -0.9 * radius, 0}, above), 0);
	EXPECT_EQ(upperOf({0, 1.2 * radius, 0}, above), 0);
	EXPECT_EQ(upperOf({0, -1.2 * radius, 0}, -above), 0);
	EXPECT_GT(upperOf({1.6 * radius, 0, 0}, above), 0.05 * radius);
}

// Where boxes meet, but no hull is within the tolerance.
TEST(PairReport, TrianglesBeyondTheToleranceMeetNothing)
{
	const Hierarchy& hierarchy = *body("sphere-300").hierarchy;
	const double radius = double(hierarchy.asset().radius), tolerance = 0.02 * radius;
	Metric exact;
	exact.exact = true;
	Random random(3);
	int apart = 0, near = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 place = uniform(random, 0.9, 1.1) * radius * randomDirection(random);
		const Vec3 out = normalized(place), along = 0.3 * radius * normalized(cross(out, randomDirection(random)));
		const Triangle triangle{place, place + 0.3 * radius * out + along, place + 0.3 * radius * out - along};
		NearTriangles triangles;
		triangles.add(triangle);
		PartnerContacts partner;
		PartnerStats stats;
		std::vector<Contact> contacts;
		partner.withTriangles(hierarchy, triangles, {}, [](const Vec3&, double) { return 1; }, 0, exact, tolerance, contacts, stats);
		const bool isBeyond = length(place) > 1.01 * (radius + tolerance);
		EXPECT_TRUE(contacts.empty() || !isBeyond) << i;
		apart += isBeyond && stats.boxTests > 1;
		near += !contacts.empty();
	}
	EXPECT_GT(apart, 100);
	EXPECT_GT(near, 100);
}

// Coarse contacts are off by more than the thinner wall: said in the report, in the step's sums, and once aloud.
TEST(PairReport, ContactsTooLooseForAWallAreSaid)
{
	for (const bool isThin : {true, false})
	{
		const double thickness = isThin ? kThinPlate : kPlate;
		btClodShape ground(body(isThin ? "plate-thin" : "plate").hierarchy);
		Lying scene(&ground, thickness);
		for (int again = 0; again < 2; ++again)
		{
			const PairReport fine = scene.with(ContactMetric::exactly());
			EXPECT_FALSE(fine.loose);
			EXPECT_EQ(scene.context.lastStep().loosePairs, 0u);
			const PairReport coarse = scene.with(ContactMetric::deviationShare(10));
			const double wall = std::min(double(coarse.hierarchyA->asset().thinnestWall),
										 double(coarse.hierarchyB->asset().thinnestWall));
			ASSERT_GT(wall, 0);
			ASSERT_EQ(coarse.contactError > wall, isThin) << coarse.contactError << " " << wall;
			EXPECT_EQ(coarse.loose, isThin);
			const StepReport sums = scene.context.lastStep();
			EXPECT_EQ(sums.loosePairs, isThin ? 1u : 0u);
			const auto says = [](const std::vector<std::string>& messages)
			{
				return std::count_if(messages.begin(), messages.end(), [](const std::string& message)
									 { return message.find("error bound") != std::string::npos; });
			};
			EXPECT_EQ(says(sums.warnings()), isThin ? 1 : 0);
			EXPECT_EQ(says(scene.warnings), isThin ? 1 : 0);
		}
	}
}

// Of a body that goes its own radius in a step, all of a near one may be aside of the way: it is looked for only where
// little is on the way itself.
TEST(PairReport, WhatIsAsideOfALongWayIsLookedForWhereLittleIsOnIt)
{
	for (const bool meets : {true, false})
	{
		BulletWorld scene;
		btClodShape& shape = scene.addShape(ring());
		const double radius = double(ring()->asset().radius), beside = 1.5 * radius;
		scene.addBody(shape, 0, {0, 0, 0});
		btRigidBody& body =
			scene.addBody(shape, 1, meets ? Vec3{0.3 * radius, 0.2 * radius, 0} : Vec3{beside, 0, beside});
		const btVector3 speed(0, btScalar((meets ? -1 : 1) * radius / scene.timeStep), 0);
		body.setLinearVelocity(speed);
		body.setInterpolationLinearVelocity(speed);
		scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
		scene.context.worldMetric = ContactMetric::exactly();
		scene.world.performDiscreteCollisionDetection();
		PairReport report;
		scene.context.forEachPair([&](const PairReport& pair) { report = pair; });
		ASSERT_NE(report.result, nullptr);
		EXPECT_FALSE(report.result->pairs.empty());
		EXPECT_EQ(report.tolerance < 0.2 * radius, meets);
	}
}

// What bodies apart pass on a long way leads to all sides, but holds them nowhere yet, as it does where they are in
// each other.
TEST(PairReport, BodiesApartThatRunIntoEachOtherAskForNoFinerLevels)
{
	const double radius = double(ring()->asset().radius);
	for (const double apart : {0.0, 0.8})
	{
		BulletWorld scene;
		btClodShape& shape = scene.addShape(ring());
		scene.addBody(shape, 0, {0, 0, 0});
		btRigidBody& body = scene.addBody(shape, 1, radius * Vec3{0.3, apart, 0.2});
		const btVector3 speed(0, btScalar(-1.5 * radius / scene.timeStep), 0);
		body.setLinearVelocity(speed);
		body.setInterpolationLinearVelocity(speed);
		body.predictIntegratedTransform(btScalar(scene.timeStep), body.getInterpolationWorldTransform());
		scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
		ContactMetric metric;
		metric.maxError = 0.1 * radius;
		shape.setMetric(metric);
		scene.world.performDiscreteCollisionDetection();
		PairReport report;
		scene.context.forEachPair([&](const PairReport& pair) { report = pair; });
		ASSERT_NE(report.result, nullptr);
		EXPECT_FALSE(report.result->pairs.empty());
		EXPECT_EQ(report.metric.maxError < metric.maxError, apart == 0) << apart;
	}
}
}  // namespace clod::test
