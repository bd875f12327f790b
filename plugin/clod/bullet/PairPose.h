// SPDX-License-Identifier: Zlib
// The first step of a dispatch: which two bodies meet, where they are, and how they move in the coming step. A value;
// nothing later changes it.
#pragma once
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clod/bullet/ConvexPartner.h"
#include "clod/bullet/btClodShape.h"
#include "clod/collide/Sweep.h"
#include "clod/manifold/ContactPoints.h"
#include "clod/manifold/SheetSeparation.h"

namespace clod
{
enum class Partner
{
	kClod,
	kConvex,
	kPlane,
	kConcave,
	kOther
};

struct HierarchyPair
{
	std::shared_ptr<const Hierarchy> a, b;
};

// What the bodies are taken to do in the step.
enum class Prediction
{
	kStill,  // nothing: the answer is for the poses as they are
	kFree,   // as they move, with forces and without contacts
	kSolved  // as the step's solver has left them: btClodDynamicsWorld
};

struct PairPose
{
	Partner partner = Partner::kOther;
	Prediction prediction = Prediction::kStill;
	// While the host asks about the pair; what may be needed later is below.
	const btCollisionObjectWrapper* a = nullptr;
	const btCollisionObjectWrapper* b = nullptr;
	const btClodShape* shapeA = nullptr;
	const btClodShape* shapeB = nullptr;  // null where B is no shape of ours
	// As they are asked, in a common unit: that of A's shape, or the world's where two shapes of ours differ in scale.
	HierarchyPair asked;
	double unit = 1;  // world lengths
	std::shared_ptr<const ConvexPartner> convex;  // what B is, where it is a convex shape of Bullet's
	Transform worldFromA;                 // world lengths; all else in frame A and the hierarchy's unit
	Transform aFromB;
	PointRules rules;           // with the motion that the solver will start from,
	RelativeMotion seenMotion;  // and that the bodies have: one at rest gains speed from gravity, and loses it again
	Vec3 center;                // of the smaller body's sphere
	double radius = 0;          // and its
	double motion = 0;          // bound on the relative motion of the step
	double tolerance = 0;       // contact distance
	bool responds = true;       // do contacts push the two apart?
	std::string notFinite;      // empty, or what is not finite: nothing may be asked then

	bool isAsked() const { return partner != Partner::kOther && notFinite.empty(); }
	// Of two hierarchies?
	bool isOfTwo() const { return partner == Partner::kClod || partner == Partner::kConvex; }
	// A body is grown by a radius: certified gaps are of what is not.
	bool isRound() const { return rules.radiusA + rules.radiusB > 0; }
	const Hierarchy& hierarchyA() const { return *asked.a; }
	const Hierarchy& hierarchyB() const { return *asked.b; }  // precondition: isOfTwo()
	double scale() const { return unit; }
	// Units a length of the hierarchy as the user gave it: that of the body scaled least.
	double userLength() const;
	// B's motion relative to A in the step, as far ahead as contacts may lie.
	Sweep sweep() const;
	double thinnestWall() const;
	double usualWall() const;  // what messages go by
	// Looks farther for where a third body may hold one of the two, too (PointRules::heldReach).
	void expectHolding();
	// And where third bodies may carry one of the two (PointRules::shove).
	void expectShove(double way);
	// Looks farther for what a motion meets that is not the one predicted.
	void lookAside(bool carry);
};

// What is near of an engine's mesh. It has no hierarchy, and a program may edit it under the same shape without a word: so
// it is gathered in every dispatch, and its hash tells whether it is as it was.
class NearMesh
{
public:
	struct Gathered
	{
		std::array<btScalar, 3> low{}, high{};  // a box in the mesh's frame, world lengths,
		std::uint64_t hash = 0;                 // and the triangles in there
	};
	NearMesh() = default;
	explicit NearMesh(const Gathered& gathered) : m_gathered(gathered) {}
	const Gathered& gathered() const { return m_gathered; }
	bool isAsItWas(const PairPose& pose) const;
	// Lists the triangles. isAlone: A met none of them last. False if they are not those listed last. isOther: set to
	// whether the mesh itself is another than then, if that is asked by true.
	bool list(const PairPose& pose, bool isAlone, NearTriangles& triangles, bool& isOther);
	// Of those listed, all but what A has moved too little to meet. They serve until the next are asked for.
	const NearTriangles& unknown(const PairPose& pose, const Metric& metric, const NearTriangles& triangles,
								 PartnerContacts& contacts, PartnerStats& stats);
	const std::array<int, 2>& nameOf(std::uint32_t triangle) const { return m_names[triangle]; }

private:
	static Gathered boxOf(const PairPose& pose);
	static Gathered inCells(const PairPose& pose, const Gathered& box);
	static std::uint64_t gather(const PairPose& pose, const Gathered& box);
	Gathered m_gathered;
	std::vector<std::array<int, 2>> m_names;  // part and index of each triangle listed
	SheetSeparation m_separation;
};

// How far, world length, the ball round a body of ours stays from contact with a plane in a step of this motion (of the world's
// material at the body).
double spareOverPlane(const btCollisionObject& body, const btCollisionObject& plane, const RelativeMotion& motion,
					  double timeStep);

// closestPoints: contacts are wanted so far apart, world length.
// known: the pair's convex partner as of the last time, or null.
PairPose poseOf(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				const btDispatcherInfo& info, Prediction prediction, double closestPoints, ConvexPartners& partners,
				const std::shared_ptr<const ConvexPartner>& known);
}  // namespace clod
