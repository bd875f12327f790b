// SPDX-License-Identifier: Zlib
#include "clod/bullet/BodyState.h"

#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <array>
#include <cstdint>

namespace clod
{
Vec3 toVec3(const btVector3& v)
{
	return {double(v.x()), double(v.y()), double(v.z())};
}

btVector3 toBullet(const Vec3& v)
{
	return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

Transform toTransform(const btTransform& t)
{
	const btMatrix3x3& m = t.getBasis();
	const Vec3 x = normalized(toVec3(m.getColumn(0)));
	const Vec3 roughY = toVec3(m.getColumn(1));
	const Vec3 y = normalized(roughY - dot(roughY, x) * x);
	return {transposed({{x, y, cross(x, y)}}), toVec3(t.getOrigin())};
}

bool isFinite(const btTransform& t)
{
	const btMatrix3x3& m = t.getBasis();
	return isFinite(toVec3(t.getOrigin())) && isFinite(toVec3(m[0])) && isFinite(toVec3(m[1])) &&
		   isFinite(toVec3(m[2]));
}

bool isFinite(const Transform& t)
{
	return isFinite(t.translation) && isFinite(t.rotation.row[0]) && isFinite(t.rotation.row[1]) &&
		   isFinite(t.rotation.row[2]);
}

bool isFinite(const RelativeMotion& motion)
{
	return isFinite(motion.linear) && isFinite(motion.angular);
}

namespace
{
constexpr double kRounding = 1e-12;  // of speeds: differences that are no more

// Forces and torques are taken to act on each link as if it were free, as they are for bodies that constraints hold.
RelativeMotion motionOfLink(const btMultiBodyLinkCollider& link, double timeStep)
{
	const btMultiBody& body = *link.m_multiBody;
	const int index = link.m_link;
	btAlignedObjectArray<btVector3> turning, moving;  // of all, the base's first
	turning.resize(body.getNumLinks() + 1);
	moving.resize(body.getNumLinks() + 1);
	body.compTreeLinkVelocities(&turning[0], &moving[0]);
	Vec3 angular = toVec3(body.localDirToWorld(index, turning[index + 1]));
	Vec3 linear = toVec3(body.localDirToWorld(index, moving[index + 1]));
	const bool isBase = index < 0;
	const double mass = double(isBase ? body.getBaseMass() : body.getLinkMass(index));
	if (timeStep > 0 && mass > 0 && !(isBase && body.hasFixedBase()))
	{
		linear += (timeStep / mass) * toVec3(isBase ? body.getBaseForce() : body.getLinkForce(index));
		const btMatrix3x3& basis = link.getWorldTransform().getBasis();
		const btVector3 torque = (isBase ? body.getBaseTorque() : body.getLinkTorque(index)) * basis;
		const btVector3 inertia = isBase ? body.getBaseInertia() : body.getLinkInertia(index);
		btVector3 spin(0, 0, 0);
		for (int i = 0; i < 3; ++i)
			if (inertia[i] > 0) spin[i] = torque[i] / inertia[i];
		angular += timeStep * toVec3(basis * spin);
	}
	return {linear - cross(angular, toVec3(link.getWorldTransform().getOrigin())), angular, 0};
}

// By BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY. Each pair of a body asks for the same.
btVector3 implicitInBody(const btRigidBody& body, btScalar dt)
{
	struct Known
	{
		btMatrix3x3 basis;
		btVector3 inverse, turning, impulse;
		btScalar dt = 0;
	};
	thread_local std::array<Known, 64> all;
	Known& known = all[reinterpret_cast<std::uintptr_t>(&body) / sizeof(btRigidBody) % all.size()];
	const btMatrix3x3& basis = body.getWorldTransform().getBasis();
	const btVector3 &inverse = body.getInvInertiaDiagLocal(), &turning = body.getAngularVelocity();
	if (known.dt != dt || known.turning != turning || known.inverse != inverse || !(known.basis == basis))
		known = {basis, inverse, turning, body.computeGyroscopicImpulseImplicit_Body(dt), dt};
	return known.impulse;
}

// What Bullet adds in a step to the turning of a body that is not round, each flag by itself.
Vec3 gyroscopicImpulse(const btRigidBody& body, double timeStep)
{
	const btVector3& inverse = body.getInvInertiaDiagLocal();
	const bool isRound = inverse.x() == inverse.y() && inverse.y() == inverse.z();  // of a cube as well
	if (isRound || body.getAngularVelocity().isZero()) return {};
	const int flags = body.getFlags();
	btVector3 sum(0, 0, 0);
	const btScalar dt = btScalar(timeStep);
	if ((flags & BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT) != 0)
	{
		const btScalar most = btContactSolverInfo().m_maxGyroscopicForce;  // the solver's own is not known here
		sum -= dt * body.computeGyroscopicForceExplicit(most) * body.getInvInertiaTensorWorld();
	}
	if ((flags & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) != 0)
		sum += body.computeGyroscopicImpulseImplicit_World(dt);
	if ((flags & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) != 0) sum += implicitInBody(body, dt);
	return toVec3(sum);
}
}  // namespace

bool isFixed(const btCollisionObject& object)
{
	return object.isStaticObject() && !object.isKinematicObject();
}

bool isMoving(const btCollisionObject& object)
{
	return object.isActive() && !object.isStaticOrKinematicObject();
}

bool moveAsOne(const btCollisionObject& a, const btCollisionObject& b)
{
	constexpr double kAlike = 1e-3;  // of a velocity, which Bullet takes from differences of places
	if (&a == &b) return true;
	if (!a.isStaticOrKinematicObject() || !b.isStaticOrKinematicObject()) return false;
	const RelativeMotion ofA = worldMotion(a, 0), ofB = worldMotion(b, 0);
	const auto areAlike = [](const Vec3& l, const Vec3& r) { return length(l - r) <= kAlike * length(l); };
	return areAlike(ofA.linear, ofB.linear) && areAlike(ofA.angular, ofB.angular);
}

RelativeMotion worldMotion(const btCollisionObject& object, double timeStep)
{
	if (isFixed(object)) return {};
	if (const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object)) return motionOfLink(*link, timeStep);
	Vec3 linear = toVec3(object.getInterpolationLinearVelocity());
	Vec3 angular = toVec3(object.getInterpolationAngularVelocity());
	if (const btRigidBody* body = btRigidBody::upcast(&object))
	{
		// Forces and torques are sums of what was applied, and the body's factors are in them.
		linear = toVec3(body->getLinearVelocity()) + timeStep * double(body->getInvMass()) * toVec3(body->getTotalForce());
		angular = toVec3(body->getAngularVelocity()) +
				  timeStep * toVec3(body->getInvInertiaTensorWorld() * body->getTotalTorque());
		if (timeStep > 0 && !body->isStaticOrKinematicObject()) angular += gyroscopicImpulse(*body, timeStep);
	}
	return {linear - cross(angular, toVec3(object.getWorldTransform().getOrigin())), angular, 0};
}

RelativeMotion solvedMotion(const btCollisionObject& object)
{
	if (object.isStaticOrKinematicObject()) return worldMotion(object, 0);
	const Vec3 angular = toVec3(object.getInterpolationAngularVelocity());
	return {toVec3(object.getInterpolationLinearVelocity()) -
				cross(angular, toVec3(object.getWorldTransform().getOrigin())),
			angular, 0};
}

RelativeMotion relativeMotion(const RelativeMotion& a, const RelativeMotion& b, const Transform& worldFromA, double scale,
							  double timeStep)
{
	RelativeMotion motion = inFrame({a.linear - b.linear, a.angular - b.angular, 0}, worldFromA);
	motion.linear = (1 / scale) * motion.linear;
	motion.timeStep = timeStep;
	return motion;
}

double kineticEnergy(const btRigidBody& body, double timeStep)
{
	const btTransform& pose = body.getWorldTransform();
	const RelativeMotion motion = worldMotion(body, timeStep);
	// Of what no impulse moves Bullet tells no mass and no inertia.
	const double mass = body.getInvMass() > 0 ? 1 / double(body.getInvMass()) : 0;
	const Vec3 turning = transposed(toTransform(pose).rotation) * motion.angular, inertia = toVec3(body.getLocalInertia());
	return 0.5 * (mass * lengthSquared(motion.velocity(toVec3(pose.getOrigin()))) + inertia.x * turning.x * turning.x +
				  inertia.y * turning.y * turning.y + inertia.z * turning.z * turning.z);
}

PairBody pairBody(const btCollisionObject& object, const Transform& worldFromFrame, double scale,
				  const RelativeMotion& motion, const RelativeMotion& withoutForces)
{
	const Vec3 center = toVec3(object.getWorldTransform().getOrigin());
	const Mat3 frameFromWorld = transposed(worldFromFrame.rotation);
	PairBody body;
	body.center = (1 / scale) * (frameFromWorld * (center - worldFromFrame.translation));
	const Vec3 velocity = motion.velocity(center), gained = velocity - withoutForces.velocity(center);
	body.linear = (1 / scale) * (frameFromWorld * velocity);
	body.angular = frameFromWorld * motion.angular;
	// What rounding leaves of no force is none: paths are asked for once more where forces bend them.
	const double largest = length(motion.linear) + length(motion.angular) * length(center);
	if (length(gained) > kRounding * largest) body.force = (1 / scale) * (frameFromWorld * gained);
	const btRigidBody* rigid = btRigidBody::upcast(&object);
	if (!rigid || object.isStaticOrKinematicObject()) return body;
	// Bullet scales what impulses turn by the factor, on one side of the tensor; on both, no contact has a negative mass.
	const btMatrix3x3& inertia = rigid->getInvInertiaTensorWorld();
	const btVector3& turns = rigid->getAngularFactor();
	Mat3 world;
	for (int i = 0; i < 3; ++i) world.row[i] = toVec3(turns[i] * turns * inertia[i]);
	body.inverseMass = double(rigid->getInvMass());
	body.inverseInertia = frameFromWorld * (world * worldFromFrame.rotation);
	for (Vec3& row : body.inverseInertia.row) row = scale * scale * row;
	return body;
}
}  // namespace clod
