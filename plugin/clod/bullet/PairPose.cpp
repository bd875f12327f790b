// SPDX-License-Identifier: Zlib
#include "clod/bullet/PairPose.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clod/bullet/BodyState.h"
#include "clod/hierarchy/ThinnestWall.h"
#include "clod/query/Query.h"

namespace clod
{
namespace
{
constexpr double kSamePlace = 1e-6;  // of the length
constexpr double kAside = 0.4;       // of the way of the step
constexpr double kMeshCell = 0.25;   // of the length: so are the cells a mesh is gathered by
constexpr double kFarFromMesh = 0.25;  // of the length: a distance that takes many dispatches to go
const char* const kNoFloats = "floats cannot hold a body at its scale";

Vec3 sphereCenter(const Hierarchy& hierarchy)
{
	const float* c = hierarchy.asset().sphereCenter;
	return {double(c[0]), double(c[1]), double(c[2])};
}

Partner partnerOf(const btCollisionShape& shape)
{
	if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) return Partner::kPlane;
	if (shape.isConvex()) return Partner::kConvex;
	return shape.isConcave() ? Partner::kConcave : Partner::kOther;
}

// Body A is the one whose content hash is lower, so that Bullet's order of a pair changes nothing but signs.
void chooseBodies(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, PairPose& pose)
{
	const auto clodOf = [](const btCollisionShape& shape)
	{ return shape.isConcave() ? dynamic_cast<const btClodShape*>(&shape) : nullptr; };
	const auto *shape0 = clodOf(*body0.getCollisionShape()), *shape1 = clodOf(*body1.getCollisionShape());
	if (!shape0 && !shape1) return;
	const bool bothClod = shape0 && shape1;
	const bool firstIsA =
		bothClod ? shape0->hierarchy().contentHash() <= shape1->hierarchy().contentHash() : shape0 != nullptr;
	pose.a = firstIsA ? &body0 : &body1;
	pose.b = firstIsA ? &body1 : &body0;
	pose.shapeA = firstIsA ? shape0 : shape1;
	pose.shapeB = firstIsA ? shape1 : shape0;
	pose.partner = bothClod ? Partner::kClod : partnerOf(*pose.b->getCollisionShape());
}

// Chooses the common unit, and the hierarchies that the query is asked about in that unit.
void chooseHierarchies(PairPose& pose, ConvexPartners& partners, const std::shared_ptr<const ConvexPartner>& known)
{
	pose.unit = pose.shapeA->scale();
	pose.asked.a = pose.shapeA->sharedHierarchy();
	if (pose.partner == Partner::kConvex)
	{
		pose.convex = partners.of(static_cast<const btConvexShape&>(*pose.b->getCollisionShape()), pose.unit, known);
		pose.asked.b = pose.convex->hierarchy;
		pose.notFinite = pose.convex->problem;
	}
	if (pose.partner != Partner::kClod) return;
	pose.asked.b = pose.shapeB->sharedHierarchy();
	if (std::abs(pose.shapeA->scale() / pose.shapeB->scale() - 1) < kSameScale) return;
	const HierarchyPair inWorld{pose.shapeA->inWorldLengths(), pose.shapeB->inWorldLengths()};
	if (!inWorld.a || !inWorld.b)
	{
		pose.notFinite = kNoFloats;
		return;
	}
	pose.unit = 1;
	pose.asked = inWorld;
}

// Sets the motion of the step, the resting height and margins, and how far apart bodies may be that need contacts.
void setRules(PairPose& pose, double timeStep, Prediction prediction, double closestPoints)
{
	const btCollisionObject &objectA = *pose.a->getCollisionObject(), &objectB = *pose.b->getCollisionObject();
	const RelativeMotion seenA = worldMotion(objectA, 0), seenB = worldMotion(objectB, 0);
	const auto bodyOf = [&](const btCollisionObject& object, const RelativeMotion& seen)
	{
		if (prediction != Prediction::kSolved)
			return pairBody(object, pose.worldFromA, pose.scale(), worldMotion(object, timeStep), seen);
		const RelativeMotion solved = solvedMotion(object);
		return pairBody(object, pose.worldFromA, pose.scale(), solved, solved);
	};
	PointRules& rules = pose.rules;
	const double scale = pose.scale();
	rules.length = double(pose.hierarchyA().asset().radius);
	if (pose.isOfTwo()) rules.length = std::min(rules.length, double(pose.hierarchyB().asset().radius));
	rules.a = bodyOf(objectA, seenA);
	rules.b = bodyOf(objectB, seenB);
	const auto isAtCenterOfB = [&](const Vec3& place)
	{ return length(pose.aFromB * place - rules.b.center) <= kSamePlace * rules.length; };
	rules.b.isPoint = pose.convex && pose.hierarchyB().node(pose.hierarchyB().root()).vertexCount == 1 &&
					  isAtCenterOfB(sphereCenter(pose.hierarchyB()));
	pose.responds = objectA.hasContactResponse() && objectB.hasContactResponse();
	rules.timeStep = timeStep;
	rules.friction = double(gCalculateCombinedFrictionCallback(&objectA, &objectB));
	pose.seenMotion = relativeMotion(seenA, seenB, pose.worldFromA, scale, timeStep);
	rules.radiusA = double(pose.shapeA->getMargin()) / scale;
	if (pose.shapeB) rules.radiusB = double(pose.shapeB->getMargin()) / scale;
	if (pose.convex) rules.radiusB = pose.convex->radius;
	rules.margin = rules.radiusA + rules.radiusB;
	if (prediction != Prediction::kStill) rules.margin += kSkinShare * rules.length;
	rules.nearest = closestPoints > 0;
	rules.resting = std::max(kRestingShare * rules.length, closestPoints / scale);

	const bool bIsSmaller =
		pose.isOfTwo() && pose.hierarchyB().asset().radius < pose.hierarchyA().asset().radius;
	const Hierarchy& smaller = bIsSmaller ? pose.hierarchyB() : pose.hierarchyA();
	pose.center = bIsSmaller ? pose.aFromB * sphereCenter(smaller) : sphereCenter(smaller);
	pose.radius = double(smaller.asset().radius);
	pose.motion = rules.motion().speedWithin(pose.center, pose.radius) * timeStep;
	// A query of two hierarchies looks ahead along the motion (its sweep). Other shapes are looked for in all
	// directions.
	pose.tolerance = rules.margin + rules.resting;
	if (!pose.isOfTwo()) pose.tolerance += kPathReach * pose.motion;
}

std::string whatIsNotFinite(const PairPose& pose, double timeStep)
{
	const Sweep sweep = pose.sweep();
	if (isFinite(pose.a->getWorldTransform()) && isFinite(pose.b->getWorldTransform()) && isFinite(pose.aFromB) &&
		isFinite(pose.rules.motion()) && !isBeyondFloats(sweep.linear) && !isBeyondFloats(sweep.angular))
		return {};
	for (const btCollisionObjectWrapper* body : {pose.a, pose.b})
	{
		const btCollisionObject& object = *body->getCollisionObject();
		const bool hasPose = isFinite(body->getWorldTransform());
		if (hasPose && isFinite(worldMotion(object, timeStep))) continue;
		return std::string(hasPose ? "the velocity of, or a force on," : "the pose of") + " the body of world index " +
			   std::to_string(object.getWorldArrayIndex()) + " (user index " + std::to_string(object.getUserIndex()) +
			   ") is not finite";
	}
	return "the motion of its bodies relative to each other is not finite, or farther in a step than floats hold";
}
}  // namespace

