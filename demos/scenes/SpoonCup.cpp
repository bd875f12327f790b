// SPDX-License-Identifier: Zlib
// A spoon drops into a cup, is stirred by a gravity vector that tilts and turns, and comes to rest.
#include "demos/scenes/SpoonCup.h"

#include <btBulletDynamicsCommon.h>
#include <clod/bullet/Context.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodShape.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "demos/scenes/BulletPose.h"

namespace clod::demo
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

// The scene's constants: SI units, lengths and speeds before worldScale is applied.
namespace constant
{
constexpr double worldScale = 100;
constexpr double stepSize = 1.0 / 240;
constexpr int steps = 1200;
constexpr double openingRadius = 0.0352;  // of the cup, inside, at the rim
constexpr double cupHeight = 0.090;
constexpr double spoonWall = 0.0015;                // of its bowl: the thinner of both bodies' walls
constexpr double tolerance = 0.01 * openingRadius;  // contacts are reported up to this gap
constexpr double gravity = 9.81;
constexpr double spoonMass = 0.040;
constexpr double friction = 0.3;                                       // of each body; Bullet multiplies the two
constexpr double rollingFriction = 0.0003, spinningFriction = 0.0003;  // lever arms, in metres
constexpr double restitution = 0;
constexpr double margin = 0;
constexpr double linearDamping = 0, angularDamping = 0.5;
constexpr int solverIterations = 30;
constexpr double splitImpulsePenetrationThreshold = 0;
constexpr double erp = 0.2, erp2 = 0.8;
// Time course, in seconds: drop and settle, stir, rest.
constexpr double stirBegins = 0.35, stirEnds = 4.5, ramp = 0.25;
constexpr double stirTilt = 0.5;       // radians between gravity and down
constexpr double stirFrequency = 0.8;  // turns a second
// How the spoon starts: bowl down, its tip `dropHeight` over the cup's bottom, leaning by `lean` radians.
constexpr double cupBottom = 0.003, dropHeight = 0.012, tipOffset = -0.012, lean = 0.38;
}  // namespace constant

// 0 before the stirring, 1 within it, smooth between.
double stirring(double time)
{
	const double in = (time - constant::stirBegins) / constant::ramp,
				 out = (constant::stirEnds - time) / constant::ramp;
	const double t = std::clamp(std::min(in, out), 0.0, 1.0);
	return t * t * (3 - 2 * t);
}

Vec3 gravityAt(double time)
{
	const double tilt = constant::stirTilt * stirring(time);
	const double turn = 2 * kPi * constant::stirFrequency * (time - constant::stirBegins);
	return constant::gravity * Vec3{std::sin(tilt) * std::cos(turn), -std::cos(tilt), std::sin(tilt) * std::sin(turn)};
}

Pose spoonStart()
{
	const double half = (kPi / 2 - constant::lean) / 2;  // about z: the handle, along x in the mesh, turns up
	return {{constant::tipOffset, constant::cupBottom + constant::dropHeight, 0},
			{0, 0, std::sin(half), std::cos(half)}};
}

Vec3 centerOf(const Hierarchy& hierarchy)
{
	const double(&c)[3] = hierarchy.asset().meshFromBody;
	return {c[0], c[1], c[2]};
}

// A world that knows how long its collision dispatch took.
class TimedWorld : public btDiscreteDynamicsWorld
{
public:
	using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
	void performDiscreteCollisionDetection() override
	{
		const auto start = std::chrono::steady_clock::now();
		btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
		m_dispatchMicroseconds =
			std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
	}
	double dispatchMicroseconds() const { return m_dispatchMicroseconds; }

private:
	double m_dispatchMicroseconds = 0;
};
}  // namespace

struct SpoonCup::Bullet
{
	Context context;
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher{&configuration};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	TimedWorld world{&dispatcher, &broadphase, &solver, &configuration};
	std::unique_ptr<btClodShape> shapes[2];
	std::unique_ptr<btRigidBody> bodies[2];
};

SpoonCup::SpoonCup(const SceneSettings& settings) : m_settings(settings), m_bullet(new Bullet)
{
	Bullet& bullet = *m_bullet;
	const Result<int> registered = btClodCollisionAlgorithm::registerAlgorithm(&bullet.dispatcher, &bullet.context);
	if (!registered) throw std::runtime_error(registered.error());
	btContactSolverInfo& solver = bullet.world.getSolverInfo();
	solver.m_numIterations = constant::solverIterations;
	// One friction direction along the slip lets a leaning spoon creep sideways for ever; two hold it.
	solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
	solver.m_splitImpulse = true;
	solver.m_splitImpulsePenetrationThreshold = btScalar(constant::splitImpulsePenetrationThreshold);
	solver.m_erp = btScalar(constant::erp);
	solver.m_erp2 = btScalar(constant::erp2);
	addBody(0, settings.a, 0, Pose{});
	addBody(1, settings.b, constant::spoonMass, spoonStart());
}

SpoonCup::~SpoonCup()
{
	for (const auto& body : m_bullet->bodies)
		if (body) m_bullet->world.removeRigidBody(body.get());
}

