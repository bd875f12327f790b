// SPDX-License-Identifier: Zlib
// Compounds that have a btClodShape among their children, or meet one. Bullet's own algorithm for compounds tests
// children whose boxes meet where they are now, so a child that crosses a wall within the step is missed. This one
// uses boxes that enclose the children's motion in the step, as Bullet's broadphase does for bodies.
#pragma once
#include <functional>
#include <memory>

#include "clod/Export.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"

class CLOD_API btClodCompoundAlgorithm : public btClodPairAlgorithm
{
public:
	// Makes algorithms for pairs of compounds; those without a shape of ours are left to the dispatcher's
	// configuration. For contactTest and the like (closest points) children are asked where they are.
	static std::unique_ptr<btCollisionAlgorithmCreateFunc> createFunction(btCollisionDispatcher& dispatcher,
																		  ebtDispatcherQueryType query);

	btClodCompoundAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
							const btCollisionObjectWrapper* body1, ebtDispatcherQueryType query);
	~btClodCompoundAlgorithm() override;

	void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
						  const btDispatcherInfo& info, btManifoldResult* out) override;
	// The earliest time of impact of any child.
	btScalar timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info) override;
	btScalar timeOfSwitch(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						  const btDispatcherInfo& info) override;
	// Makes and ends the pairs of children, of theirs, too, for the dispatch that begins, and calls visit(algorithm,
	// body0, body1) for all that it will test.
	using Visit =
		std::function<void(btCollisionAlgorithm&, const btCollisionObjectWrapper&, const btCollisionObjectWrapper&)>;
	void open(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
			  const btDispatcherInfo& info, const Visit& visit);
	void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
	using Time = btScalar (btClodPairAlgorithm::*)(const btCollisionObjectWrapper&, const btCollisionObjectWrapper&,
												   const btDispatcherInfo&);
	btScalar earliest(Time time, const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
					  const btDispatcherInfo& info);
	struct Children;
	std::unique_ptr<Children> m_children;
};
