// SPDX-License-Identifier: Zlib
// The query: two hierarchies and a relative pose in; accepted node pairs within a tolerance, and statistics, out. The
// signed gap and its certificate: distance/SignedGap.h.
//
// A pure function of the hierarchies, the pose and the settings: PairCache only makes it faster, dropping it changes no
// output bit. Frames: everything is in body A's frame unless named otherwise; aFromB maps body B's frame into A's.
// Normals point from B to A. Distances are signed: negative is penetration. Unit: the meshes' own.
//
// Based on: Otaduy & Lin 2003, sec. 3.3, 5.1, 5.2 (stop rule eq. 2, 3).
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/Sweep.h"
#include "clod/hierarchy/Hierarchy.h"
#include "clod/query/Budget.h"
#include "clod/query/Metric.h"

namespace clod
{
struct ContactSettings
{
	Metric metric;
	double tolerance = 0;  // report accepted pairs whose hull distance is <= tolerance; >= 0
	// Also report pairs that come within the tolerance while B moves on like this (and A stands still). So a caller
	// that simulates steps looks ahead along the motion instead of in all directions. Zero: only the pose counts.
	Sweep sweep;
	// A hard stop: if the budget is spent before everything is answered, the coarsest valid answer is given instead.
	// What that answer takes is held back, so a query exceeds its tests only if the coarsest answer alone does. Which
	// queries are cut off depends on the cache. Usually the metric is coarsened as well (BudgetControl.h).
	Budget budget;
	bool isTrial = false;  // if the budget is spent, give no answer instead of the coarsest
	bool signsOnly = false;  // of contacts only whether their hulls overlap, which takes a fraction of the time
};
// Compares field by field; settings with a function of the user's are never the same, see same(Metric).
CLOD_API bool same(const ContactSettings& l, const ContactSettings& r);

// An accepted node pair within the tolerance.
struct Contact
{
	std::uint32_t nodeA, nodeB;
	// Certified bracket of the thickened hulls' distance; both 0 when they overlap. Of signs only it tells no more: lower
	// is 0 or the least number above, upper 0 or infinity; and the rest is not set.
	double lower, upper;
	Vec3 pointOnA, pointOnB;  // witness points, frame A
	Vec3 normal;              // unit, from B to A; zero when the hulls overlap
};

// The two nodes of a contact. The rest of it is a function of these and the pose, see evaluate().
struct AcceptedPair
{
	std::uint32_t nodeA, nodeB;
};

struct QueryStats
{
	std::uint32_t front = 0;       // leaves of the bounding volume test tree after the query
	std::uint32_t frontInner = 0;  // opened pairs above them
	std::uint32_t boxTests = 0;    // culling boxes compared
	std::uint32_t hullTests = 0;   // hull distances evaluated (GJK runs)
	std::uint32_t skippedBySlack = 0;
	std::uint32_t stillApart = 0;  // 1: the bodies were apart by more than they have moved since; nothing was tested
	std::uint32_t frontKept = 0;   // 1: the last front still had all that is near; only its answers were evaluated
	// Changes of the front: pairs of nodes in its tree that the last query did not have, and the other way round. 0 if
	// the last front still holds.
	std::uint32_t frontCame = 0, frontGone = 0;
	std::uint32_t duplicates = 0;    // pairs reached twice through shared children
	std::uint32_t pointBoxes = 0;    // boxes visited by nearest-surface queries, not counted in boxTests
	std::uint32_t pointQueries = 0;  // nearest-surface queries of the penetration solver
	std::uint32_t finestLevel = 0, coarsestLevel = 0;  // over both bodies' accepted nodes within the tolerance
	std::uint32_t touchedFinestLevel = 0;              // finest level whose node data was read at all
	std::uint32_t pending = 0;   // contacts coarser than the metric asks without its coarsening
	std::uint32_t cutShort = 0;  // 1: the budget was spent, this is the coarsest valid answer, or none (isTrial)
	// 1: the gap was searched in the input surfaces, because nodes overlapped or proved less than asked for
	std::uint32_t gapSearches = 0;
	std::uint32_t depthsCutShort = 0;  // depth searches that reached their limit of cells: the bound may be wider
};

struct ContactSummary
{
	bool deep = false;  // penetration beyond what the contact list can prove
	double excess = 0;  // the factor by which the worst contact exceeds the metric without its coarsening; 0: none does
	QueryStats stats;
};
struct CLOD_API ContactResult : ContactSummary
{
	std::vector<Contact> contacts;  // sorted by (nodeA, nodeB)
	void clear();
};

// What is kept from query to query: front, warm starts, bounds. One for each ordered pair of bodies; destroying it, or
// a query with other hierarchies, resets it.
class CLOD_API PairCache
{
public:
	PairCache();
	~PairCache();
	PairCache(PairCache&&) noexcept;
	PairCache& operator=(PairCache&&) noexcept;
	void clear();
	// Frees its memory; the next query begins afresh.
	void giveBack();
	struct State;  // ContactSearch.h
	State& state() { return *m_state; }

private:
	std::unique_ptr<State> m_state;
};

// Floats hold lengths up to here: of what is farther apart only the distance of the frames is looked at.
inline constexpr double kLongest = 1e37;
CLOD_API bool isBeyondFloats(const Vec3& apart);

// Finds the accepted pairs within the tolerance. `deep` is set only if a component is wholly inside the other body. Two
// bodies apart are not tested again until they have moved enough. Preconditions: the settings are valid (see
// settingsError), the pose is finite and rigid; beyond kLongest nothing is within the tolerance. Allocates nothing once
// the buffers of cache and result have grown.
CLOD_API void contacts(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
					   PairCache& cache, ContactResult& result);

// Fills in everything but the nodes of contacts whose nodes are given: bit for bit what contacts() found at that pose.
CLOD_API void evaluate(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, std::vector<Contact>& contacts);

// The tests that the coarsest valid answer takes: `listing` its pairs took so many now, `answering` them will take at
// most so many. A query with a budget at the same pose need not list them again.
struct Outline
{
	std::uint32_t listing = 0, answering = 0;
};
CLOD_API Outline outlineCoarsest(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
								 const ContactSettings& settings, PairCache& cache);

// For bodies of which only coarse levels were loaded: empty if these may satisfy the metric, otherwise a sentence that
// tells what is missing. Contacts then come from the finest level there is, and `excess` tells by how much they miss
// the metric; neither a gap nor whether one body is inside the other can be found. b is null if it has no hierarchy.
CLOD_API std::string levelsError(const Hierarchy& a, const Hierarchy* b, const Metric& metric);

// Empty when the settings can be used, otherwise one sentence naming the field and its value.
CLOD_API std::string settingsError(const ContactSettings& settings);
}  // namespace clod
