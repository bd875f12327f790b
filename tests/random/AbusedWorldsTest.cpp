// SPDX-License-Identifier: GPL-3.0-or-later
// Programs that do to their worlds what nobody would: between steps everything that a program may change changes, drawn
// from a seed, in two worlds that share shapes and maybe a context. Nothing crashes (nightly under sanitizers), every number
// stays finite, no manifold, pair or user's data of a point is left over, and the same seed gives the same bits.
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/bullet/NumberHash.h"
#include "tests/query/Questions.h"
#include "tests/random/AbusedWorld.h"
#include "tests/random/RandomShapes.h"

namespace clod::test
{
namespace
{
constexpr double kFar = 30;      // what went farther comes back, or boxes of trees become as large as the world
constexpr double kFastest = 300;

class AbusedWorlds
{
public:
	explicit AbusedWorlds(std::uint64_t seed) : m_draw(seed), m_one(m_draw, nullptr)
	{
		m_two = std::make_unique<AbusedWorld>(m_draw, m_draw.pick(2) ? &m_one.context : nullptr);
		g_points = {};
		gContactAddedCallback = m_draw.pick(2) ? pointAdded : nullptr;
		gContactDestroyedCallback = pointDestroyed;
		m_one.world->setDebugDrawer(&m_drawing);
		addGround();
		for (std::size_t count = 3 + m_draw.pick(5); count > 0; --count) addBody(1.5 + 0.6 * double(count));
		m_shared = std::make_unique<btRigidBody>(1, nullptr, m_ours[0], btVector3(1, 1, 1));
		m_sharedGround = std::make_unique<btRigidBody>(0, nullptr, m_bodies[0].body->getCollisionShape());
		m_shared->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 1, 0)));
		m_two->world->addRigidBody(m_shared.get());
		m_two->world->addRigidBody(m_sharedGround.get());
	}
	~AbusedWorlds()
	{
		gContactAddedCallback = nullptr;
		gContactDestroyedCallback = nullptr;
	}
	// Empty, or what went wrong first; the bits of all places.
	std::string run(int steps, std::uint64_t& hash)
	{
		for (int step = 0; step < steps; ++step)
		{
			for (std::size_t count = m_draw.pick(4); count > 0; --count) abuse();
			move();
			const std::size_t kind = m_draw.pick(6);
			if (kind == 0)
			{
				const double time = m_draw.between(0, 0.05);
				m_one.world->stepSimulation(btScalar(time), int(m_draw.pick(4)));
			}
			else
				m_one.world->stepSimulation(btScalar(kind == 1 && m_draw.oneOf(4) ? 0 : 1.0 / 60), 0);
			m_two->world->stepSimulation(btScalar(1.0 / 60), 0);
			if (!look(hash)) m_wrong = "not finite";
			if (!m_wrong.empty()) return m_wrong + " in step " + std::to_string(step);
		}
		return end();
	}

