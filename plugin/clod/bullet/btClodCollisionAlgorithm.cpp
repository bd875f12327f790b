// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodCollisionAlgorithm.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <LinearMath/btPoolAllocator.h>
#include <LinearMath/btQuickprof.h>

#include <new>
#include <utility>

#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodCompoundAlgorithm.h"

namespace
{
struct CreateFunction : btCollisionAlgorithmCreateFunc
{
	clod::Context& context;
	bool isClosestPoints;
	CreateFunction(clod::Context& c, bool closest) : context(c), isClosestPoints(closest) {}
	btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
												   const btCollisionObjectWrapper* body0,
												   const btCollisionObjectWrapper* body1) override
	{
		void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btClodCollisionAlgorithm));
		return new (memory) btClodCollisionAlgorithm(info, body0, body1, context, isClosestPoints);
	}
};

// Types this algorithm takes over against its own. Bullet's entry for EMPTY does nothing and stays; the number of
// btSdfCollisionShape is also the one programs use for their own concave shapes, which give triangles as all others do.
bool isMesh(int type)
{
	return btBroadphaseProxy::isConcave(type) && type != EMPTY_SHAPE_PROXYTYPE;
}
bool takesOver(int type)
{
	return isMesh(type) || btBroadphaseProxy::isConvex(type);
}

// Types by which Bullet takes a shape for one of its own classes, as when it follows a ray.
bool isBulletsOwn(int type)
{
	return type == STATIC_PLANE_PROXYTYPE || type == TRIANGLE_MESH_SHAPE_PROXYTYPE ||
		   type == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE || type == TERRAIN_SHAPE_PROXYTYPE;
}

std::string reasonAgainst(btCollisionDispatcher* dispatcher, const clod::Context* context, int shapeType)
{
	if (!dispatcher) return "registerAlgorithm: the dispatcher is null";
	if (!context) return "registerAlgorithm: the context is null";
	if (!isMesh(shapeType) || isBulletsOwn(shapeType))
		return "registerAlgorithm: shape type " + std::to_string(shapeType) +
			   " is not a concave type, or one by which Bullet knows a class of its own";
	const bool isDouble = sizeof(btScalar) == sizeof(double);
	if (bool(btIsDoublePrecision()) != isDouble) return "registerAlgorithm: Bullet and this plugin differ in precision";
	const int room = dispatcher->getCollisionConfiguration()->getCollisionAlgorithmPool()->getElementSize();
	if (room < int(sizeof(btClodCollisionAlgorithm)))
		return "registerAlgorithm: the pool's elements hold " + std::to_string(room) + " bytes, " +
			   std::to_string(sizeof(btClodCollisionAlgorithm)) + " are needed";
	return "";
}

bool isGhost(const btCollisionObjectWrapper& body)
{
	return dynamic_cast<const btPairCachingGhostObject*>(body.getCollisionObject()) != nullptr;
}
}  // namespace

btClodCollisionAlgorithm::btClodCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
												   const btCollisionObjectWrapper* body0,
												   const btCollisionObjectWrapper* body1, clod::Context& context,
												   bool isClosestPoints)
	: btClodPairAlgorithm(info, body0, body1),
	  m_state(std::make_unique<clod::PairState>(
		  context, *info.m_dispatcher1, info.m_manifold, isClosestPoints,
		  isClosestPoints ? nullptr : context.budgetOf(*info.m_dispatcher1, isGhost(*body0) || isGhost(*body1)),
		  *body0->getCollisionObject(), *body1->getCollisionObject()))
{
}

btClodCollisionAlgorithm::~btClodCollisionAlgorithm()
{
	releaseOther();
}

void btClodCollisionAlgorithm::processCollision(const btCollisionObjectWrapper* body0,
												const btCollisionObjectWrapper* body1, const btDispatcherInfo& info,
												btManifoldResult* out)
{
	BT_PROFILE("btClodCollisionAlgorithm::processCollision");
	if (m_state->process(*body0, *body1, info, *out))
		releaseOther();
	else
		askOther(*body0, *body1, info, *out);
}

