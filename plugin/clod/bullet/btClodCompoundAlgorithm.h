// SPDX-License-Identifier: Zlib
// Compounds that have a btClodShape among their children, or meet one. Bullet's own algorithm for compounds asks children
// whose boxes meet where they are now: what crosses a wall within the step is never asked. This one takes their boxes over
// the step's way, as Bullet's broadphase does for bodies.
#pragma once
#include <functional>
#include <memory>

#include "clod/Export.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"

class CLOD_API btClodCompoundAlgorithm : public btClodPairAlgorithm
{
public:
	// Pairs of other compounds go where the dispatcher's configuration sends them.
	static std::unique_ptr<btCollisionAlgorithmCreateFunc> createFunction(btCollisionDispatcher& dispatcher);

	btClodCompoundAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
							const btCollisionObjectWrapper* body1);
	~btClodCompoundAlgorithm() override;

	void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
						  const btDispatcherInfo& info, btManifoldResult* out) override;
	// Of the first child.
	btScalar timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info) override;
	// visit(algorithm, body0, body1): of all children that the next dispatch will ask, as bodies of their own.
	using Visit = std::function<void(btCollisionAlgorithm&, const btCollisionObjectWrapper&, const btCollisionObjectWrapper&)>;
	void forEachChild(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, const btDispatcherInfo& info,
					  const Visit& visit);
	void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
	struct Children;
	std::unique_ptr<Children> m_children;
};
