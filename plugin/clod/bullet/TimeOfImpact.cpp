// SPDX-License-Identifier: Zlib
#include "clod/bullet/TimeOfImpact.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "clod/bullet/BodyState.h"

namespace clod
{
namespace
{
constexpr double kNear = 1e-3;  // of the smaller radius: nearer is met
constexpr int kMostSteps = 64;  // each covers what the gap allows; the last ones creep along a grazing way

// The way of a body, which turns evenly about an axis through its origin; or of a compound's child, which goes with the
// body.
struct Way
{
	btTransform from;
	std::optional<Transform> child;  // in the body
	btVector3 linear, axis;
	btScalar angle = 0;

	explicit Way(const btCollisionObjectWrapper& body) : from(body.getCollisionObject()->getWorldTransform())
	{
		if (body.m_parent) child = inverse(toTransform(from)) * toTransform(body.getWorldTransform());
		const btTransform& to = body.getCollisionObject()->getInterpolationWorldTransform();
		linear = to.getOrigin() - from.getOrigin();
		btTransformUtil::calculateDiffAxisAngle(from, to, axis, angle);
	}
	Transform at(double share) const
	{
		const btQuaternion turn(axis, angle * btScalar(share));
		const Transform body = toTransform(btTransform(turn * from.getRotation(), from.getOrigin() + btScalar(share) * linear));
		return child ? body * *child : body;
	}
	// The distance of the hierarchy's farthest point from the origin that the body turns about; world length.
	double reachOf(const Hierarchy& hierarchy, double scale) const
	{
		return (length(toVec3(hierarchy.asset().sphereCenter)) + double(hierarchy.asset().radius)) * scale +
			   (child ? length(child->translation) : 0);
	}
};

double gapToPlane(const Hierarchy& hierarchy, const Vec3& normal, double offset)
{
	const HullView hull = hierarchy.hull(hierarchy.node(hierarchy.root()));
	double lowest = std::numeric_limits<double>::infinity();
	for (std::uint32_t i = 0; i < hull.count; ++i) lowest = std::min(lowest, dot(normal, hull.vertex(i)) - offset);
	return lowest;
}
}  // namespace

double timeOfImpact(const PairPose& pose, GapCache& cache, GapResult& result)
{
	if (!pose.isOfTwo() && pose.partner != Partner::kPlane) return 1;
	const double scale = pose.scale();
	const Way wayA(*pose.a), wayB(*pose.b);
	double turned = std::abs(double(wayA.angle)) * wayA.reachOf(pose.hierarchyA(), scale);
	if (pose.isOfTwo()) turned += std::abs(double(wayB.angle)) * wayB.reachOf(pose.hierarchyB(), scale);
	// The part of a plane that counts reaches as far as the body that it might meet.
	else if (wayB.angle != 0)
		turned += std::abs(double(wayB.angle)) *
				  (double((wayA.from.getOrigin() - wayB.from.getOrigin()).length()) + double(wayA.linear.length()) +
				   wayA.reachOf(pose.hierarchyA(), scale));
	const double bound = double((wayA.linear - wayB.linear).length()) + turned;
	const double near = kNear * pose.rules.length * scale;
	GapSettings settings;
	settings.metric.exact = true;
	settings.distance = true;
	double share = 0;
	for (int step = 0; step < kMostSteps; ++step)
	{
		const Transform worldFromA = wayA.at(share), worldFromB = wayB.at(share);
		Transform aFromB = inverse(worldFromA) * worldFromB;
		aFromB.translation = (1 / scale) * aFromB.translation;
		double gap = 0;
		if (pose.isOfTwo())
		{
			signedGap(pose.hierarchyA(), pose.hierarchyB(), aFromB, settings, cache, result);
			gap = (result.minDistance - result.errorBound - pose.rules.radiusA - pose.rules.radiusB) * scale;
		}
		else
		{
			const auto& plane = static_cast<const btStaticPlaneShape&>(*pose.b->getCollisionShape());
			const Vec3 local = normalized(toVec3(plane.getPlaneNormal()));
			const Vec3 normal = aFromB.rotation * local;
			const double offset = double(plane.getPlaneConstant()) / scale + dot(normal, aFromB.translation);
			gap = gapToPlane(pose.hierarchyA(), normal, offset) * scale;
		}
		if (gap <= near) return share == 0 ? 1 : share;
		share += std::max(gap - 0.5 * near, 0.5 * near) / std::max(bound, 0.5 * near);
		if (share >= 1) return 1;
	}
	return share;
}
}  // namespace clod
