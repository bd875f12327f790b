// SPDX-License-Identifier: GPL-3.0-or-later
// What the points of manifolds say of where they come from, what they keep when they are written again, and which are
// written ahead of the motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/Manifolds.h"
#include "clod/bullet/SolverTerms.h"
#include "tests/bullet/CubeOnSlab.h"
#include "tests/bullet/ManifoldState.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
// How far a point is outside the real face of this number, of this level; infinite where there is none.
double outside(const Hierarchy& hierarchy, int level, int face, const Vec3& point)
{
	if (level < 0 || std::size_t(level) >= hierarchy.levels().size) return kOff;
	const Level& all = hierarchy.levels()[std::size_t(level)];
	for (std::uint32_t n = all.firstNode; n < all.firstNode + all.nodeCount; ++n)
	{
		const Node& node = hierarchy.node(n);
		if (face < 0 || std::uint32_t(face) - node.firstFace >= node.faceCount) continue;
		const Face& real = hierarchy.faces()[std::size_t(face)];
		const Vec3 normal{double(real.normal[0]), double(real.normal[1]), double(real.normal[2])};
		double farthest = std::abs(dot(normal, point) - double(real.offset));
		for (std::size_t i = 0; i < 3; ++i)
		{
			const Vec3 from = hierarchy.hull(node).vertex(real.vertex[i]),
					   to = hierarchy.hull(node).vertex(real.vertex[(i + 1) % 3]);
			farthest = std::max(farthest, -dot(normalized(cross(normal, to - from)), point - from));
		}
		return farthest;
	}
	return kOff;
}

std::shared_ptr<const Hierarchy> torus()
{
	return body("ring").hierarchy;
}
std::shared_ptr<const Hierarchy> plate()
{
	return body("plate").hierarchy;
}

// A torus lies on a plate, its contacts of coarse levels, those of the plate of the only one there is. It may be a
// child of a compound, and be made first.
struct RingOnPlate : BulletWorld
{
	btClodShape& ringShape = addShape(torus());
	btClodShape& plateShape = addShape(plate());
	btCompoundShape& compound = add(std::make_unique<btCompoundShape>());
	btRigidBody* upper = nullptr;
	btRigidBody* lower = nullptr;

	RingOnPlate(bool isFirst, bool isInCompound)
	{
		context.worldMetric = ContactMetric::deviationShare(10);
		compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, 40, 0)), &plateShape);
		compound.addChildShape(btTransform::getIdentity(), &ringShape);
		btCollisionShape& shape = isInCompound ? static_cast<btCollisionShape&>(compound) : ringShape;
		const Vec3 above{0.1, 0.25 + 0.3 - 0.04, -0.05};
		if (isFirst) upper = &addBody(shape, 1, above);
		lower = &addBody(plateShape, 0, {});
		if (!isFirst) upper = &addBody(shape, 1, above);
		world.getDispatchInfo().m_timeStep = btScalar(timeStep);
		world.performDiscreteCollisionDetection();
	}
	const Hierarchy& hierarchyOf(const btCollisionObject* object) const
	{
		return object == upper ? ringShape.hierarchy() : plateShape.hierarchy();
	}
};
}  // namespace

