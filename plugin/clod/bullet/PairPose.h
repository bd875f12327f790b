// SPDX-License-Identifier: Zlib
// The first step of a dispatch: which two bodies meet, where they are, and how they move in the coming step. A value;
// nothing later changes it.
#pragma once
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <string>

#include "clod/bullet/btClodShape.h"
#include "clod/collide/Sweep.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
enum class Partner
{
	kClod,
	kPlane,
	kConcave,
	kOther
};

struct PairPose
{
	Partner partner = Partner::kOther;
	const btCollisionObjectWrapper* a = nullptr;
	const btCollisionObjectWrapper* b = nullptr;
	const btClodShape* shapeA = nullptr;
	const btClodShape* shapeB = nullptr;  // null where B is no shape of ours; of another scale than A: Partner::kConcave
	Transform worldFromA;                 // world lengths; all else in frame A and the hierarchy's unit
	Transform aFromB;
	PointRules rules;           // with the motion that the solver will start from,
	RelativeMotion seenMotion;  // and that the bodies have: one at rest gains speed from gravity, and loses it again
	double motion = 0;          // bound on the relative motion of the step
	double tolerance = 0;       // contact distance
	std::string notFinite;      // empty, or what is not finite: nothing may be asked then

	bool isAsked() const { return partner != Partner::kOther && notFinite.empty(); }
	bool isOfTwo() const { return partner == Partner::kClod; }
	const Hierarchy& hierarchyA() const { return shapeA->hierarchy(); }
	const Hierarchy& hierarchyB() const { return shapeB->hierarchy(); }  // precondition: isOfTwo()
	double scale() const { return shapeA->scale(); }
	// B's motion relative to A in the step, as far ahead as contacts may lie.
	Sweep sweep() const;
	double thinnestWall() const;
};

// predicts: false answers for the poses as they are. closestPoints: contacts are wanted so far apart, world length.
PairPose poseOf(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				const btDispatcherInfo& info, bool predicts, double closestPoints);
}  // namespace clod
