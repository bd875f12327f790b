// SPDX-License-Identifier: Zlib
// Peers that are dispatched by Bullet: our shape, GImpact against itself and against a static triangle mesh, and
// compounds of convex hulls. Bodies move as their rows say. Times are of whole dispatches. Compiled once per Bullet
// precision.
#pragma once
#include "clod/query/Query.h"
#include "demos/models/Models.h"
#include "demos/peers/Peer.h"
#include "demos/peers/Threshold.h"
#include "demos/runner/HierarchyCache.h"

namespace clod::demo
{
// How meshes become bodies: origins are subtracted (mesh frame), then lengths are multiplied. Bullet's constants are
// absolute and suit bodies of about one unit.
struct PairFrame
{
	Vec3 originA, originB;
	double worldScale = 100;
	double tolerance = 0;  // both margins together: contacts appear at this gap; meshes' unit
};
PairFrame pairFrame(const Hierarchy& a, const Hierarchy& b, double worldScale, double tolerance);

PeerPointer clodDispatch(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b,
						 const Threshold& threshold, const PairFrame& frame);
PeerPointer gimpact(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame);
// A is a static btBvhTriangleMeshShape, B a moving btGImpactMeshShape.
PeerPointer bvhGimpact(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame);
// The vertices of each mesh are one btConvexHullShape.
PeerPointer convexHulls(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame);
// Each piece's vertices are one btConvexHullShape of a btCompoundShape.
PeerPointer compounds(PeerInfo info, const std::vector<ModelMesh>& a, const std::vector<ModelMesh>& b,
					  const PairFrame& frame);
}  // namespace clod::demo
