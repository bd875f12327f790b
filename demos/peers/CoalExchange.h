// SPDX-License-Identifier: Zlib
// What clod-bench and clod-coal tell each other through two binary files (one machine, one moment: no byte order, no
// version). clod-coal is a program of its own because Coal is an optional peer: nothing else links it.
//
// Request: CoalRequest, then `rows` CoalPose. Answer: CoalBuild, then for every measured row a CoalRow followed by its
// `contacts` CoalContact. Frame: mesh A's; normals point from B to A; unit: the meshes'.
#pragma once
#include <cstdint>

namespace clod::demo
{
struct CoalRequest
{
	std::uint64_t rows = 0;
	double tolerance = 0;           // all contacts: security margin
	double scale = 1;               // lengths are multiplied by this inside: Coal's tolerances are absolute
	std::uint64_t allContacts = 0;  // 0: the closest pair of points at any distance
};
struct CoalPose
{
	double rotation[9] = {};  // rows; meshA = rotation * meshB + translation
	double translation[3] = {};
	std::uint64_t measured = 0;
};
struct CoalBuild
{
	double seconds = 0;  // of both bounding volume hierarchies
	std::uint64_t bytes = 0;
};
struct CoalRow
{
	double microseconds = 0;  // CPU time of the call
	double gap = 0;           // infinity: nothing within the tolerance
	std::uint64_t contacts = 0;
};
struct CoalContact
{
	double point[3], normal[3], distance;
};
}  // namespace clod::demo
