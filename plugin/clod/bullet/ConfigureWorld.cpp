// SPDX-License-Identifier: Zlib
#include "clod/bullet/ConfigureWorld.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clod/bullet/btClodCollisionAlgorithm.h"

namespace clod
{
void configureWorld(btDynamicsWorld& world, const WorldSettings& settings)
{
	btContactSolverInfo& solver = world.getSolverInfo();
	solver.m_numIterations = settings.solverIterations;
	const double change = settings.leastChange * double(world.getGravity().length()) / 240;
	solver.m_leastSquaresResidualThreshold = btScalar(change * change);
	solver.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
	solver.m_splitImpulse = true;
	solver.m_splitImpulsePenetrationThreshold = btScalar(settings.splitImpulsePenetrationThreshold);
	solver.m_warmstartingFactor = btScalar(settings.warmstartingFactor);
	solver.m_erp = btScalar(settings.erp);
	solver.m_erp2 = btScalar(settings.erp2);
}

Result<int> setUpWorld(btDynamicsWorld& world, Context& context, const WorldSettings& settings)
{
	Result<int> registered = btClodCollisionAlgorithm::registerAlgorithm(
		dynamic_cast<btCollisionDispatcher*>(world.getDispatcher()), &context);
	if (registered)
	{
		configureWorld(world, settings);
		context.closedShare = std::max(0.0, 1 - settings.warmstartingFactor);
	}
	return registered;
}

namespace
{
constexpr btScalar kSkew = btScalar(1e-3);  // of a rotation's axes: lengths and angles off by less are rounding
constexpr double kDiagonal = 1e-3;  // of the largest moment: products of inertia below are none

bool isDiagonal(const Asset& asset)
{
	const double* const t = asset.inertia;
	const double mixed = std::max({std::abs(t[3]), std::abs(t[4]), std::abs(t[5])});
	return mixed <= kDiagonal * std::max({t[0], t[1], t[2]});
}

// Empty, or what is wrong with the settings; of the scale the shape tells.
std::string settingsError(const BodySettings& settings)
{
	const std::pair<const char*, double> numbers[] = {
		{"mass", settings.mass}, {"friction", settings.friction}, {"restitution", settings.restitution}};
	for (const auto& [name, number] : numbers)
		if (!(number >= 0) || !std::isfinite(btScalar(number)))
			return std::string(name) + " is " + std::to_string(number) + ", but must be a finite number >= 0";
	const btTransform& pose = settings.worldFromMesh;
	const btMatrix3x3 unit = pose.getBasis() * pose.getBasis().transpose();
	bool isPose = std::isfinite(double(pose.getOrigin().length())) && pose.getBasis().determinant() > 0;
	for (int i = 0; i < 3; ++i) isPose = isPose && (unit[i] - btMatrix3x3::getIdentity()[i]).length() < kSkew;
	return isPose ? "" : "worldFromMesh is not a finite place and a rotation";
}
}  // namespace

Result<std::unique_ptr<ClodBody>> ClodBody::load(const std::string& path, const BodySettings& settings)
{
	const auto hierarchy = Hierarchy::load(path);
	if (!hierarchy) return Error{hierarchy.error()};
	Result<std::unique_ptr<ClodBody>> made = make(hierarchy.value(), settings);
	if (!made) return Error{path + ": " + made.error()};
	made.value()->shape().setName(path);
	return made;
}

Result<std::unique_ptr<ClodBody>> ClodBody::make(const std::shared_ptr<const Hierarchy>& hierarchy,
												 const BodySettings& settings)
{
	if (!hierarchy) return Error{"there is no hierarchy"};
	if (std::string error = settingsError(settings); !error.empty()) return Error{error};
	std::unique_ptr<ClodBody> made(new ClodBody);
	made->m_shape = std::make_unique<btClodShape>(hierarchy);
	made->m_shape->setLocalScaling(settings.scale);
	if (!made->m_shape->scalingError().empty()) return Error{made->m_shape->scalingError()};
	const btClodShape& shape = *made->m_shape;
	const btScalar mass = btScalar(settings.mass);
	btTransform meshFromBody = shape.meshFromBody();
	btVector3 inertia(0, 0, 0);
	btCollisionShape* whole = made->m_shape.get();
	if (mass > 0 && isDiagonal(shape.hierarchy().asset()))
		shape.calculateLocalInertia(mass, inertia);
	else if (mass > 0)
	{
		inertia = shape.principalInertia(mass);
		made->m_compound = std::make_unique<btCompoundShape>();
		made->m_compound->addChildShape(shape.bodyFromPrincipal().inverse(), made->m_shape.get());
		meshFromBody = meshFromBody * shape.bodyFromPrincipal();
		whole = made->m_compound.get();
	}
	made->m_bodyFromMesh = meshFromBody.inverse();
	btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, whole, inertia);
	info.m_startWorldTransform = settings.worldFromMesh * meshFromBody;
	info.m_friction = btScalar(settings.friction);
	info.m_restitution = btScalar(settings.restitution);
	made->m_body = std::make_unique<btRigidBody>(info);
	return made;
}
}  // namespace clod
