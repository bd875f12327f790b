// SPDX-License-Identifier: Zlib
// Who takes part in a trade-off: ours at one ladder of thresholds, and every peer that this machine can run.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "demos/peers/BulletPeers.h"
#include "demos/peers/Preparation.h"
#include "demos/peers/Tradeoff.h"

namespace clod::demo
{
// In the order of tables and plots.
inline constexpr const char* kFamilies[] = {"clod",  "clod-gap", "clod-dispatch", "gimpact",       "bvh-gimpact",
											"vhacd", "coacd",    "coal-distance", "coal-contacts", "decimated-exact"};

struct RosterOptions
{
	std::vector<std::string> families;  // empty: all
	std::vector<int> hullCounts{16, 32, 64, 128, 256, 512, 1024};  // V-HACD, at most
	int decimations = 12;               // versions of each mesh, the full one included
	PairFrame frame;
	std::optional<Threshold> own;  // one more setting of ours, without a label
	bool has(const char* family) const;
};

struct Roster
{
	std::vector<PeerPointer> peers;
	std::vector<LeftOut> leftOut;
	nlohmann::ordered_json preparation;  // decimated meshes and decompositions, with times and deviations
};

// `a` and `b` with the seconds they took to build (NaN: they came from a file or the cache).
struct RosterModels
{
	HierarchyPointer a, b;
	double buildSeconds;
};
Roster makeRoster(const RosterModels& models, HierarchyCache& cache, const Preparation& preparation,
				  const RosterOptions& options, const std::function<void(const std::string&, double)>& progress);

// The hierarchy of a mesh and the seconds its building took (NaN: found in the cache).
struct BuiltHierarchy
{
	HierarchyPointer hierarchy;
	double seconds;
};
BuiltHierarchy buildTimed(HierarchyCache& cache, const MeshSource& source);
}  // namespace clod::demo
