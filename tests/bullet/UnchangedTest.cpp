// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs in which nothing changed since the last dispatch. Their manifolds are left as they are, which must not be told
// from writing them again: two worlds run side by side, in one of which a contact-added callback that does nothing has
// every point added anew in every dispatch.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <stdexcept>

#include "clod/bullet/BodyState.h"
#include "tests/bullet/CubeOnSlab.h"
#include "tests/bullet/ManifoldState.h"

namespace clod::test
{
namespace
{
bool addNothing(btManifoldPoint&, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*, int, int)
{
	return false;
}

// Two cubes on top of each other on a slab, sunk in by a little. Held, they carry loads but do not move.
struct Tower : CubeOnSlab
{
	const Vec3 start = {0.1, 1.4985, -0.05};  // named: in place g++ 12 takes it for dangling
	btRigidBody& top = addBody(bodyShape, 1, start);

	Tower()
	{
		context.keepPoints = false;
		body.getWorldTransform().setOrigin(btVector3(btScalar(0.013), btScalar(0.4995), btScalar(0.027)));
		for (const auto& each : bodies)
			each->setCollisionFlags(each->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
		holdBoth(true);
	}
	void holdBoth(bool now)
	{
		hold(body, now);
		hold(top, now);
	}
	std::uint32_t kept() const { return context.lastStep().keptPairs; }
	btManifoldPoint& firstPoint()
	{
		for (btPersistentManifold* manifold : manifoldsOf(*this))
			if (manifold->getNumContacts() > 0) return manifold->getContactPoint(0);
		throw std::runtime_error("no contact");
	}
	btPersistentManifold& firstManifold()
	{
		for (btPersistentManifold* manifold : manifoldsOf(*this))
			if (manifold->getNumContacts() > 1) return *manifold;
		throw std::runtime_error("no contact");
	}
};

void advance(Tower& scene, bool isDispatchOnly = false)
{
	isDispatchOnly ? scene.world.performDiscreteCollisionDetection() : scene.step();
}
void advanceAnew(Tower& scene, bool isDispatchOnly = false)
{
	const SetCallback<ContactAddedCallback> anew(gContactAddedCallback, addNothing);
	advance(scene, isDispatchOnly);
}
}  // namespace

// Held at first, then set going, then for a while nothing but dispatched, then going on.
TEST(Unchanged, KeptPointsGiveTheTrajectoryOfPointsWrittenAgain)
{
	Tower kept, anew;
	const std::array<Tower*, 2> both{&kept, &anew};
	std::uint32_t quiet = 0;
	for (int i = 0; i < 240; ++i)
	{
		if (i == 40)
			for (Tower* scene : both)
			{
				scene->holdBoth(false);
				scene->top.setLinearVelocity(btVector3(btScalar(1.5), 0, btScalar(0.5)));
				scene->top.setAngularVelocity(btVector3(0, 2, 0));
			}
		const bool isDispatchOnly = i >= 60 && i < 100;
		advance(kept, isDispatchOnly);
		advanceAnew(anew, isDispatchOnly);
		ASSERT_EQ(stateOf(kept), stateOf(anew)) << "step " << i;
		ASSERT_EQ(anew.kept(), 0u);
		if (i < 40 || isDispatchOnly) quiet += kept.kept();
		if (i == 99)
		{
			EXPECT_GT(impulseOf(kept), 0);
		}
	}
	EXPECT_EQ(quiet, 2 * (39u + 39u));  // all but the first of each time
	EXPECT_GT(double((kept.top.getWorldTransform().getOrigin() - btVector3(0, 1, 0)).length()), 0.2);  // it did slide
}

namespace
{
struct Change
{
	const char* name;
	bool asksAnew;  // every pair, of the query
	std::function<void(Tower&)> make;
};

std::vector<Change> changesOfQuestions(btClodShape& otherShape)
{
	const btVector3 aside(btScalar(0.0625), 0, 0);
	return {{"the world's metric", true, [](Tower& s) { s.context.worldMetric = ContactMetric::exactly(); }},
			{"a shape's metric", true, [](Tower& s) { s.groundShape.setMetric(ContactMetric::deviationShare(0.1)); }},
			{"a pair's metric", true,
			 [](Tower& s)
			 {
				 s.context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
				 {
					 metric = ContactMetric::deviationShare(0.2);
					 return true;
				 };
			 }},
			{"a margin", true, [](Tower& s) { s.bodyShape.setMargin(btScalar(0.004)); }},
			{"a scale set again", true, [](Tower& s) { s.bodyShape.setLocalScaling(btVector3(1, 1, 1)); }},
			{"the length of a step", true, [](Tower& s) { s.timeStep = 1.0 / 120; }},
			{"a pose", false, [aside](Tower& s) { s.top.getWorldTransform().getOrigin() += aside; }},
			{"all poses, by half a turn", false,
			 [](Tower& s)
			 {
				 const btTransform turn(btQuaternion(1, 0, 0, 0));
				 for (const auto& each : s.bodies) each->setWorldTransform(turn * each->getWorldTransform());
			 }},
			{"a shape", false, [&otherShape](Tower& s) { s.top.setCollisionShape(&otherShape); }}};
}

std::vector<Change> changesOfMaterials()
{
	return {{"friction", false, [](Tower& s) { s.body.setFriction(btScalar(0.1)); }},
			{"rolling friction", false, [](Tower& s) { s.body.setRollingFriction(btScalar(0.2)); }},
			{"spinning friction", false, [](Tower& s) { s.body.setSpinningFriction(btScalar(0.3)); }},
			{"restitution", false,
			 [](Tower& s)
			 {
				 for (const auto& each : s.bodies) each->setRestitution(btScalar(0.5));
			 }},
			{"stiffness", false, [](Tower& s) { s.body.setContactStiffnessAndDamping(btScalar(1000), btScalar(10)); }},
			{"no stiffness", false, [](Tower& s) {
				 s.body.setCollisionFlags(s.body.getCollisionFlags() &
										  ~btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING);
			 }}};
}

std::vector<Change> changesOfManifolds()
{
	return {
		{"a manifold cleared", false, [](Tower& s) { s.firstManifold().clearManifold(); }},
		{"a point removed", false, [](Tower& s) { s.firstManifold().removeContactPoint(0); }},
		{"a normal", false, [](Tower& s) { s.firstPoint().m_normalWorldOnB = btVector3(1, 0, 0); }},
		{"a point moved", false, [](Tower& s) { s.firstPoint().m_localPointB += btVector3(0, btScalar(1e-5), 0); }},
		{"a point's friction", false, [](Tower& s) { s.firstPoint().m_combinedFriction = 7; }},
		{"a point's motion", false, [](Tower& s) { s.firstPoint().m_contactMotion1 = 7; }},
		{"a point's own softness", false,
		 [](Tower& s)
		 {
			 s.firstPoint().m_contactCFM = btScalar(0.5);
			 s.firstPoint().m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_CFM;
		 }},
		{"a breaking threshold", false, [](Tower& s) { s.firstManifold().setContactBreakingThreshold(btScalar(0.3)); }},
		{"an impulse", false, [](Tower& s) { s.firstPoint().m_appliedImpulse = 7; }},
		{"user data", false, [](Tower& s) { s.firstPoint().m_userPersistentData = &s; }},
		{"nothing", false, [](Tower&) {}}};
}
}  // namespace

TEST(Unchanged, EveryChangeTakesEffectAtOnce)
{
	Tower kept, anew;
	const std::array<Tower*, 2> both{&kept, &anew};
	std::vector<Change> changes = changesOfQuestions(kept.addShape(cube()));
	for (const std::vector<Change>& more : {changesOfMaterials(), changesOfManifolds()})
		changes.insert(changes.end(), more.begin(), more.end());
	// Overlap is answered by impulses, which held bodies do not follow.
	for (Tower* scene : both) scene->world.getSolverInfo().m_splitImpulse = false;
	for (int i = 0; i < 2; ++i)
	{
		advance(kept);
		advanceAnew(anew);
	}
	for (const Change& change : changes)
	{
		change.make(kept);
		change.make(anew);
		for (int again = 0; again < 3; ++again)
		{
			// Another question, with the same points for an answer.
			if (change.asksAnew && again == 0) anew.context.searchGap = !anew.context.searchGap;
			advance(kept);
			advanceAnew(anew);
			ASSERT_EQ(stateOf(kept), stateOf(anew)) << change.name << ", dispatch " << again;
		}
		// At last nothing changes any more; what stiffness says is said to every point as it is added.
		EXPECT_EQ(kept.kept(), std::string(change.name) == "stiffness" ? 0u : 2u) << change.name;
		EXPECT_GT(impulseOf(kept), 0) << change.name;
	}
}

namespace
{
std::vector<double> pointsOf(BulletWorld& scene)
{
	std::vector<double> values;
	for (btPersistentManifold* manifold : manifoldsOf(scene))
		for (int k = 0; k < manifold->getNumContacts(); ++k)
		{
			const btManifoldPoint& p = manifold->getContactPoint(k);
			for (const btVector3& v : {p.m_localPointA, p.m_localPointB, p.m_positionWorldOnB, p.m_normalWorldOnB})
				values.insert(values.end(), {double(v.x()), double(v.y()), double(v.z())});
			values.insert(values.end(), {double(p.m_distance1), double(p.m_combinedFriction)});
		}
	return values;
}

double queryTime(const BulletWorld& scene)
{
	double time = 0;
	scene.context.forEachPair([&](const PairReport& report) { time = report.queryMicroseconds; });
	return time;
}
}  // namespace

TEST(Unchanged, APairIsAskedAnewOnlyWhenItsQuestionChanges)
{
	CubeOnSlab scene;
	scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
	btClodShape& otherShape = scene.addShape(cube());
	const std::pair<const char*, std::function<void()>> changes[] = {
		{"moved", [&] { scene.body.getWorldTransform().getOrigin().setX(btScalar(0.0625)); }},
		{"speed", [&] { scene.body.setLinearVelocity(btVector3(0, 0, btScalar(0.3))); }},
		{"force", [&] { scene.body.applyCentralForce(btVector3(0, 0, btScalar(5))); }},
		{"friction", [&] { scene.body.setFriction(btScalar(0.2)); }},
		{"margin", [&] { scene.bodyShape.setMargin(btScalar(0.004)); }},
		{"metric", [&] { scene.context.worldMetric = ContactMetric::exactly(); }},
		{"shape", [&] { scene.body.setCollisionShape(&otherShape); }},
		{"both moved by as much", [&]
		 {
			 for (btRigidBody* body : {&scene.ground, &scene.body})
				 body->getWorldTransform().getOrigin() += btVector3(btScalar(0.0625), 0, 0);
		 }}};
	scene.world.performDiscreteCollisionDetection();
	for (const auto& [name, change] : changes)
	{
		change();
		scene.world.performDiscreteCollisionDetection();
		EXPECT_EQ(queryTime(scene) == 0, std::string("both moved by as much") == name) << name;
		const std::vector<double> points = pointsOf(scene);
		ASSERT_FALSE(points.empty()) << name;
		for (int again = 0; again < 3; ++again)
		{
			scene.world.performDiscreteCollisionDetection();
			EXPECT_EQ(queryTime(scene), 0) << name;
			EXPECT_EQ(pointsOf(scene), points) << name;
		}
	}
	// Impulses stay with their points.
	const auto point = [&](int k) -> btManifoldPoint&
	{ return scene.dispatcher.getManifoldByIndexInternal(k / 4)->getContactPoint(k % 4); };
	for (int k = 0; k < 2; ++k) point(k).m_appliedImpulse = btScalar(3 + k);
	scene.world.performDiscreteCollisionDetection();
	for (int k = 0; k < 2; ++k) EXPECT_EQ(point(k).m_appliedImpulse, btScalar(3 + k));
	// What is Bullet's stays Bullet's: a point's friction is that of now.
	const std::vector<double> rough = pointsOf(scene);
	scene.body.setFriction(btScalar(0.1));
	scene.world.performDiscreteCollisionDetection();
	EXPECT_NE(pointsOf(scene), rough);
}

// A body over a plane is not looked at before it can meet it: it falls, is hit and spins as where it is (a plane that might move).
TEST(Unchanged, WhatStaysOverAPlaneIsNotLookedAt)
{
	for (const bool meetsImpacts : {false, true})
		for (const auto& [speed, height] : {std::pair{0.0, 6.0}, {5.0, 6.0}, {60.0, 6.0}, {60.0, 2.2}})
		{
			std::vector<Vec3> ways[2];
			std::vector<int> passes[2];
			int looks[2] = {0, 0};
			for (const bool mayMove : {false, true})
			{
				BulletWorld scene(meetsImpacts);
				scene.timeStep = 1.0 / 60;
				if (meetsImpacts) static_cast<btClodDynamicsWorld&>(scene.world).setMostParts(1);
				scene.context.pairMetric = [&](const btCollisionObject& a, const btCollisionObject& b, ContactMetric&)
				{
					looks[mayMove] += a.isStaticOrKinematicObject() || b.isStaticOrKinematicObject();
					return false;
				};
				btRigidBody& ground =
					scene.addBody(scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0.5))), 0, {});
				if (mayMove) ground.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
				btClodShape& shape = scene.addShape(cube());
				shape.setLocalScaling(btVector3(1, 2, 1));
				btRigidBody& lower = scene.addBody(shape, 1, {0, height, 0});
				btRigidBody& upper = scene.addBody(shape, 5, {0.2, height + 4, 0.1});
				// What moves nothing may sleep on what cannot move only.
				for (btRigidBody* body : {&lower, &upper}) body->setActivationState(DISABLE_DEACTIVATION);
				upper.setLinearVelocity(btVector3(0, btScalar(-speed), 0));
				upper.setAngularVelocity(btVector3(1, 0, btScalar(0.3 * speed)));
				for (int i = 0; i < 150; ++i)
				{
					scene.step();
					for (const btRigidBody* body : {&lower, &upper})
						ways[mayMove].push_back(toVec3(body->getWorldTransform().getOrigin()));
					passes[mayMove].push_back(meetsImpacts ? static_cast<btClodDynamicsWorld&>(scene.world).passes() : 1);
				}
			}
			// To the bit until what was looked at has a further pass, which agrees far within a skin (6e-4).
			const auto first = std::mismatch(passes[0].begin(), passes[0].end(), passes[1].begin()).first;
			const std::size_t same = 2 * std::size_t(first - passes[0].begin());
			for (std::size_t i = 0; i < ways[0].size(); ++i)
				EXPECT_LE(length(ways[0][i] - ways[1][i]), i < same ? 0 : 1e-5) << speed << " " << meetsImpacts << " " << i;
			EXPECT_LE(looks[0], looks[1] - (speed < 50 ? 20 : 0)) << speed << " " << meetsImpacts;  // fast bodies always are
			EXPECT_GT(looks[0], 40);
		}
}
}  // namespace clod::test
