// SPDX-License-Identifier: Zlib
// Coal (the successor of FCL and hpp-fcl) on the same triangles, run by the program clod-coal that scripts/peers
// builds.
#pragma once
#include <string>

#include "demos/peers/Peer.h"
#include "demos/peers/PeerMesh.h"

namespace clod::demo
{
// Coal's tolerances are absolute: `scale` brings the bodies to about one unit, as for Bullet.
enum class CoalQuestion
{
	distance,    // the closest pair of points
	allContacts  // every pair of triangles within the tolerance
};
PeerPointer coal(PeerInfo info, const std::string& program, const MeshPointer& a, const MeshPointer& b,
				 CoalQuestion question, double scale);
}  // namespace clod::demo
