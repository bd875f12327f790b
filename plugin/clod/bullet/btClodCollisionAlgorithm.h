// SPDX-License-Identifier: Zlib
// What Bullet holds of a pair with at least one btClodShape: a small object with its state behind one pointer, because
// Bullet's pool does not check sizes.
#pragma once
#include <BulletCollision/CollisionDispatch/btActivatingCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <memory>

#include "clod/Export.h"
#include "clod/bullet/Context.h"
#include "clod/bullet/btClodShape.h"
#include "clod/hierarchy/Result.h"

namespace clod
{
class PairState;
}  // namespace clod

// What Bullet asks of a pair of bodies, and a compound of each pair of its children.
class CLOD_API btClodPairAlgorithm : public btActivatingCollisionAlgorithm
{
public:
	using btActivatingCollisionAlgorithm::btActivatingCollisionAlgorithm;
	// The time of impact, 0 to 1, on the two bodies' way to their interpolation transforms (TimeOfImpact.h). Contacts
	// do not need it, because they look ahead over a step themselves.
	btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& info,
								   btManifoldResult* out) override;
	virtual btScalar timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
								  const btDispatcherInfo& info) = 0;
	// Of one that a change of level brings, with the bodies at the end of their way: PairState::timeOfSwitch.
	virtual btScalar timeOfSwitch(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
								  const btDispatcherInfo& info) = 0;
};

class CLOD_API btClodCollisionAlgorithm : public btClodPairAlgorithm
{
public:
	// Registers the shape type `shapeType` against itself, static planes and Bullet's convex and concave shapes, in
	// both dispatch tables and both orders, and for compounds that have such a child or meet one
	// (btClodCompoundAlgorithm.h). Soft bodies keep Bullet's entries, which call processAllTriangles. Call it before
	// the first pair exists and after any other registration. The context must outlive the dispatcher's pairs; several
	// dispatchers may share one. A shape type is concave, and none by which Bullet knows a class of its own (plane,
	// triangle mesh, scaled one, heightfield). Returns how many pairs of shape types were set.
	static clod::Result<int> registerAlgorithm(btCollisionDispatcher* dispatcher, clod::Context* context,
											   int shapeType = FAST_CONCAVE_MESH_PROXYTYPE);

	btClodCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
							 const btCollisionObjectWrapper* body1, clod::Context& context, bool isClosestPoints);
	~btClodCollisionAlgorithm() override;

	void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
						  const btDispatcherInfo& info, btManifoldResult* out) override;
	btScalar timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info) override;
	btScalar timeOfSwitch(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info) override;
	clod::PairState& state() { return *m_state; }
	void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
	void askOther(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				  const btDispatcherInfo& info, btManifoldResult& out);
	void releaseOther();
	std::unique_ptr<clod::PairState> m_state;
	// Bullet calls a pair's algorithm as long as the pair lives, even after setCollisionShape. If no shape of ours is
	// left, the pair is handed to the algorithm that Bullet has for it.
	btCollisionAlgorithm* m_other = nullptr;
	const btCollisionShape *m_otherShape0 = nullptr, *m_otherShape1 = nullptr;  // the shapes that m_other is for
};
