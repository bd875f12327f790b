// SPDX-License-Identifier: Zlib
// Recorded poses of pairs of bodies, and POSES.csv, the file they travel in. A scene of more than two bodies records a
// row for each pair that is near in a step, with two more columns that say which bodies.
//
// A pose places a *mesh's own frame* (that of the file's vertices) in the world: position in the mesh's unit, unit
// quaternion x, y, z, w. Writing prints the shortest decimals that read back to the same bits.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clod/hierarchy/Result.h"
#include "clod/collide/Vector.h"

namespace clod::demo
{
struct Pose
{
	Vec3 position;
	double quaternion[4] = {0, 0, 0, 1};
};

struct PoseRow
{
	std::int64_t step = 0;
	Pose a, b;
	std::uint32_t bodyA = 0, bodyB = 1;  // of the scene
};

inline constexpr const char* kPosesHeader = "step,ax,ay,az,aqx,aqy,aqz,aqw,bx,by,bz,bqx,bqy,bqz,bqw";
inline constexpr const char* kScenePosesHeader = "step,ax,ay,az,aqx,aqy,aqz,aqw,bx,by,bz,bqx,bqy,bqz,bqw,body_a,body_b";

// Largest | |q| - 1 | that is taken for a rounded unit quaternion; rows within it are normalised.
inline constexpr double kQuaternionTolerance = 1e-4;

// Reads POSES.csv of a scene of `bodies` bodies. The header must be kPosesHeader (two bodies) or kScenePosesHeader
// (more); every further line holds a whole step number >= 0, fourteen finite numbers and, with the longer header, two
// bodies a < b < bodies. Fails with the file's name, line and column otherwise.
Result<std::vector<PoseRow>> readPoses(const std::string& path, std::size_t bodies = 2);
Result<std::vector<PoseRow>> parsePoses(std::string_view text, const std::string& name, std::size_t bodies = 2);
// One row without its bodies and line ending.
std::string formatPose(const PoseRow& row);
std::string formatPoses(const std::vector<PoseRow>& rows, std::size_t bodies = 2);

// worldFromMesh as a rigid transform.
Transform toTransform(const Pose& pose);
// worldFromBody, where a body's frame is the mesh's axes with the origin at meshFromBody of its own mesh.
Transform worldFromBody(const Pose& pose, const Vec3& meshFromBody);
// bodyAFromBodyB.
Transform relativePose(const PoseRow& row, const Vec3& meshFromBodyA, const Vec3& meshFromBodyB);

// Hash (xxh3, 64 bits, as 16 hexadecimal digits) of the poses' bits: equal hashes, equal trajectories.
std::string trajectoryHash(const std::vector<Pose>& poses);
std::string trajectoryHash(const std::vector<PoseRow>& rows);  // of a and b of each row
}  // namespace clod::demo