private:
	struct Member
	{
		std::unique_ptr<btRigidBody> body;
		double mass;
		bool isCompound;
	};

	// A shape of ours, of Bullet's or of both.
	btCollisionShape& anyShape(bool& isCompound)
	{
		const double radius = m_draw.between(0.2, 0.7);
		const std::size_t kind = m_draw.pick(8);
		isCompound = kind == 0;
		if (kind == 0)
		{
			btCompoundShape& whole = m_draw.compound(radius);
			for (int child = 0; child < whole.getNumChildShapes(); ++child)
				m_ours.push_back(static_cast<btClodShape*>(whole.getChildShape(child)));
			m_compounds.push_back(&whole);
			return whole;
		}
		if (kind == 1) return m_draw.bullets(radius);
		if (kind == 2)
		{
			auto& hull = m_draw.add(std::make_unique<btConvexHullShape>());
			for (int i = 0; i < 10; ++i) hull.addPoint(m_draw.vector(radius));
			m_hulls.push_back(&hull);
			return hull;
		}
		m_ours.push_back(&m_draw.ours(radius));
		return *m_ours.back();
	}
	void add(btCollisionShape& shape, double mass, const btTransform& pose, bool isCompound)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
		info.m_startWorldTransform = pose;
		info.m_friction = btScalar(m_draw.between(0, 1));
		info.m_restitution = btScalar(m_draw.oneOf(3) ? m_draw.between(0, 1) : 0);
		auto body = std::make_unique<btRigidBody>(info);
		const auto set = [&body](int flag) { body->setCollisionFlags(body->getCollisionFlags() | flag); };
		if (m_draw.oneOf(3)) set(btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
		if (m_draw.oneOf(8)) body->setContactStiffnessAndDamping(btScalar(1e4), btScalar(m_draw.between(0, 100)));
		if (m_draw.oneOf(10)) set(btCollisionObject::CF_HAS_FRICTION_ANCHOR);
		m_one.world->addRigidBody(body.get());
		m_bodies.push_back({std::move(body), mass, isCompound});
	}
	void addGround()
	{
		const btTransform low(btQuaternion::getIdentity(), btVector3(0, -1, 0));
		switch (m_draw.pick(4))
		{
			case 0: add(m_draw.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 1)), 0, low, false); break;
			case 1: add(m_draw.add(std::make_unique<btBoxShape>(btVector3(10, 1, 10))), 0, low, false); break;
			case 2: add(m_draw.slab(10, 1), 0, low, false); break;
			default:
				m_mesh.addTriangle(btVector3(-12, 1, -12), btVector3(-12, 1, 12), btVector3(12, 1, -12));
				m_mesh.addTriangle(btVector3(12, 1, -12), btVector3(-12, 1, 12), btVector3(12, 1, 12));
				add(m_draw.add(std::make_unique<btBvhTriangleMeshShape>(&m_mesh, true)), 0, low, false);
		}
	}
	btTransform placeAt(double height)
	{
		btTransform pose(m_draw.turn());
		pose.setOrigin(m_draw.vector(1) + btVector3(0, btScalar(height), 0));
		return pose;
	}
	void addBody(double height)
	{
		bool isCompound = false;
		btCollisionShape& shape = m_bodies.size() == 1 ? firstOfOurs() : anyShape(isCompound);
		const double mass = m_draw.oneOf(7) ? 0 : m_draw.between(0.3, 3);
		add(shape, mass, placeAt(height), isCompound);
	}
	btClodShape& firstOfOurs()
	{
		m_ours.push_back(&m_draw.ours(0.5));
		return *m_ours.back();
	}
	Member& anyMember() { return m_bodies[1 + m_draw.pick(m_bodies.size() - 1)]; }
	btClodShape& anyOfOurs() { return *m_ours[m_draw.pick(m_ours.size())]; }
	ContactMetric anyMetric()
	{
		switch (m_draw.pick(6))
		{
			case 0: return ContactMetric::exactly();
			case 1: return ContactMetric::velocityFactor(0.1);
			case 2: return ContactMetric::deviationShare(m_draw.between(0, 0.1));
			case 3: return ContactMetric::viewError(m_draw.between(0.5, 5));  // without a camera
			case 4: return ContactMetric::errorShare(-1);
			default: return ContactMetric::errorShare(std::pow(10, m_draw.between(-4, 0)));
		}
	}
	void setMass(Member& member, double mass, bool isKinematic)
	{
		btVector3 inertia(0, 0, 0);
		btRigidBody& body = *member.body;
		if (mass > 0) body.getCollisionShape()->calculateLocalInertia(btScalar(mass), inertia);
		body.setMassProps(btScalar(mass), inertia);
		body.updateInertiaTensor();
		member.mass = mass;
		constexpr int kFixed = btCollisionObject::CF_STATIC_OBJECT | btCollisionObject::CF_KINEMATIC_OBJECT;
		int flags = body.getCollisionFlags() & ~kFixed;
		if (mass == 0) flags |= isKinematic ? btCollisionObject::CF_KINEMATIC_OBJECT : btCollisionObject::CF_STATIC_OBJECT;
		body.setCollisionFlags(flags);
	}
	// What Bullet asks to be done to a body that is in no world. Joints hold bodies in.
	template <class Change>
	void outside(Member& member, const Change& change)
	{
		if (!m_joints.empty()) return;
		const bool isIn = member.body->isInWorld();
		if (isIn) m_one.world->removeRigidBody(member.body.get());
		change();
		if (isIn) m_one.world->addRigidBody(member.body.get());
	}

	void abuse()
	{
		switch (m_draw.pick(5))
		{
			case 0: abuseContext(); break;
			case 1: abuseShapes(); break;
			case 2: abuseBody(anyMember()); break;
			case 3: abuseMembership(anyMember()); break;
			default: ask(anyMember());
		}
	}
	void abuseContext()
	{
		Context& context = m_draw.oneOf(3) ? m_two->context : m_one.context;
		switch (m_draw.pick(6))
		{
			case 0: context.worldMetric = anyMetric(); break;
			case 1:
				context.budget = {};
				if (m_draw.pick(2)) context.budget.tests = m_draw.oneOf(4) ? 0 : std::floor(m_draw.between(0, 20000));
				break;
			case 2:
				context.searchGap = m_draw.oneOf(6);
				context.keepPoints = !m_draw.oneOf(3);
				context.pushSpeed = m_draw.oneOf(4) ? m_draw.between(0, 30) : 3;
				context.closedShare = m_draw.between(0, 1);
				break;
			case 3:
				context.pairMetric = nullptr;
				if (m_draw.pick(2))
					context.pairMetric = [](const btCollisionObject&, const btCollisionObject&, ContactMetric& metric)
					{
						metric = ContactMetric::errorShare(0.02);
						return true;
					};
				break;
			case 4:
				if (auto* ours = dynamic_cast<btClodDispatcher*>(m_one.dispatcher.get()))
					ours->setThreads(unsigned(1 + m_draw.pick(3)));
				break;
			default: context.forEachPair([](const PairReport&) {}); static_cast<void>(context.lastStep());
		}
	}
	void abuseShapes()
	{
		btClodShape& shape = anyOfOurs();
		switch (m_draw.pick(6))
		{
			case 0: shape.setMetric(anyMetric()); break;
			case 1: shape.clearMetric(); break;
			case 2: rescale(shape); break;
			case 3: shape.setMargin(btScalar(m_draw.oneOf(2) ? 0 : m_draw.between(0, 0.05))); break;
			case 4:
				if (!m_hulls.empty()) m_hulls[m_draw.pick(m_hulls.size())]->addPoint(m_draw.vector(0.7));
				break;
			default:
				if (!m_compounds.empty()) edit(*m_compounds[m_draw.pick(m_compounds.size())]);
		}
	}
	void rescale(btClodShape& shape)
	{
		btVector3 scale = shape.getLocalScaling();
		const double size = double(scale.length()) * double(shape.hierarchy().asset().radius);
		switch (m_draw.pick(4))
		{
			case 0: scale.setX(-scale.x()); break;
			case 1: scale.setY(scale.y() * btScalar(m_draw.between(0.8, 1.2))); break;
			case 2: scale = btVector3(0, 1, 1); break;  // refused
			default: scale *= btScalar(size > 1.5 ? 0.5 : m_draw.between(0.8, 1.25));
		}
		shape.setLocalScaling(scale);
	}
	void edit(btCompoundShape& whole)
	{
		const std::size_t kind = m_draw.pick(3);
		btTransform place(m_draw.turn());
		place.setOrigin(m_draw.vector(0.4));
		if (kind == 0 && whole.getNumChildShapes() > 1)
			whole.removeChildShapeByIndex(int(m_draw.pick(std::size_t(whole.getNumChildShapes()))));
		else if (kind == 1 && whole.getNumChildShapes() < 5)
			whole.addChildShape(place, &anyOfOurs());  // maybe one that is elsewhere, too
		else
			whole.updateChildTransform(0, place);
	}
	void abuseBody(Member& member)
	{
		btRigidBody& body = *member.body;
		switch (m_draw.pick(6))
		{
			case 0: body.setActivationState(m_draw.pick(2) ? ISLAND_SLEEPING : ACTIVE_TAG); break;
			case 1:
			{
				const std::array states{ACTIVE_TAG, ACTIVE_TAG, DISABLE_SIMULATION, DISABLE_DEACTIVATION};
				body.forceActivationState(states[m_draw.pick(4)]);
				break;
			}
			case 2:
				body.setWorldTransform(placeAt(m_draw.between(0, 3)));
				if (m_draw.pick(2)) body.setInterpolationWorldTransform(body.getWorldTransform());
				body.activate();
				break;
			case 3: body.setLinearVelocity(m_draw.vector(std::pow(10, m_draw.between(-1, 2)))), body.activate(); break;
			case 4: body.setAngularVelocity(m_draw.vector(std::pow(10, m_draw.between(-1, 2)))), body.activate(); break;
			default: changeShape(member);
		}
	}
	// Ours may be changed in the world, as long as what comes is no compound.
	void changeShape(Member& member)
	{
		bool isCompound = false;
		btCollisionShape& shape = anyShape(isCompound);
		const bool isOurs = dynamic_cast<btClodShape*>(member.body->getCollisionShape()) != nullptr;
		const bool mayStay = !isCompound && !member.isCompound && isOurs;
		const auto change = [&]
		{
			member.body->setCollisionShape(&shape);
			member.isCompound = isCompound;
			setMass(member, member.mass, member.body->isKinematicObject());
		};
		if (mayStay)
			change();
		else
			outside(member, change);
	}
	void abuseMembership(Member& member)
	{
		btRigidBody* const body = member.body.get();
		switch (m_draw.pick(6))
		{
			case 0:
				if (m_joints.empty() && body->isInWorld()) m_one.world->removeRigidBody(body);
				break;
			case 1:
				if (!body->isInWorld()) m_one.world->addRigidBody(body);
				break;
			case 2:
			{
				const double mass = m_draw.oneOf(3) ? 0 : m_draw.between(0.3, 3);
				const bool isKinematic = m_draw.pick(2) == 1;
				outside(member, [&] { setMass(member, mass, isKinematic); });
				break;
			}
			case 3:
				if (m_bodies.size() < 14) addBody(m_draw.between(2, 4));
				break;
			case 4:
				if (!m_joints.empty() || m_bodies.size() < 4) break;
				if (body->isInWorld()) m_one.world->removeRigidBody(body);
				m_bodies.erase(m_bodies.begin() + (&member - m_bodies.data()));
				break;
			default: joinTo(member);
		}
	}
	void joinTo(Member& member)
	{
		Member& other = anyMember();
		if (!m_joints.empty() && m_draw.oneOf(2))
		{
			m_one.world->removeConstraint(m_joints.back().get());
			m_joints.pop_back();
		}
		else if (&other != &member && other.body->isInWorld() && member.body->isInWorld())
		{
			const btVector3 at = m_draw.vector(0.3), atOther = m_draw.vector(0.3);
			m_joints.push_back(std::make_unique<btPoint2PointConstraint>(*member.body, *other.body, at, atOther));
			m_one.world->addConstraint(m_joints.back().get(), m_draw.pick(2) == 1);
		}
	}
	void ask(Member& member)
	{
		btDiscreteDynamicsWorld& world = *m_one.world;
		Distances distances;
		distances.m_closestDistanceThreshold = btScalar(m_draw.oneOf(2) ? 0 : m_draw.between(0, 1));
		switch (m_draw.pick(6))
		{
			case 0: world.contactTest(member.body.get(), distances); break;
			case 1:
				if (Member& other = anyMember(); &other != &member)
					world.contactPairTest(member.body.get(), other.body.get(), distances);
				break;
			case 2:
			{
				const btVector3 from = m_draw.vector(4), to = m_draw.vector(4);
				btCollisionWorld::ClosestRayResultCallback hit(from, to);
				world.rayTest(from, to, hit);
				btCollisionWorld::ClosestConvexResultCallback swept(from, to);
				const btSphereShape ball(btScalar(0.1));
				world.convexSweepTest(&ball, btTransform(btQuaternion::getIdentity(), from),
									  btTransform(btQuaternion::getIdentity(), to), swept);
				break;
			}
			case 3: world.debugDrawWorld(); break;
			case 4:
			{
				btDefaultSerializer serializer;
				world.serialize(&serializer);
				break;
			}
			default:
				if (member.body->isInWorld())
					world.getBroadphase()->getOverlappingPairCache()->cleanProxyFromPairs(member.body->getBroadphaseHandle(),
																						  m_one.dispatcher.get());
		}
		if (!distances.finite) m_wrong = "a distance is not finite";
	}
	// What programs move themselves.
	void move()
	{
		++m_moves;
		for (const Member& member : m_bodies)
			if (member.body->isKinematicObject())
				member.body->translate(btVector3(btScalar(0.05 * std::sin(0.1 * m_moves)), 0, 0));
	}
	bool look(std::uint64_t& hash)
	{
		for (const Member& member : m_bodies)
		{
			btRigidBody& body = *member.body;
			const btVector3 at = body.getWorldTransform().getOrigin();
			const btVector3 v = body.getLinearVelocity(), w = body.getAngularVelocity();
			for (const btVector3& u : {at, v, w})
				for (int k = 0; k < 3; ++k) hash = mixed(hash, double(u[k]));
			if (!std::isfinite(double(at.length2() + v.length2() + w.length2()))) return false;
			if (double(at.length()) > kFar) body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 3, 0)));
			if (double(at.length()) > kFar || double(v.length()) > kFastest) body.setLinearVelocity(btVector3(0, 0, 0));
		}
		const btVector3 at = m_shared->getWorldTransform().getOrigin();
		for (int k = 0; k < 3; ++k) hash = mixed(hash, double(at[k]));
		return std::isfinite(double(at.length2()));
	}
	// In any order.
	std::string end()
	{
		for (const auto& joint : m_joints) m_one.world->removeConstraint(joint.get());
		if (m_draw.pick(2))
			for (const Member& member : m_bodies)
				if (member.body->isInWorld()) m_one.world->removeRigidBody(member.body.get());
		const bool firstFirst = m_draw.pick(2) == 1;
		if (firstFirst) m_one.world.reset();
		m_two->world.reset();
		m_one.world.reset();
		int left = m_one.dispatcher->getNumManifolds() + m_two->dispatcher->getNumManifolds();
		for (AbusedWorld* world : {&m_one, m_two.get()}) world->context.forEachPair([&left](const PairReport&) { ++left; });
		if (left > 0) return std::to_string(left) + " manifolds or pairs are left";
		if (g_points.unknown > 0) return "data that no point had were destroyed";
		return g_points.live.empty() ? "" : "data of " + std::to_string(g_points.live.size()) + " points were forgotten";
	}

	RandomShapes m_draw;
	std::vector<btClodShape*> m_ours;
	std::vector<btConvexHullShape*> m_hulls;
	std::vector<btCompoundShape*> m_compounds;
	btTriangleMesh m_mesh;
	NoDrawing m_drawing;
	AbusedWorld m_one;
	std::unique_ptr<AbusedWorld> m_two;  // whose context may be the first's
	std::vector<Member> m_bodies;
	std::unique_ptr<btRigidBody> m_shared, m_sharedGround;
	std::vector<std::unique_ptr<btPoint2PointConstraint>> m_joints;
	int m_moves = 0;
	std::string m_wrong;
};
}  // namespace

TEST(AbusedWorlds, StayFiniteAndLeaveNothing)
{
	const int starts = setting("CLOD_STARTS", 6);
	long points = 0;
	for (int seed = 0; seed < starts; ++seed)
	{
		std::uint64_t hash = 0, again = 0;
		EXPECT_EQ(AbusedWorlds(std::uint64_t(seed)).run(90, hash), "") << "seed " << seed;
		points += g_points.made;
		AbusedWorlds(std::uint64_t(seed)).run(90, again);
		EXPECT_EQ(again, hash) << "seed " << seed;
	}
	EXPECT_GT(points, 100);
}
}  // namespace clod::test
