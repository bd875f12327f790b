// SPDX-License-Identifier: Zlib
// The records of a dual hierarchy, exactly as they lie in memory and in a .clod file of version 1, to which packed ones
// are unpacked. Little-endian, no pointers, explicit zero padding. Reader and writer are HierarchyFile.cpp.
//
// Frame: every coordinate is in the *body frame*: the mesh's own axes, origin moved to the centre of mass
// (Asset::meshFromBody). Unit: the mesh's own (metres for our models). Winding: counter-clockwise from outside.
//
// Levels: level 0 is the input surface, each further level has at most half the patches of the one below. Those without
// kClodNode ("completion", unconstrained merging, paper sec. 4.2) cull but never answer. The last level is one root
// node. Nodes are stored level by level, level 0 first, the root last.
//
// Grid: thicknesses, walls, certified numbers, tolerances, areas, resolutions, feature volumes and the extents of
// culling volumes have 13 significant bits, each rounded to its safe side; centres are multiples of a power of two
// (BoundGrid.h). load() refuses any other.
//
// Based on: Otaduy & Lin, "CLODs: Dual Hierarchies for Multiresolution Collision Detection", SGP 2003, sec. 3.2, 4.
// Departs from it: a node may have several parents (a directed acyclic graph, see Node::primaryChildCount), a culling
// volume is kept beside the contact hull, and three certified numbers (cover, protrude, surf) replace one deviation.
#pragma once
#include <cstdint>

#include "clod/collide/ConvexHull.h"
#include "clod/collide/OrientedBox.h"

