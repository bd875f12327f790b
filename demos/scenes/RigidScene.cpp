// SPDX-License-Identifier: Zlib
// Bodies, solver and clock of a scene in Bullet.
#include "demos/scenes/RigidScene.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletDynamicsCommon.h>
#include <clod/bullet/ConfigureWorld.h>
#include <clod/bullet/btClodDispatcher.h>
#include <clod/bullet/btClodDynamicsWorld.h>
#include <clod/bullet/btClodShape.h>

#include <algorithm>
#include <stdexcept>

#include "demos/scenes/BulletPose.h"
#include "demos/scenes/BulletShapes.h"

namespace clod::demo
{
namespace
{
Vec3 centerOf(const Hierarchy& hierarchy)
{
	const double(&c)[3] = hierarchy.asset().meshFromBody;
	return {c[0], c[1], c[2]};
}

// A world that knows how long its collision dispatch took.
class TimedWorld : public btClodDynamicsWorld
{
public:
	using btClodDynamicsWorld::btClodDynamicsWorld;
	void setTimedBy(TimedBy by) { m_timedBy = by; }
	void performDiscreteCollisionDetection() override
	{
		const Stopwatch watch(m_timedBy);
		btClodDynamicsWorld::performDiscreteCollisionDetection();
		m_dispatchMicroseconds += watch.microseconds();
	}
	void startStep() { m_dispatchMicroseconds = 0; }
	double dispatchMicroseconds() const { return m_dispatchMicroseconds; }

private:
	TimedBy m_timedBy = TimedBy::clock;
	double m_dispatchMicroseconds = 0;
};
}  // namespace

std::unique_ptr<Scene> makeScene(const std::string& name, const SceneSettings& settings)
{
	const SceneDefinition* const scene = findDefinition(name);
	return scene ? makeScene(*scene, settings) : nullptr;
}

std::unique_ptr<Scene> makeScene(const SceneDefinition& definition, const SceneSettings& settings)
{
	return std::make_unique<RigidScene>(definition, settings);
}

struct RigidScene::Bullet
{
	Context context;
	btDefaultCollisionConfiguration configuration;
	mutable btClodDispatcher dispatcher{&configuration, &context};
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	TimedWorld world{&dispatcher, &broadphase, &solver, &configuration, &context};
	std::vector<std::unique_ptr<btClodShape>> shapes;  // one a model; inertia is theirs, whatever collides
	std::vector<PlainShape> others;                    // one a model, or none
	std::vector<std::unique_ptr<btRigidBody>> bodies;
	std::vector<std::unique_ptr<btTypedConstraint>> joints;
};

RigidScene::RigidScene(const SceneDefinition& definition, const SceneSettings& settings)
	: m_definition(definition), m_settings(settings), m_bullet(new Bullet)
{
	if (m_definition.prepare) m_definition.prepare(m_definition, settings.models);
	Bullet& bullet = *m_bullet;
	// Before ours, which GImpact's would overwrite.
	if (!settings.shapes.empty()) btGImpactCollisionAlgorithm::registerAlgorithm(&bullet.dispatcher);
	bullet.context.worldMetric = settings.metric;
	bullet.context.budget = settings.budget;
	if (!settings.printsWarnings) bullet.context.warn = nullptr;
	bullet.dispatcher.setThreads(settings.threads);
	bullet.world.setTimedBy(settings.timedBy);
	setUpSolver();
	const btScalar scale = btScalar(definition.info.worldScale);
	for (const auto& model : settings.models)
	{
		bullet.shapes.push_back(std::make_unique<btClodShape>(model));
		bullet.shapes.back()->setLocalScaling({scale, scale, scale});
		bullet.shapes.back()->setMargin(btScalar(definition.world.margin));
	}
	for (std::size_t i = 0; i < settings.shapes.size(); ++i)
		bullet.others.emplace_back(settings.shapes[i], centerOf(*settings.models[i]), definition.info.worldScale);
	for (std::size_t i = 0; i < m_definition.bodies.size(); ++i) addBody(i);
}

RigidScene::~RigidScene()
{
	for (const auto& joint : m_bullet->joints) m_bullet->world.removeConstraint(joint.get());
	for (const auto& body : m_bullet->bodies) m_bullet->world.removeRigidBody(body.get());
}

// As the contacts of the coming step are judged by.
void RigidScene::placeCamera()
{
	if (!m_settings.camera) return;
	m_bullet->context.camera = scaled(m_settings.camera->at(m_step + 1), m_definition.info.worldScale);
}

void RigidScene::placeGravity()
{
	m_bullet->world.setGravity(toBullet(m_definition.gravity(m_step * m_settings.dt), m_definition.info.worldScale));
}

void RigidScene::setUpSolver()
{
	WorldSettings settings;
	settings.solverIterations = m_definition.world.solverIterations;
	settings.warmstartingFactor = m_definition.world.warmstartingFactor.value_or(settings.warmstartingFactor);
	placeGravity();
	const Result<int> registered = setUpWorld(m_bullet->world, m_bullet->context, settings);
	if (!registered) throw std::runtime_error(registered.error());
	m_bullet->world.setMostPasses(m_settings.passes);
	m_bullet->world.setMostParts(m_settings.parts);
	if (m_settings.atImpacts) m_bullet->world.setStepping(btClodDynamicsWorld::Stepping::kImpacts);
}

const Hierarchy& RigidScene::hierarchyOf(std::size_t body) const
{
	return *m_settings.models[m_definition.info.bodies[body].model];
}

void RigidScene::addBody(std::size_t index)
{
	const BodyDefinition& definition = m_definition.bodies[index];
	const WorldConstants& constants = m_definition.world;
	const double scale = m_definition.info.worldScale;
	const Material& material = definition.material ? *definition.material : constants;
	const std::size_t model = m_definition.info.bodies[index].model;
	btCollisionShape* shape = m_bullet->shapes[model].get();
	btVector3 inertia(0, 0, 0);
	if (definition.mass > 0) shape->calculateLocalInertia(btScalar(definition.mass), inertia);
	if (!m_bullet->others.empty() && m_settings.shapes[model].kind != SceneShape::Kind::clod)
		shape = &m_bullet->others[model].shape();
	btRigidBody::btRigidBodyConstructionInfo info(btScalar(definition.mass), nullptr, shape, inertia);
	const Pose start = definition.course ? definition.course(0) : definition.start;
	info.m_startWorldTransform = bodyTransform(start, centerOf(hierarchyOf(index)), scale);
	info.m_friction = btScalar(material.friction);
	info.m_rollingFriction = btScalar(material.rollingFriction * scale);
	info.m_spinningFriction = btScalar(material.spinningFriction * scale);
	info.m_restitution = btScalar(material.restitution);
	info.m_linearDamping = btScalar(constants.linearDamping);
	info.m_angularDamping = btScalar(constants.angularDamping);
	m_bullet->bodies.push_back(std::make_unique<btRigidBody>(info));
	btRigidBody& body = *m_bullet->bodies.back();
	if (definition.course)
		body.setCollisionFlags((body.getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
							   btCollisionObject::CF_KINEMATIC_OBJECT);
	body.setLinearVelocity(toBullet(definition.velocity, scale));
	body.setAngularVelocity(toBullet(definition.turning));
	body.setLinearFactor(toBullet(definition.moves));
	body.setAngularFactor(toBullet(definition.turns));
	body.setUserIndex(int(index));
	body.setActivationState(DISABLE_DEACTIVATION);
	m_bullet->world.addRigidBody(&body);
	for (const BodyJoint& joint : definition.joints) addJoint(body, joint);
}

void RigidScene::addJoint(btRigidBody& body, const BodyJoint& joint)
{
	// A frame at the point whose x axis (of sliders) or z axis (of hinges) is the joint's.
	const bool isSlider = joint.kind == BodyJoint::Kind::slider;
	const btVector3 axis = toBullet(joint.axis).normalized();
	const btTransform worldFromJoint(shortestArcQuat(isSlider ? btVector3(1, 0, 0) : btVector3(0, 0, 1), axis),
									 toBullet(joint.point, m_definition.info.worldScale));
	// To the world is to a body that never moves, whose frame is the world's.
	btRigidBody& other = joint.partner ? *m_bullet->bodies[*joint.partner] : btTypedConstraint::getFixedBody();
	const btTransform otherFromJoint =
		(joint.partner ? other.getWorldTransform().inverse() : btTransform::getIdentity()) * worldFromJoint;
	const btTransform bodyFromJoint = body.getWorldTransform().inverse() * worldFromJoint;
	std::unique_ptr<btTypedConstraint> constraint;
	if (joint.kind == BodyJoint::Kind::ball)
		constraint = std::make_unique<btPoint2PointConstraint>(body, other, bodyFromJoint.getOrigin(),
															   otherFromJoint.getOrigin());
	else if (joint.kind == BodyJoint::Kind::hinge)
		constraint = std::make_unique<btHingeConstraint>(body, other, bodyFromJoint, otherFromJoint);
	else if (isSlider)
		constraint = std::make_unique<btSliderConstraint>(body, other, bodyFromJoint, otherFromJoint, true);
	else
		constraint = std::make_unique<btFixedConstraint>(body, other, bodyFromJoint, otherFromJoint);
	if (isSlider)
	{
		auto& slider = static_cast<btSliderConstraint&>(*constraint);
		slider.setLowerLinLimit(1);  // lower above upper: free
		slider.setUpperLinLimit(-1);
		slider.setLowerAngLimit(0);
		slider.setUpperAngLimit(0);
	}
	m_bullet->world.addConstraint(constraint.get());
	m_bullet->joints.push_back(std::move(constraint));
}

void RigidScene::step()
{
	const double time = m_step * m_settings.dt;
	placeCamera();
	placeGravity();
	for (std::size_t i = 0; i < m_definition.bodies.size(); ++i)
		if (const auto& course = m_definition.bodies[i].course)
			m_bullet->bodies[i]->setWorldTransform(
				bodyTransform(course(time + m_settings.dt), centerOf(hierarchyOf(i)), m_definition.info.worldScale));
	m_bullet->world.startStep();
	const Stopwatch watch(m_settings.timedBy);
	m_bullet->world.stepSimulation(btScalar(m_settings.dt), 0);
	m_stepMicroseconds = watch.microseconds();
	++m_step;
}

void RigidScene::place(const SceneState& state)
{
	const double scale = m_definition.info.worldScale;
	m_step = int(state.step);
	for (std::size_t i = 0; i < m_bullet->bodies.size(); ++i)
	{
		btRigidBody& body = *m_bullet->bodies[i];
		if (m_definition.bodies[i].course || body.isStaticObject()) continue;
		body.setCenterOfMassTransform(bodyTransform(state.bodies[i].pose, centerOf(hierarchyOf(i)), scale));
		body.setLinearVelocity(toBullet(state.bodies[i].velocity, scale));
		body.setAngularVelocity(toBullet(state.bodies[i].turning));
	}
}

void RigidScene::setMetric(const ContactMetric& metric)
{
	m_settings.metric = m_bullet->context.worldMetric = metric;
}

Pose RigidScene::poseOf(std::size_t body) const
{
	// A course is known better than Bullet's precision keeps it.
	if (const auto& course = m_definition.bodies[body].course) return course(m_step * m_settings.dt);
	return meshPose(m_bullet->bodies[body]->getWorldTransform(), centerOf(hierarchyOf(body)),
					m_definition.info.worldScale);
}

StepTimes RigidScene::lastTimes() const
{
	return {m_stepMicroseconds, m_bullet->world.dispatchMicroseconds()};
}

SceneState RigidScene::state() const
{
	const double scale = m_definition.info.worldScale;
	const Bullet& bullet = *m_bullet;
	SceneState state;
	state.step = m_step;
	state.time = m_step * m_settings.dt;
	state.gravity = m_definition.gravity(state.time);
	for (std::size_t i = 0; i < bullet.bodies.size(); ++i)
	{
		const btRigidBody& body = *bullet.bodies[i];
		state.bodies.push_back(
			{poseOf(i), fromBullet(body.getLinearVelocity(), scale), fromBullet(body.getAngularVelocity())});
		const bool canLeave = m_definition.bodies[i].mass > 0;
		if (canLeave && !m_definition.inPlace(i, fromBullet(body.getWorldTransform().getOrigin(), scale)))
			state.inPlace = false;
	}
	state.pairs = nearPairs();
	state.stepMicroseconds = lastTimes().step;
	state.passes = bullet.world.passes();
	state.parts = bullet.world.parts();
	state.pairsAskedAgain = bullet.world.pairsAskedAgain();
	state.dispatchMicroseconds = lastTimes().dispatch;
	const StepReport statistics = bullet.context.lastStep();
	state.warnings = statistics.warnings();
	state.excess = statistics.excess;
	bool isFirst = true;
	bullet.context.forEachPair(
		[&](const PairReport& pair)
		{
			state.contactError = std::max(state.contactError, pair.contactError);
			if (pair.points > 0)
			{
				state.finestLevel = isFirst ? pair.finestLevel : std::min(state.finestLevel, pair.finestLevel);
				state.coarsestLevel = std::max(state.coarsestLevel, pair.coarsestLevel);
				isFirst = false;
			}
			state.tests += pair.vainTests;
			if (pair.kept || !pair.result) return;
			state.tests += std::uint64_t(pair.result->stats.boxTests) + pair.result->stats.hullTests;
			state.coarsestTests += pair.coarsestTests;
		});
	addPoints(state);
	addEnergy(state);
	if (m_definition.outcome) state.outcome = m_definition.outcome(state);
	if (m_settings.budget.isLimited()) addAnswers(state);
	return state;
}

std::vector<BodyPair> RigidScene::nearPairs() const
{
	if (m_definition.info.isPair()) return {{0, 1}};
	const auto& bodies = m_bullet->bodies;
	const btScalar tolerance = btScalar(m_definition.info.tolerance * m_definition.info.worldScale);
	std::vector<btVector3> low(bodies.size()), high(bodies.size());
	for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i]->getAabb(low[i], high[i]);
	std::vector<BodyPair> pairs;
	for (std::uint32_t a = 0; a < bodies.size(); ++a)
		for (std::uint32_t b = a + 1; b < bodies.size(); ++b)
		{
			if (bodies[a]->isStaticObject() && bodies[b]->isStaticObject()) continue;
			const btVector3 reach(tolerance, tolerance, tolerance);
			if (TestAabbAgainstAabb2(low[a] - reach, high[a] + reach, low[b], high[b])) pairs.push_back({a, b});
		}
	return pairs;
}

void RigidScene::addPoints(SceneState& state) const
{
	const double scale = m_definition.info.worldScale;
	btCollisionDispatcher& dispatcher = m_bullet->dispatcher;
	state.manifolds = dispatcher.getNumManifolds();
	for (int i = 0; i < state.manifolds; ++i)
	{
		const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
		const std::uint32_t first = std::uint32_t(manifold->getBody0()->getUserIndex()),
							second = std::uint32_t(manifold->getBody1()->getUserIndex());
		// Bullet's normal points to the manifold's own body 0.
		const bool inOrder = first < second;
		for (int k = 0; k < manifold->getNumContacts(); ++k)
		{
			const btManifoldPoint& p = manifold->getContactPoint(k);
			const btVector3& position = inOrder ? p.getPositionWorldOnB() : p.getPositionWorldOnA();
			state.points.push_back({{std::min(first, second), std::max(first, second)},
									fromBullet(position, scale),
									(inOrder ? 1.0 : -1.0) * fromBullet(p.m_normalWorldOnB),
									double(p.getDistance()) / scale,
									double(p.getAppliedImpulse()) / scale});
		}
	}
}

// Of Bullet's own bodies, with the inertia that they turn by.
void RigidScene::addEnergy(SceneState& state) const
{
	const double scale = m_definition.info.worldScale;
	for (std::size_t i = 0; i < m_bullet->bodies.size(); ++i)
	{
		const btRigidBody& body = *m_bullet->bodies[i];
		if (body.isStaticOrKinematicObject()) continue;
		const double mass = m_definition.bodies[i].mass;
		const Vec3 turning = transposed(toTransform(state.bodies[i].pose).rotation) * state.bodies[i].turning;
		const btVector3& inverse = body.getInvInertiaDiagLocal();
		double twice = mass * lengthSquared(state.bodies[i].velocity);
		for (int k = 0; k < 3; ++k)
			if (inverse[k] > 0) twice += turning[k] * turning[k] / (double(inverse[k]) * scale * scale);
		state.kinetic += twice / 2;
		state.potential -= mass * dot(state.gravity, fromBullet(body.getWorldTransform().getOrigin(), scale));
	}
}

void RigidScene::addAnswers(SceneState& state) const
{
	const auto add = [&](const PairReport& pair)
	{
		if (!pair.result) return;
		state.answers.push_back(
			{{std::uint32_t(pair.objectA->getUserIndex()), std::uint32_t(pair.objectB->getUserIndex())}, resultOf(pair)});
		QueryStats& stats = state.answers.back().result.stats;
		if (pair.queryMicroseconds == 0) stats.boxTests = stats.hullTests = 0;
		state.queryMicroseconds += pair.queryMicroseconds;
	};
	m_bullet->context.forEachPair(add);
}

std::vector<SceneConstant> RigidScene::constants() const
{
	const SceneInfo& info = m_definition.info;
	const WorldConstants& world = m_definition.world;
	const btContactSolverInfo& solver = m_bullet->world.getSolverInfo();
	std::vector<SceneConstant> list = {
		{"world_scale", info.worldScale, ""},
		{"step_size", m_settings.dt, "s"},
		{"tolerance", info.tolerance, "m"},
		{"thinner_wall", info.thinnerWall, "m"},
		{"gravity", kGravity, "m/s^2"},
		{"friction", world.friction, "each body"},
		{"rolling_friction", world.rollingFriction, "m"},
		{"spinning_friction", world.spinningFriction, "m"},
		{"restitution", world.restitution, ""},
		{"margin", world.margin, "m"},
		{"linear_damping", world.linearDamping, ""},
		{"angular_damping", world.angularDamping, ""},
		{"solver_iterations", double(solver.m_numIterations), "at most"},
		{"least_squares_residual", double(solver.m_leastSquaresResidualThreshold), "Bullet's speed squared"},
		{"warmstarting_factor", double(solver.m_warmstartingFactor), ""},
		{"friction_directions", solver.m_solverMode & SOLVER_USE_2_FRICTION_DIRECTIONS ? 2.0 : 1.0, ""},
		{"split_impulse", double(solver.m_splitImpulse), ""},
		{"split_impulse_penetration_threshold", double(solver.m_splitImpulsePenetrationThreshold), "Bullet's length"},
		{"erp", double(solver.m_erp), ""},
		{"erp2", double(solver.m_erp2), ""},
		{"passes", double(m_settings.passes), "at most"},
		{"parts", double(m_settings.parts), "at most"},
		{"at_impacts", double(m_settings.atImpacts), ""},
		{"sleeping", 0, ""}};
	// Bodies of one model weigh the same.
	for (std::size_t model = 0; model < info.models.size(); ++model)
		for (std::size_t i = 0; i < info.bodies.size(); ++i)
		{
			if (info.bodies[i].model != model) continue;
			const BodyDefinition& body = m_definition.bodies[i];
			const char* unit = body.course ? "kg (0: follows a course)" : body.mass > 0 ? "kg" : "kg (0: static)";
			list.push_back({info.models[model].name + "_mass", body.mass, unit});
			break;
		}
	list.insert(list.end(), m_definition.constants.begin(), m_definition.constants.end());
	return list;
}
}  // namespace clod::demo