TEST(WrittenPoints, NameTheFaceAndTheLevelOfEachBodyThatTheyLieOn)
{
	int points = 0, coarse = 0;
	for (const bool isFirst : {true, false})
		for (const bool isInCompound : {false, true})
		{
			RingOnPlate scene(isFirst, isInCompound);
			std::uint32_t ringLevel = 0;
			scene.context.forEachPair(
				[&](const PairReport& pair)
				{
					for (const HeldPoint& held : pair.clusters->points())
						ringLevel = pair.hierarchyA == torus().get() ? pair.hierarchyA->node(held.point.nodeA).level
																	: pair.hierarchyB->node(held.point.nodeB).level;
				});
			for (btPersistentManifold* manifold : manifoldsOf(scene))
				for (int k = 0; k < manifold->getNumContacts(); ++k)
				{
					const btManifoldPoint& point = manifold->getContactPoint(k);
					const bool ringIs0 = manifold->getBody0() == scene.upper;
					const int levelOfRing = ringIs0 ? point.m_partId0 : point.m_partId1;
					const int level0 = isInCompound && ringIs0 ? int(ringLevel) : point.m_partId0;
					const int level1 = isInCompound && !ringIs0 ? int(ringLevel) : point.m_partId1;
					EXPECT_LT(outside(scene.hierarchyOf(manifold->getBody0()), level0, point.m_index0,
									  toVec3(point.m_localPointA)),
							  1e-3);
					EXPECT_LT(outside(scene.hierarchyOf(manifold->getBody1()), level1, point.m_index1,
									  toVec3(point.m_localPointB)),
							  1e-3);
					// Of a compound Bullet wants the child's number there.
					EXPECT_EQ(levelOfRing, isInCompound ? 1 : int(ringLevel));
					++points;
					coarse += levelOfRing > 1;
				}
		}
	EXPECT_GE(points, 3 * 4);
	EXPECT_GE(coarse, 2 * 3);  // not to be taken for the plate's, or for the number of a child
}

TEST(WrittenPoints, OutsideSeesAPlantedFault)
{
	const std::shared_ptr<const Hierarchy> owner = cube();
	const Hierarchy& hierarchy = *owner;
	const Face& face = hierarchy.faces()[0];
	const Node& node = hierarchy.node(0);
	const HullView hull = hierarchy.hull(node);
	const Vec3 middle =
		(1.0 / 3) * (hull.vertex(face.vertex[0]) + hull.vertex(face.vertex[1]) + hull.vertex(face.vertex[2]));
	EXPECT_LT(outside(hierarchy, 0, 0, middle), 1e-6);
	EXPECT_GT(outside(hierarchy, 0, 1, middle), 0.01);
	EXPECT_GT(outside(hierarchy, 0, 0, 1.1 * middle), 0.01);
	EXPECT_EQ(outside(hierarchy, 0, int(hierarchy.faces().size), middle), kOff);
	EXPECT_EQ(outside(hierarchy, 1000, 0, middle), kOff);
}

// Whoever writes a point again hands on all that the solver, and the user, keep in it.
TEST(WrittenPoints, KeepWhatTheSolverRemembersWhenTheyAreWrittenAgain)
{
	CubeOnSlab scene;
	scene.context.keepPoints = false;
	hold(scene.body, true);
	scene.body.getWorldTransform().setOrigin(btVector3(0, btScalar(0.4995), 0));
	scene.step(10);
	const auto points = [&scene]
	{
		std::vector<btManifoldPoint*> all;
		for (btPersistentManifold* manifold : manifoldsOf(scene))
			for (int k = 0; k < manifold->getNumContacts(); ++k) all.push_back(&manifold->getContactPoint(k));
		return all;
	};
	std::vector<btManifoldPoint> before;
	btScalar next = 1;
	for (btManifoldPoint* point : points())
	{
		for (btScalar* value : {&point->m_appliedImpulse, &point->m_prevRHS, &point->m_appliedImpulseLateral1,
								&point->m_appliedImpulseLateral2})
			*value = next++;
		point->m_lifeTime = 100 + int(next++);
		before.push_back(*point);
	}
	ASSERT_GE(before.size(), 4u);
	scene.body.getWorldTransform().getOrigin().setX(btScalar(1e-5));
	scene.world.performDiscreteCollisionDetection();
	EXPECT_EQ(scene.context.lastStep().keptPairs, 0u);
	// Of two points at one place only one goes on as the old one there.
	std::size_t goingOn = 0;
	for (const btManifoldPoint* point : points())
		for (const btManifoldPoint& old : before)
		{
			if (point->m_appliedImpulse != old.m_appliedImpulse) continue;
			EXPECT_LT(double(old.m_localPointA.distance(point->m_localPointA)), 1e-4);
			EXPECT_EQ(point->m_prevRHS, old.m_prevRHS);
			EXPECT_EQ(point->m_appliedImpulseLateral1, old.m_appliedImpulseLateral1);
			EXPECT_EQ(point->m_appliedImpulseLateral2, old.m_appliedImpulseLateral2);
			EXPECT_EQ(point->m_lifeTime, old.m_lifeTime + 1);
			++goingOn;
		}
	EXPECT_GE(goingOn, 4u);
	EXPECT_GE(4 * goingOn, 3 * points().size());
}

