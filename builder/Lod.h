// SPDX-License-Identifier: GPL-3.0-or-later
// What passes between the steps of the builder: the mesh, and the sequence of levels of detail with their patches.
//   intake -> Mesh -> (decompose + simplify) -> LodSequence -> (assign, complete, certify, assemble) -> HierarchyContent
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"

namespace clod::builder
{
// Closed oriented 2-manifold triangle mesh in the body frame; coordinates are already rounded to float (stored exactly
// as they will lie in the file) but held in double.
struct Mesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise from outside
};

// One level of detail M_k and its partition into convex patches (paper sec. 3.2).
struct Lod
{
	Mesh mesh;  // vertices rounded to float inside the validity test; no unused vertex
	std::vector<std::uint32_t> patchOfTriangle;  // patch ids 0 .. patchCount-1, every id used
	std::uint32_t patchCount = 0;
	std::vector<double> patchResolution;  // r_a per patch, 1/length (method 2.1); 0 at level 0 and where nothing collapsed
	// Label inheritance: the patch that each patch of the next finer Lod was merged into. Only --paper asks; empty in
	// the first, where patches were grown anew, and in the levels that bridgeCoarseLevels has seen.
	std::vector<std::uint32_t> patchOfChild;
	double patchTolerance = 0;  // eps_k
	double errorLimit = std::numeric_limits<double>::infinity();  // that hulls keep, their thickness included
};

struct LodSequence
{
	std::vector<Lod> lods;  // [0] = the input surface
};

// Where a collapse of the paper's mode first tries to put its vertex. The paper's own is the filter; the others are
// there to be compared with it (patches/README.md).
enum class Placement
{
	filter,         // quadric start, then least second-order differences (Guskov et al. 1999)
	quadric,        // the quadric start itself (Garland & Heckbert 1997)
	probabilistic,  // that of quadrics with uncertain normals (Trettner & Kobbelt 2020)
};

// Every choice of a build. Lengths in per cent are of the bounding radius.
struct BuildConfig
{
	bool paper = false;          // exactly the paper's choices: filtered placement, resolution order, inherited parents
	Placement placement = Placement::filter;  // with paper only
	unsigned threads = 0;        // 0 = all cores; the bytes never depend on it
	double stopDeviation = 0.10;  // default mode: coarsest level's two-sided deviation, share of the radius
	double areaTolerance = 0.01;  // delta of the contact areas, share of the radius
	std::uint64_t seed = 1;      // for the order inside the small QP
};

// Called with a phase name and a fraction in [0,1]; returns false to cancel (the build then throws Cancelled).
using Progress = std::function<bool(const char* phase, double fraction)>;
struct Cancelled {};
inline void report(const Progress& progress, const char* phase, double fraction)
{
	if (progress && !progress(phase, fraction)) throw Cancelled{};
}

// Convex surface decomposition, filtered edge collapses, merging, LOD cuts (paper sec. 4.2; method 1 to 3.2).
LodSequence buildLods(const Mesh& input, const BuildConfig& config, const Progress& progress);
// The same, each level handed over as soon as nothing of it changes any more.
using LodSink = std::function<void(Lod&& lod)>;
void buildLods(const Mesh& input, const BuildConfig& config, const Progress& progress, const LodSink& sink);

// Tree, completion, certified numbers, thickness, areas, culling boxes (assemble/README.md).
HierarchyContent assembleHierarchy(LodSequence lods, const BuildConfig& config, const Progress& progress);

// Both. With several threads fine levels are assembled while coarse ones are still being made.
HierarchyContent buildHierarchy(const Mesh& input, const BuildConfig& config, const Progress& progress);
}  // namespace clod::builder
