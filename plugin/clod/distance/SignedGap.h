// SPDX-License-Identifier: Zlib
// The signed gap of two bodies and a bound of its error, besides their contacts (query/Query.h, whose conventions
// hold).
//
// gap = the distance of the surfaces if they are apart, else minus the depth of the deepest surface point of either
// body inside the other. Every answer tells how wrong it can be (GapCertificate.h).
#pragma once
#include <memory>

#include "clod/Export.h"
#include "clod/query/Query.h"

namespace clod
{
struct GapSettings : ContactSettings
{
	bool distance = false;  // the gap at any separation (the tolerance then only limits the contact list)
	// The largest error of the gap. If the nodes prove less, or their hulls overlap, the input surfaces are searched.
	// >= 0; infinite: what the nodes prove is enough while none overlap (if contacts are asked for, at least 0.85 of
	// the metric's largest threshold s0). metric.maxError asks for the same of the gap, and for contacts that exact,
	// too.
	double gapError = kOff;
};
CLOD_API bool same(const GapSettings& l, const GapSettings& r);
// Empty when the settings can be used, otherwise one sentence naming the field and its value.
CLOD_API std::string settingsError(const GapSettings& settings);

struct CLOD_API GapResult : ContactResult
{
	double minDistance = std::numeric_limits<double>::infinity();  // signed gap; inf: nothing within the tolerance
	// The true gap differs from minDistance by at most this; if minDistance is inf, the true gap exceeds tolerance -
	// errorBound. inf: nothing is proved.
	double errorBound = 0;
	void clear();
};

// A pair's cache of both entry points.
class CLOD_API GapCache
{
public:
	GapCache();
	~GapCache();
	GapCache(GapCache&&) noexcept;
	GapCache& operator=(GapCache&&) noexcept;
	void clear();
	PairCache pair;
	struct Search;  // GapSearch.h
	Search& search();  // made when a gap is asked for first

private:
	std::unique_ptr<Search> m_search;
};

// Finds contacts as contacts() does, and the gap. Preconditions: the settings are valid, the pose is finite and rigid.
// Cost: that of the contacts if no hulls overlap; otherwise also a search of the input surfaces near the contacts,
// which takes some milliseconds if hundreds of leaves are pressed into each other. Allocates nothing once buffers have
// grown. For bodies of coarse levels alone (Hierarchy::load) only contacts are found, and errorBound is inf.
CLOD_API void signedGap(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const GapSettings& settings,
						GapCache& cache, GapResult& result);
}  // namespace clod