// Skins of 0.1, of which bodies near rest close a share a step.
WorldFrame frameOfSkins(double share = 0.15)
{
	WorldFrame frame;
	frame.timeStep = 0.01;
	frame.scale = 1;
	frame.restingGap = 0.1;
	frame.closedShare = share;
	frame.pushSpeed = 1e3;
	frame.isNearRest = true;
	return frame;
}

btManifoldPoint writtenAt(double height, double impulse, const WorldFrame& frame)
{
	ContactPoint point;
	point.height = height;
	point.normal = {0, 1, 0};
	btManifoldPoint written;
	written.m_combinedRestitution = 0;  // Bullet leaves it open
	written.m_appliedImpulse = btScalar(impulse);
	setSolverTerms(point, frame, written);
	return written;
}

// So many points with that normal and an impulse each.
HeldClusters carrying(int count, const Vec3& normal, double impulse)
{
	ClusterSet set;
	set.slots[0].count = count;
	for (int i = 0; i < count; ++i)
	{
		set.slots[0].points[std::size_t(i)].point.normal = normalized(normal);
		set.slots[0].points[std::size_t(i)].impulse = impulse;
	}
	HeldClusters held;
	held.hold(set);
	return held;
}

// Of a gap within two skins a point that carries closes a share a step, and no less than is left unseen; of a wider one all
// that is beyond. Bodies that move do so within one skin.
TEST(WrittenPoints, ThatCarryCloseAShareOfASmallGap)
{
	WorldFrame frame = frameOfSkins();
	const auto rowOf = [&](double gap, double impulse, double unseenSpeed)
	{
		frame.switchSpeed = unseenSpeed;
		return double(writtenAt(gap, impulse, frame).m_distance1);
	};
	EXPECT_NEAR(rowOf(0.16, 0, 0), 0.16, 1e-6);
	EXPECT_NEAR(rowOf(0.16, 1, 0), 0.024, 1e-6);
	EXPECT_NEAR(rowOf(0.16, 1, 6), 0.06, 1e-6);
	EXPECT_NEAR(rowOf(0.16, 1, 60), 0.16, 1e-6);
	EXPECT_NEAR(rowOf(0.5, 1, 0), 0.3 + 0.03, 1e-6);
	frame.isNearRest = false;
	EXPECT_NEAR(rowOf(0.08, 1, 0), 0.012, 1e-6);
	EXPECT_NEAR(rowOf(0.16, 1, 0), 0.06 + 0.015, 1e-6);
}

// Near rest a point that carries speaks for those beside it whose normal is the same.
TEST(WrittenPoints, BesideOnesThatCarryCloseAShareToo)
{
	const auto rowBeside = [&](const Vec3& normal, double impulse, bool isNearRest)
	{
		WorldFrame frame = frameOfSkins();
		const HeldClusters held = carrying(1, normal, impulse);
		frame.points = &held;
		frame.isNearRest = isNearRest;
		return double(writtenAt(0.08, 0, frame).m_distance1);
	};
	EXPECT_NEAR(rowBeside({0, 1, 0}, 1, true), 0.012, 1e-6);
	EXPECT_NEAR(rowBeside({0, 1, 0}, 0, true), 0.08, 1e-6);
	EXPECT_NEAR(rowBeside({0.02, 1, 0}, 1, true), 0.08, 1e-6);
	EXPECT_NEAR(rowBeside({0, 1, 0}, 1, false), 0.08, 1e-6);
}

