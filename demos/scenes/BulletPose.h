// SPDX-License-Identifier: Zlib
// Between poses of meshes, in their unit, and Bullet's transforms of bodies, scaled and centred at the centre of mass.
#pragma once
#include <LinearMath/btTransform.h>

#include "demos/scenes/Poses.h"

namespace clod::demo
{
inline btVector3 toBullet(const Vec3& v, double scale = 1)
{
	return {btScalar(scale * v.x), btScalar(scale * v.y), btScalar(scale * v.z)};
}
inline Vec3 fromBullet(const btVector3& v, double scale = 1)
{
	return {double(v.x()) / scale, double(v.y()) / scale, double(v.z()) / scale};
}

// worldFromBody in Bullet's lengths.
inline btTransform bodyTransform(const Pose& pose, const Vec3& meshFromBody, double worldScale)
{
	const double(&q)[4] = pose.quaternion;
	return btTransform(btQuaternion(btScalar(q[0]), btScalar(q[1]), btScalar(q[2]), btScalar(q[3])),
					   toBullet(toTransform(pose) * meshFromBody, worldScale));
}

// The inverse of bodyTransform, to rounding.
inline Pose meshPose(const btTransform& worldFromBody, const Vec3& meshFromBody, double worldScale)
{
	const btQuaternion q = worldFromBody.getRotation();
	Pose pose{{}, {double(q.x()), double(q.y()), double(q.z()), double(q.w())}};
	const double size = std::sqrt(double(q.x()) * double(q.x()) + double(q.y()) * double(q.y()) +
								  double(q.z()) * double(q.z()) + double(q.w()) * double(q.w()));
	for (double& component : pose.quaternion) component /= size;
	pose.position = fromBullet(worldFromBody.getOrigin(), worldScale) - toTransform(pose).rotation * meshFromBody;
	return pose;
}
}  // namespace clod::demo