Sweep PairPose::sweep() const
{
	const RelativeMotion relative = rules.motion();
	const double ahead = -kPathReach * rules.timeStep;
	return {ahead * relative.linear, ahead * relative.angular};
}

// If a third body holds one of the two, the other goes its own way: that differs from the predicted relative motion by
// what the held body would have done.
void PairPose::expectHolding()
{
	const auto wayOf = [&](const PairBody& body)
	{ return (length(body.linear) + length(body.turning()) * rules.length) * rules.timeStep; };
	rules.heldReach = std::min({wayOf(rules.a), wayOf(rules.b), kHeldShare * rules.length});
	tolerance += rules.heldReach;
}

void PairPose::expectShove(double way)
{
	rules.shove = std::min(way, kHeldShare * rules.length);
	tolerance += rules.shove;
}

// Forces count unless the two carry each other, which holds them against these.
void PairPose::lookAside(bool carry)
{
	const RelativeMotion seen =
		rules.b.isPoint ? motionBetween(withoutForces(rules.a), withoutForces(rules.b), 0) : seenMotion;
	const double way = carry ? seen.speedWithin(center, radius) * rules.timeStep : motion;
	tolerance += std::max(0.0, kAside * way - rules.resting);
}

double PairPose::userLength() const
{
	const double ofA = shapeA->leastScale();
	return (shapeB ? std::min(ofA, shapeB->leastScale()) : ofA) / unit;
}

