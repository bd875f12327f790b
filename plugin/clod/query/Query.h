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
#include <limits>
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
	// Report, besides, pairs that come within the tolerance while B moves on like this (A held): a caller that steps on
	// looks ahead along the motion instead of in all directions. Zero: the pose alone.
	Sweep sweep;
	// Where it is spent before all is answered, the coarsest valid answer is given instead: a hard stop for the rare
	// query, beside a metric coarsened to what the budget buys (BudgetControl.h). What that answer takes is held back: the
	// tests of a query never exceed its budget where they need not. What is cut off depends on the cache.
	Budget budget;
	bool isTrial = false;  // with no answer instead of the coarsest: for the caller who has one
};
// Field by field; with an own function never, see same(Metric).
CLOD_API bool same(const ContactSettings& l, const ContactSettings& r);
CLOD_API bool same(const Transform& l, const Transform& r);

// An accepted node pair within the tolerance.
struct Contact
{
	std::uint32_t nodeA, nodeB;
	double lower, upper;      // certified bracket of the thickened hulls' distance; both 0 when they overlap
	Vec3 pointOnA, pointOnB;  // witness points, frame A
	Vec3 normal;              // unit, from B to A; zero when the hulls overlap
};

// What tells a contact: the rest of it is a function of the two nodes and the pose, see evaluate().
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
	std::uint32_t stillApart = 0;  // 1: the bodies were apart by more than they have moved since; nothing was looked at
	std::uint32_t frontKept = 0;   // 1: no decision of the last traversal has changed; only its answers were evaluated
	// Moves of the front: pairs of nodes kept in its tree that the query before did not keep, and the other way round.
	// None where the last front still holds.
	std::uint32_t frontCame = 0, frontGone = 0;
	std::uint32_t duplicates = 0;    // pairs reached twice through shared children
	std::uint32_t pointBoxes = 0;    // boxes that nearest-surface queries met; boxTests are between the bodies only
	std::uint32_t pointQueries = 0;  // nearest-surface queries of the penetration solver
	std::uint32_t finestLevel = 0, coarsestLevel = 0;  // over both bodies' accepted nodes within the tolerance
	std::uint32_t touchedFinestLevel = 0;              // finest level whose node data was read at all
	std::uint32_t pending = 0;   // contacts coarser than the metric asks without its coarsening
	std::uint32_t cutShort = 0;  // 1: the budget was spent, this is the coarsest valid answer, or none (isTrial)
	// 1: the gap is of the input surfaces, as the nodes overlapped or proved less than asked for
	std::uint32_t gapSearches = 0;
	std::uint32_t depthsCutShort = 0;  // searches of a depth that met their limit of cells: the bound may be wider
};

struct ContactSummary
{
	bool deep = false;  // penetration beyond what the contact list can prove
	double excess = 0;  // by which factor the worst contact exceeds the metric without its coarsening; 0: none does
	QueryStats stats;
};
struct CLOD_API ContactResult : ContactSummary
{
	std::vector<Contact> contacts;  // sorted by (nodeA, nodeB)
	void clear();
};

// Front, warm starts, slack. One per ordered pair of bodies; reset by destroying it or by a query with other
// hierarchies.
class CLOD_API PairCache
{
public:
	PairCache();
	~PairCache();
	PairCache(PairCache&&) noexcept;
	PairCache& operator=(PairCache&&) noexcept;
	void clear();
	// The room that it takes, where it will not be asked for a while: the next query begins afresh.
	void giveBack();
	struct State;  // PairCacheState.h
	State& state() { return *m_state; }

private:
	std::unique_ptr<State> m_state;
};

// The accepted pairs within the tolerance. `deep` tells only of a component wholly inside the other body. Two bodies
// apart are not looked at again until they have moved enough. Preconditions: settings are valid (see settingsError), the
// pose is finite and rigid. No allocation once the buffers of cache and result have grown.
CLOD_API void contacts(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const ContactSettings& settings,
					   PairCache& cache, ContactResult& result);

// Fills in all but the nodes of contacts that are known by these: bit for bit what contacts() found at that pose.
CLOD_API void evaluate(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, std::vector<Contact>& contacts);

// What the coarsest valid answer takes: `listing` the pairs that give it was done now, `answering` them takes so many tests
// at most. A query with a budget at the same pose need not list them again.
struct Outline
{
	std::uint32_t listing = 0, answering = 0;
};
CLOD_API Outline outlineCoarsest(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
								 const ContactSettings& settings, PairCache& cache);

// Of bodies of which coarse levels alone were loaded: empty where what was loaded may do for the metric, otherwise what it
// lacks, a sentence. Contacts are of the finest level there is, whatever is asked for, and `excess` tells by how much they
// miss the metric; neither a gap nor whether one body is inside the other is known then. b: null where it has no hierarchy.
CLOD_API std::string levelsError(const Hierarchy& a, const Hierarchy* b, const Metric& metric);

// Empty when the settings can be used, otherwise one sentence naming the field and its value.
CLOD_API std::string settingsError(const ContactSettings& settings);
}  // namespace clod