// On levels that err by more flats leave an overlap of skins by the share of piles, and what is deeper as others do. Edges
// are sharper than skins.
TEST(WrittenPoints, OfFlatsInPilesLeaveAnOverlapOfSkinsSlowly)
{
	const auto left = [&](double depth, int carry, double share, double error = 0.2)
	{
		WorldFrame frame = frameOfSkins(share);
		frame.alike = error;
		const HeldClusters held = carrying(carry, {0, 1, 0}, 1);
		frame.points = &held;
		const btManifoldPoint written = writtenAt(-depth, 1, frame);
		return -double(written.m_distance1) * double(written.m_contactERP);
	};
	const double ofOthers = left(1, 2, 0.02);  // of a unit; more than a fifth, as the step is long
	EXPECT_GT(ofOthers, 0.2);
	EXPECT_NEAR(left(0.04, 3, 0.02), 0.02 * 0.04, 1e-6);
	EXPECT_NEAR(left(0.1, 3, 0.02), 0.02 * 0.1, 1e-6);
	EXPECT_NEAR(left(0.3, 3, 0.02), 0.02 * 0.1 + 0.2 * ofOthers, 1e-6);
	EXPECT_NEAR(left(0.1, 2, 0.02), 0.1 * ofOthers, 1e-6);
	EXPECT_NEAR(left(0.1, 3, 0.15), 0.1 * ofOthers, 1e-6);
	EXPECT_NEAR(left(0.1, 3, 0.02, 0.05), 0.1 * ofOthers, 1e-6);
}

// A corner that two levels have in common is two points at one place, each with what is kept in it.
TEST(WrittenPoints, EqualOnesAreTwo)
{
	static int freed[2];
	CubeOnSlab scene;
	const auto wrapped = [](const btRigidBody& body)
	{ return btCollisionObjectWrapper(nullptr, body.getCollisionShape(), &body, body.getWorldTransform(), -1, -1); };
	const btCollisionObjectWrapper upper = wrapped(scene.body), lower = wrapped(scene.ground);
	WorldFrame frame;
	frame.a = &upper;
	frame.b = &lower;
	frame.breakingThreshold = 0.02;
	ClusterSet corners;
	corners.slots[0].count = 2;
	for (std::size_t i = 0; i < 2; ++i) corners.slots[0].points[i].point.normal = {0, 1, 0};
	HeldClusters held;
	held.hold(corners);
	gContactDestroyedCallback = [](void* data) { return ++*static_cast<int*>(data), true; };
	{
		ManifoldSet manifolds(scene.dispatcher, nullptr);
		btManifoldArray all;
		const auto write = [&]
		{
			btManifoldResult out(&upper, &lower);
			manifolds.write(held, frame, [](const ContactPoint&) { return ManifoldSet::Parts{}; }, out);
			all.resize(0);
			manifolds.append(all);
		};
		write();
		ASSERT_EQ(all[0]->getNumContacts(), 2);
		for (int i = 0; i < 2; ++i)
		{
			all[0]->getContactPoint(i).m_userPersistentData = &freed[i];
			all[0]->getContactPoint(i).m_appliedImpulse = btScalar(1 + i);
		}
		manifolds.readImpulses(held);
		held.linkToThemselves();
		write();
		ASSERT_EQ(all[0]->getNumContacts(), 2);
		for (int i = 0; i < 2; ++i)
		{
			EXPECT_EQ(held.at(0, std::size_t(i)).impulse, 1 + i);
			EXPECT_EQ(all[0]->getContactPoint(i).m_appliedImpulse, btScalar(1 + i));
			EXPECT_EQ(all[0]->getContactPoint(i).m_userPersistentData, &freed[i]);
		}
	}
	gContactDestroyedCallback = nullptr;
	EXPECT_EQ(freed[0], 1);
	EXPECT_EQ(freed[1], 1);
}