double PairPose::thinnestWall() const
{
	const double wall = double(hierarchyA().asset().thinnestWall);
	return isOfTwo() ? std::min(wall, double(hierarchyB().asset().thinnestWall)) : wall;
}

double PairPose::usualWall() const
{
	const double wall = hierarchyA().derived<UsualWall>().thickness;
	return isOfTwo() ? std::min(wall, hierarchyB().derived<UsualWall>().thickness) : wall;
}

namespace
{
struct GatheredTriangles : btTriangleCallback
{
	std::vector<std::array<btScalar, 9>> corners;  // world lengths
	std::vector<std::array<int, 2>> names;
	void processTriangle(btVector3* triangle, int part, int index) override
	{
		const btVector3 &a = triangle[0], &b = triangle[1], &c = triangle[2];
		corners.push_back({a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), c.x(), c.y(), c.z()});
		names.push_back({part, index});
	}
};
GatheredTriangles& gatheredLast()
{
	thread_local GatheredTriangles gathered;
	return gathered;
}

// May the triangle of these corners have to do with the box?
bool mayMeet(const std::array<btScalar, 9>& corners, const NearMesh::Gathered& box)
{
	for (std::size_t i = 0; i < 3; ++i)
	{
		const auto [least, most] = std::minmax({corners[i], corners[3 + i], corners[6 + i]});
		if (most < box.low[i] || least > box.high[i]) return false;
	}
	return true;
}

bool isSameBox(const NearMesh::Gathered& l, const NearMesh::Gathered& r)
{
	return l.low == r.low && l.high == r.high;
}
}  // namespace

// Round A grown by the tolerance.
NearMesh::Gathered NearMesh::boxOf(const PairPose& pose)
{
	const Transform bFromA = inverse(pose.aFromB);
	btMatrix3x3 turn;
	for (int i = 0; i < 3; ++i) turn[i] = toBullet(bFromA.rotation.row[i]);
	btVector3 low, high;
	pose.shapeA->getAabb(btTransform(turn, toBullet(pose.scale() * bFromA.translation)), low, high);
	const btScalar grow = btScalar(pose.tolerance * pose.scale());
	Gathered box;
	for (std::size_t i = 0; i < 3; ++i)
	{
		box.low[i] = low[int(i)] - grow;
		box.high[i] = high[int(i)] + grow;
	}
	return box;
}

// Grown to where cells end, so that a body that moves little has the same triangles, and these the same surface, in the
// next dispatch.
NearMesh::Gathered NearMesh::inCells(const PairPose& pose, const Gathered& box)
{
	const double cell = kMeshCell * pose.rules.length * pose.scale();
	Gathered grown;
	for (std::size_t i = 0; i < 3; ++i)
	{
		grown.low[i] = btScalar(cell * std::floor(double(box.low[i]) / cell));
		grown.high[i] = btScalar(cell * std::ceil(double(box.high[i]) / cell));
	}
	return grown;
}

std::uint64_t NearMesh::gather(const PairPose& pose, const Gathered& box)
{
	GatheredTriangles& gathered = gatheredLast();
	gathered.corners.clear();
	gathered.names.clear();
	static_cast<const btConcaveShape&>(*pose.b->getCollisionShape())
		.processAllTriangles(&gathered, btVector3(box.low[0], box.low[1], box.low[2]),
							 btVector3(box.high[0], box.high[1], box.high[2]));
	return XXH3_64bits(gathered.corners.data(), gathered.corners.size() * sizeof(gathered.corners[0]));
}