void SpoonCup::addBody(int index, const std::shared_ptr<const Hierarchy>& hierarchy, double mass, const Pose& start)
{
	auto& shape = m_bullet->shapes[index];
	shape = std::make_unique<btClodShape>(hierarchy);
	const btScalar scale = btScalar(constant::worldScale);
	shape->setLocalScaling({scale, scale, scale});
	shape->setMargin(btScalar(constant::margin));
	ContactMetric metric;
	metric.exact = m_settings.query.metric.exact;
	metric.weightedDeviation = m_settings.query.metric.weightedDeviation;
	metric.maxError = m_settings.query.metric.maxError;
	shape->setMetric(metric);
	btVector3 inertia(0, 0, 0);
	if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
	btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
	info.m_startWorldTransform = bodyTransform(start, centerOf(*hierarchy), constant::worldScale);
	info.m_friction = btScalar(constant::friction);
	info.m_rollingFriction = btScalar(constant::rollingFriction * constant::worldScale);
	info.m_spinningFriction = btScalar(constant::spinningFriction * constant::worldScale);
	info.m_restitution = btScalar(constant::restitution);
	info.m_linearDamping = btScalar(constant::linearDamping);
	info.m_angularDamping = btScalar(constant::angularDamping);
	auto& body = m_bullet->bodies[index];
	body = std::make_unique<btRigidBody>(info);
	body->setActivationState(DISABLE_DEACTIVATION);
	m_bullet->world.addRigidBody(body.get());
}

void SpoonCup::step()
{
	const Vec3 gravity = gravityAt(m_step * m_settings.dt);
	m_bullet->world.setGravity(toBullet(gravity, constant::worldScale));
	const auto start = std::chrono::steady_clock::now();
	m_bullet->world.stepSimulation(btScalar(m_settings.dt), 0);
	m_stepMicroseconds = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
	++m_step;
}

SceneState SpoonCup::state() const
{
	constexpr double scale = constant::worldScale;
	const Bullet& bullet = *m_bullet;
	const btRigidBody& spoon = *bullet.bodies[1];
	SceneState state;
	state.poses = {m_step, meshPose(bullet.bodies[0]->getWorldTransform(), centerOf(*m_settings.a), scale),
				   meshPose(spoon.getWorldTransform(), centerOf(*m_settings.b), scale)};
	state.time = m_step * m_settings.dt;
	state.gravity = gravityAt(state.time);
	state.velocity = fromBullet(spoon.getLinearVelocity(), scale);
	state.turning = fromBullet(spoon.getAngularVelocity());
	state.stepMicroseconds = m_stepMicroseconds;
	state.dispatchMicroseconds = bullet.world.dispatchMicroseconds();
	state.warnings = bullet.context.lastStep().warnings;
	addPoints(state);
	const Vec3 center = fromBullet(spoon.getWorldTransform().getOrigin(), scale);
	state.inPlace =
		center.y > 0 && center.y < constant::cupHeight && std::hypot(center.x, center.z) < constant::openingRadius;
	return state;
}

void SpoonCup::addPoints(SceneState& state) const
{
	constexpr double scale = constant::worldScale;
	const btCollisionDispatcher& dispatcher = m_bullet->dispatcher;
	state.manifolds = dispatcher.getNumManifolds();
	for (int i = 0; i < state.manifolds; ++i)
	{
		const btPersistentManifold* manifold =
			const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
		// Bullet's normal points to the manifold's own body 0.
		const bool spoonIsSecond = manifold->getBody1() == m_bullet->bodies[1].get();
		for (int k = 0; k < manifold->getNumContacts(); ++k)
		{
			const btManifoldPoint& p = manifold->getContactPoint(k);
			const btVector3& position = spoonIsSecond ? p.getPositionWorldOnB() : p.getPositionWorldOnA();
			state.points.push_back({fromBullet(position, scale),
									(spoonIsSecond ? 1.0 : -1.0) * fromBullet(p.m_normalWorldOnB),
									double(p.getDistance()) / scale, double(p.getAppliedImpulse()) / scale});
		}
	}
}

std::vector<SceneConstant> SpoonCup::constants() const
{
	using namespace constant;
	return {{"world_scale", worldScale, ""},
			{"step_size", m_settings.dt, "s"},
			{"cup_opening_radius", openingRadius, "m"},
			{"tolerance", tolerance, "m"},
			{"thinner_wall", spoonWall, "m"},
			{"gravity", gravity, "m/s^2"},
			{"cup_mass", 0, "kg (0: static)"},
			{"spoon_mass", spoonMass, "kg"},
			{"friction", friction, "each body"},
			{"rolling_friction", rollingFriction, "m"},
			{"spinning_friction", spinningFriction, "m"},
			{"restitution", restitution, ""},
			{"margin", margin, "m"},
			{"linear_damping", linearDamping, ""},
			{"angular_damping", angularDamping, ""},
			{"solver_iterations", solverIterations, ""},
			{"friction_directions", 2, ""},
			{"split_impulse", 1, ""},
			{"split_impulse_penetration_threshold", splitImpulsePenetrationThreshold, "Bullet's length"},
			{"erp", erp, ""},
			{"erp2", erp2, ""},
			{"sleeping", 0, ""},
			{"stir_begins", stirBegins, "s"},
			{"stir_ends", stirEnds, "s"},
			{"stir_ramp", ramp, "s"},
			{"stir_tilt", stirTilt, "rad"},
			{"stir_frequency", stirFrequency, "Hz"},
			{"spoon_drop_height", dropHeight, "m"},
			{"spoon_tip_offset", tipOffset, "m"},
			{"spoon_lean", lean, "rad"}};
}

SceneInfo spoonCupInfo()
{
	SceneInfo info;
	info.name = "spoon-cup";
	info.summary = "a spoon drops into a cup, is stirred by tilting gravity, comes to rest";
	info.modelA = "cup";
	info.modelB = "spoon";
	info.tolerance = constant::tolerance;
	info.thinnerWall = constant::spoonWall;
	info.dt = constant::stepSize;
	info.steps = constant::steps;
	info.worldScale = constant::worldScale;
	info.overview = {0.005, 0.066, 0};
	info.overviewRadius = 0.095;
	info.closeUp = {0.020, -0.004, 0};
	info.closeUpRadius = 0.03;
	return info;
}
}  // namespace clod::demo