namespace clod
{
inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

// One bounding volume = one contact hull = one convex patch of one level of detail (paper: C_{i,j}).
//
// Each has a culling box (OrientedBox, stored beside it). It encloses (a) the input surface the node answers for and
// (b) the thickened contact hulls of every node whose primary chain passes through this node, itself included. Rounded
// outward. The only thing tested when a pair is culled: if two boxes are farther apart than d, nothing below can be
// within d.
//
// Certified numbers, all upper bounds, rounded outward to the grid of BoundGrid.h, measured on the stored vertices,
// monotone (a parent's is at least each child's). O(n) is the part of the input surface that node n answers for.
//   cover    sup over O(n) of the distance to n's own thickened contact hull           (0 at level 0)
//   reach    sup over O(n) of the distance to n's real faces (>= cover)                (0 at level 0)
//   protrude sup over n's thickened contact hull of the distance to the input solid    (~ rounding at level 0)
//   surf     sup over n's real faces of the distance to the input surface              (0 at level 0)
//   deviation  s = max(cover, protrude, surf)                                          (paper: s_a)
// Then, with [lower, upper] a hull distance: true gap >= min over front pairs of (lower - cover_a - cover_b), and
// <= upper + protrude_a + protrude_b of any one pair.
struct Node
{
	std::uint32_t firstChild;      // into children(); the first primaryChildCount of them are the children in the tree
	std::uint16_t childCount;      // 0 exactly at level 0
	std::uint16_t primaryChildCount;  // every node but the root is a primary child of exactly one node: following only
									  // these reaches every node once (a tree). The remaining children are shared: they
									  // answer for input faces that straddle two patches. --paper files have none.
	std::uint32_t firstVertex;     // into hullX/Y/Z (float index, a multiple of kVertexLanes); padded by the last
	std::uint32_t vertexCount;     // without padding; > 0 in every node
	std::uint32_t firstFace;       // into faces()
	std::uint32_t faceCount;       // real faces; 0 exactly in completion nodes (whose hull is of all vertices below)
	std::uint32_t level;           // index into levels()
	std::uint32_t flags;           // kClodNode
	float thickness;               // t >= 0: contact hull = hull(vertices) (+) segment [0, t * inward]
	float inward[3];               // unit vector into the solid
	float cover, reach, protrude, surf;
	float deviation;               // s_a
	float resolution;              // r_a, 1/length, non-increasing to the root; 0 where nothing was collapsed (level 0)
	float featureVolume;           // f_a = s_a / r_a^2; 0 at level 0, +inf in completion nodes
	float contactArea;             // D_a > 0, non-increasing to the root
	float hausdorff;               // h_a: max directed Hausdorff distance of descendants' hulls to it (paper eq. 1)
	float curvature;               // kappa = sum over interior edges of 0.5 * length * signed dihedral / area,
								   // 1/length; > 0 convex. Chooses the reference patch of a contact.
	float meanNormal[3];           // unit, area-weighted over real faces; zero in completion nodes
	float coneCosine;              // min over real faces of dot(face normal, meanNormal); -1 in completion nodes
	std::uint32_t padding[6];      // zero
};
static_assert(sizeof(Node) == 128);
inline constexpr std::uint32_t kClodNode = 1;  // Node::flags: may answer (a contact level of detail)

// One real triangle of one level, owned by one node.
struct Face
{
	std::uint16_t vertex[3];     // local to the node: 0 .. vertexCount-1, counter-clockwise from outside
	std::uint16_t padding;       // zero
	std::uint32_t neighbour[3];  // global face index (same level) across edge (vertex[i], vertex[(i+1)%3])
	float normal[3];             // unit, outward
	float offset;                // max over the three vertices of dot(normal, v), rounded up
	float thickness;             // t_f = min(half the local wall along -normal, 0.03 radius): how deep a contact
								 // point may lie under it and still be this face's; 0 in a stretched body
	std::uint32_t source;        // level 0: index of the triangle in the input mesh; otherwise kNone
};
static_assert(sizeof(Face) == 44);

struct Level
{
	std::uint32_t firstNode, nodeCount;
	std::uint32_t firstFace, faceCount;  // faceCount 0 in completion levels
	std::uint32_t flags;                 // kClodNode: every node of the level may answer
	float maxHausdorff, maxDeviation, maxCover, maxProtrude, maxSurf;
	float patchTolerance;  // eps_k: convexity tolerance that the level was built with
	std::uint32_t padding;
};
static_assert(sizeof(Level) == 48);

// What belongs to the whole asset. Mass properties are for density 1.
struct Asset
{
	double meshFromBody[3];   // p_mesh = p_body + meshFromBody (the centre of mass in the mesh's frame)
	double volume;            // exact volume integrals over the input mesh
	double inertia[6];        // about the centre of mass: xx, yy, zz, xy, xz, yz
	double principal[4];      // quaternion x,y,z,w: p_body = rotate(principal, p_principal)
	double buildSeconds;      // always 0 in the file (same bytes for every run); reserved
	float sphereCenter[3];    // bounding sphere of the input surface, body frame
	float radius;             // of that sphere: "the radius" of every percentage
	float boxMin[3], boxMax[3];   // bounds of every contact hull of every level, body frame, rounded outward
	float storageTolerance;   // eps_0 = 8 * 2^-24 * radius
	float areaTolerance;      // the contact tolerance delta that contactArea was computed with
	float thinnestWall;       // smallest positive local wall thickness met
	std::uint32_t flags;      // kPaperBuild, kScaled
	std::uint32_t triangleCount, componentCount;
	std::uint32_t padding[2];
};
static_assert(sizeof(Asset) == 192);
// Asset::flags: built with --paper (label-inherited tree, no shared children).
inline constexpr std::uint32_t kPaperBuild = 1;
// A point or a segment, the core of a round body; in memory only (ConvexPiece.h): it has no area and no inside.
inline constexpr std::uint32_t kThinCore = 2;
// A built body scaled (ScaledHierarchy.h). What a builder takes by a recipe is a bound here: a thickness is at most
// half a wall, `inward` some direction from the node's faces into the solid; contact areas are those of the built body,
// scaled.
inline constexpr std::uint32_t kScaled = 4;
}  // namespace clod