// Two bars over each other, a step of turning apart: one of them turns about its middle, which stays where it is.
TEST(WrittenPoints, AreWrittenAheadOfBodiesThatTurn)
{
	for (const bool lowerTurns : {false, true})
		for (const bool onPlane : {false, true})
		{
			if (onPlane && lowerTurns) continue;
			BulletWorld scene;
			scene.timeStep = 1.0 / 60;
			scene.world.setGravity(btVector3(0, 0, 0));
			btClodShape& bar = scene.addShape(patchHierarchy(boxMesh({4, 0.2, 0.2}, {4, 1, 1}, 1)));
			btClodShape& wide = scene.addShape(patchHierarchy(boxMesh({4, 0.2, 0.4}, {4, 1, 1}, 1)));
			btRigidBody& upper = scene.addBody(bar, 1, {0, 0.15, 0});
			auto& plane = scene.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
			btRigidBody& lower = onPlane ? scene.addBody(plane, 0, {}) : scene.addBody(wide, 1, {0, -0.1, 0});
			scene.world.getDispatchInfo().m_timeStep = btScalar(scene.timeStep);
			scene.world.performDiscreteCollisionDetection();
			EXPECT_EQ(scene.contacts(), 0);
			// The ends come by 2 * 3 / 60 = 0.1, and 0.05 are between them.
			for (const double speed : {3.0, -3.0})
			{
				(lowerTurns ? lower : upper).setAngularVelocity(btVector3(0, 0, btScalar(speed)));
				scene.world.performDiscreteCollisionDetection();
				EXPECT_GT(scene.contacts(), 0) << lowerTurns << onPlane << speed;
			}
			(lowerTurns ? lower : upper).setAngularVelocity(btVector3(0, 0, btScalar(1)));
			scene.world.performDiscreteCollisionDetection();
			EXPECT_EQ(scene.contacts(), 0) << lowerTurns << onPlane;
		}
}

// What points are made for is what the solver can do: a body that must not turn about an axis does not.
TEST(WrittenPoints, AreOfBodiesThatTurnAsTheirFactorsAllow)
{
	BulletWorld scene;
	auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.1))));
	btRigidBody& body = scene.addBody(box, 2, {0.4, 0, 0});
	body.getWorldTransform().setRotation(btQuaternion(btVector3(1, 2, 3).normalized(), 1));
	body.updateInertiaTensor();
	const auto turnedBy = [&](const Vec3& torque)
	{ return pairBody(body, Transform(), 1, worldMotion(body, 0), {}).inverseInertia * torque; };
	const Vec3 free = turnedBy({1, 2, 3});
	for (int i = 0; i < 3; ++i)
		EXPECT_EQ(free[i], double(dot(toVec3(body.getInvInertiaTensorWorld()[i]), {1, 2, 3})));
	body.setAngularFactor(btVector3(0, 0, 1));
	const Vec3 held = turnedBy({1, 2, 3});
	EXPECT_EQ(held.x, 0);
	EXPECT_EQ(held.y, 0);
	EXPECT_EQ(held.z, 3 * double(body.getInvInertiaTensorWorld()[2].z()));
}

// A force is held back by a body's linear factor once, as Bullet does when the force is applied.
TEST(WrittenPoints, AreForForcesThatTheSolverWillApply)
{
	for (const double factor : {1.0, 0.5, 0.0, 2.0})
	{
		BulletWorld scene;
		auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(1, 1, 1)));
		btRigidBody& body = scene.addBody(box, 2, {0, 5, 0});
		body.setLinearFactor(btVector3(1, btScalar(factor), 1));
		body.applyGravity();
		const double foreseen = worldMotion(body, scene.timeStep).linear.y;
		body.clearForces();
		scene.step();
		EXPECT_NEAR(foreseen, double(body.getLinearVelocity().y()), 1e-6) << factor;
	}
}

// So is what the turning of a body that is not round does to it.
TEST(WrittenPoints, AreForBodiesThatTumbleAsTheSolverHasThemTumble)
{
	constexpr int kExplicit = BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT, kWorld = BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD,
				  kBody = BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY;
	for (const int flag : {0, kExplicit, kWorld, kBody, kWorld | kBody})
	{
		BulletWorld scene;
		auto& box = scene.add(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.2), btScalar(0.5))));
		btRigidBody& body = scene.addBody(box, 2, {0, 5, 0});
		body.setFlags(flag);
		body.setAngularVelocity(btVector3(3, 12, -7));
		const Vec3 foreseen = worldMotion(body, scene.timeStep).angular;
		scene.step();
		EXPECT_NEAR(length(foreseen - toVec3(body.getAngularVelocity())), 0, 1e-5) << flag;
	}
}
}  // namespace clod::test
