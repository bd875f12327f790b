// SPDX-License-Identifier: Zlib
// From accepted node pairs to the signed gap and its certificate: from the nodes' own proofs, or from the input
// surfaces where those do not tell enough.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/distance/Penetration.h"
#include "clod/distance/SignedGap.h"
#include "clod/distance/SurfaceDistance.h"

namespace clod
{
struct GapCache::Search
{
	SurfaceSearchScratch surfaces;
	PenetrationScratch penetration;
	std::vector<Contact> near;  // the pairs of leaves that an overlap's depth is searched in
};

// What a walk has found besides the contact list.
struct FoundPairs
{
	double largestCover = 0;      // cover_a + cover_b of the accepted pairs that are no contacts, at most
	bool isOfInput = false;       // every accepted pair is of level 0: nothing finer exists
	bool isCoarsened = false;     // for a budget
	double thresholdAtMost = kOff;  // the largest s0 that anything was judged by
};

// Walk: FoundPairs found()      - of the contact list in the result;
//       double depthInside()    - > 0: a point of one body is inside the other by so much; nothing overlaps;
//       bool widenToNearest()   - fills the contact list anew with what is within the distance of the nearest accepted
//                                 pair, `distance` then; false: the walk cannot, the input surfaces are asked.
class GapWalk
{
public:
	virtual ~GapWalk() = default;
	virtual FoundPairs found() const = 0;
	virtual double depthInside() = 0;
	virtual bool widenToNearest(double& distance) = 0;
};

// Sets minDistance, errorBound and deep of a result whose contacts are found and sorted.
CLOD_API void certifyGap(const QueryContext& context, const GapSettings& settings, GapWalk& walk,
						 GapCache::Search& search, GapResult& result);
}  // namespace clod