bool NearMesh::isAsItWas(const PairPose& pose) const
{
	return gather(pose, m_gathered) == m_gathered.hash;
}

bool NearMesh::list(const PairPose& pose, bool isAlone, NearTriangles& triangles, bool& isOther)
{
	const bool isAsked = std::exchange(isOther, false);
	triangles.clear();
	const Gathered box = boxOf(pose);
	Gathered now = isAlone ? box : inCells(pose, box);  // alone it needs no surface
	const bool isThere = isSameBox(m_gathered, now);
	if (isAsked && !isThere) isOther = !isAsItWas(pose);
	now.hash = gather(pose, now);
	const bool isSame = isThere && now.hash == m_gathered.hash;
	if (isAsked && isThere) isOther = !isSame;
	m_gathered = now;
	m_names.clear();
	const GatheredTriangles& gathered = gatheredLast();
	for (std::size_t i = 0; i < gathered.corners.size(); ++i)
	{
		const std::array<btScalar, 9>& corners = gathered.corners[i];
		Triangle triangle;
		for (std::size_t c = 0; c < 3; ++c)
			triangle[c] = (1 / pose.scale()) *
						  Vec3{double(corners[3 * c]), double(corners[3 * c + 1]), double(corners[3 * c + 2])};
		if (triangles.add(triangle, mayMeet(corners, box))) m_names.push_back(gathered.names[i]);
	}
	return isSame;
}

const NearTriangles& NearMesh::unknown(const PairPose& pose, const Metric& metric, const NearTriangles& triangles,
									   PartnerContacts& contacts, PartnerStats& stats)
{
	thread_local NearTriangles others;
	const Hierarchy& hierarchy = pose.hierarchyA();
	others.clear();
	if (m_separation.holds(hierarchy, pose.aFromB, metric, pose.tolerance))
		m_separation.listOthers(triangles, others);
	else if (!m_separation.seek(contacts, hierarchy, triangles, pose.aFromB, metric, pose.tolerance,
								kFarFromMesh * pose.rules.length, stats))
		return triangles;
	return others;
}

double spareOverPlane(const btCollisionObject& body, const btCollisionObject& plane, const RelativeMotion& motion,
					  double timeStep)
{
	constexpr double kRounding = 1.001;  // of poses in float
	const auto& shape = static_cast<const btClodShape&>(*body.getCollisionShape());
	const auto& half = static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape());
	const Hierarchy& hierarchy = shape.hierarchy();
	const OrientedBox& whole = hierarchy.cullBox(hierarchy.root());
	const btScalar scale = btScalar(shape.scale());
	const btVector3 middle =
		body.getWorldTransform() * btVector3(scale * whole.center[0], scale * whole.center[1], scale * whole.center[2]);
	const double height =
		double(half.getPlaneNormal().dot(plane.getWorldTransform().invXform(middle)) - half.getPlaneConstant());
	const double ball = shape.scale() * double(whole.radius),
				 touching = (kSkinShare + kRestingShare) * shape.scale() * double(hierarchy.asset().radius);
	const double speed = length(motion.velocity(toVec3(middle))) + length(motion.angular) * ball;
	return height - kRounding * (ball + touching + double(shape.getMargin()) + kPathReach * timeStep * speed);
}

PairPose poseOf(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				const btDispatcherInfo& info, Prediction prediction, double closestPoints, ConvexPartners& partners,
				const std::shared_ptr<const ConvexPartner>& known)
{
	PairPose pose;
	pose.prediction = prediction;
	chooseBodies(body0, body1, pose);
	if (pose.partner == Partner::kOther) return pose;
	chooseHierarchies(pose, partners, known);
	if (!pose.notFinite.empty()) return pose;
	pose.worldFromA = toTransform(pose.a->getWorldTransform());
	pose.aFromB = inverse(pose.worldFromA) * toTransform(pose.b->getWorldTransform());
	pose.aFromB.translation = (1 / pose.scale()) * pose.aFromB.translation;
	const double timeStep = prediction == Prediction::kStill ? 0 : double(info.m_timeStep);
	setRules(pose, timeStep, prediction, closestPoints);
	pose.notFinite = whatIsNotFinite(pose, timeStep);
	return pose;
}
}  // namespace clod