void btClodCollisionAlgorithm::askOther(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
										const btDispatcherInfo& info, btManifoldResult& out)
{
	const btCollisionShape *shape0 = body0.getCollisionShape(), *shape1 = body1.getCollisionShape();
	if (shape0 != m_otherShape0 || shape1 != m_otherShape1)
	{
		releaseOther();
		m_other = m_dispatcher->findAlgorithm(&body0, &body1, nullptr, BT_CONTACT_POINT_ALGORITHMS);
		m_otherShape0 = shape0;
		m_otherShape1 = shape1;
	}
	// One of these has been asked already: a shape under our type that is none of ours.
	if (m_other && !dynamic_cast<btClodCollisionAlgorithm*>(m_other)) m_other->processCollision(&body0, &body1, info, &out);
}

void btClodCollisionAlgorithm::releaseOther()
{
	m_otherShape0 = m_otherShape1 = nullptr;
	if (!m_other) return;
	m_other->~btCollisionAlgorithm();
	m_dispatcher->freeCollisionAlgorithm(std::exchange(m_other, nullptr));
}

btScalar btClodPairAlgorithm::calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
													const btDispatcherInfo& info, btManifoldResult*)
{
	const btCollisionObjectWrapper first(nullptr, body0->getCollisionShape(), body0, body0->getWorldTransform(), -1, -1);
	const btCollisionObjectWrapper second(nullptr, body1->getCollisionShape(), body1, body1->getWorldTransform(), -1, -1);
	return timeOfImpact(first, second, info);
}

btScalar btClodCollisionAlgorithm::timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
												const btDispatcherInfo& info)
{
	return btScalar(m_state->timeOfImpact(body0, body1, info));
}

btScalar btClodCollisionAlgorithm::timeOfSwitch(const btCollisionObjectWrapper& body0,
												const btCollisionObjectWrapper& body1, const btDispatcherInfo& info)
{
	return btScalar(m_state->timeOfSwitch(body0, body1, info));
}

void btClodCollisionAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
	m_state->append(manifolds);
	if (m_other) m_other->getAllContactManifolds(manifolds);
}

clod::Result<int> btClodCollisionAlgorithm::registerAlgorithm(btCollisionDispatcher* dispatcher, clod::Context* context,
															  int shapeType)
{
	const std::string reason = reasonAgainst(dispatcher, context, shapeType);
	if (!reason.empty()) return clod::Error{reason};
	auto contacts = std::make_unique<CreateFunction>(*context, false);
	auto closestPoints = std::make_unique<CreateFunction>(*context, true);
	auto compounds = btClodCompoundAlgorithm::createFunction(*dispatcher, BT_CONTACT_POINT_ALGORITHMS);
	auto closestOfCompounds = btClodCompoundAlgorithm::createFunction(*dispatcher, BT_CLOSEST_POINT_ALGORITHMS);
	for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; ++type)
	{
		if (type != COMPOUND_SHAPE_PROXYTYPE && (!takesOver(type))) continue;
		dispatcher->registerCollisionCreateFunc(COMPOUND_SHAPE_PROXYTYPE, type, compounds.get());
		dispatcher->registerCollisionCreateFunc(type, COMPOUND_SHAPE_PROXYTYPE, compounds.get());
		dispatcher->registerClosestPointsCreateFunc(COMPOUND_SHAPE_PROXYTYPE, type, closestOfCompounds.get());
		dispatcher->registerClosestPointsCreateFunc(type, COMPOUND_SHAPE_PROXYTYPE, closestOfCompounds.get());
	}
	int count = 0;
	for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; ++type)
	{
		if (!takesOver(type)) continue;
		dispatcher->registerCollisionCreateFunc(shapeType, type, contacts.get());
		dispatcher->registerCollisionCreateFunc(type, shapeType, contacts.get());
		dispatcher->registerClosestPointsCreateFunc(shapeType, type, closestPoints.get());
		dispatcher->registerClosestPointsCreateFunc(type, shapeType, closestPoints.get());
		++count;
	}
	clod::Context::noteRegistration();
	const std::lock_guard<std::mutex> lock(context->m_mutex);
	context->m_createFunctions.push_back(std::move(compounds));
	context->m_createFunctions.push_back(std::move(closestOfCompounds));
	context->m_createFunctions.push_back(std::move(contacts));
	context->m_createFunctions.push_back(std::move(closestPoints));
	return count;
}
