// SPDX-License-Identifier: Zlib
// The signed gap of two bodies and the proof of it, besides their contacts (query/Query.h, whose conventions hold).
//
// gap = the surfaces' distance where they are apart, else minus the depth of the deepest surface point of either body
// inside the other. Every answer says how wrong it can be (GapCertificate.h).
#pragma once
#include <memory>

#include "clod/Export.h"
#include "clod/query/Query.h"

namespace clod
{
struct GapSettings : ContactSettings
{
	bool distance = false;  // the gap at any separation (the tolerance then only limits the contact list)
	// The gap is known to within so much, whatever answers: where the nodes near prove less, or their hulls overlap, it
	// is that of the input surfaces (their nearest pair, or a depth searched in them). >= 0; infinite: as the nodes prove
	// it where none overlap, with contacts to 0.85 of the metric's largest threshold s0 at least. metric.maxError asks
	// for the same gap, and for contacts as exact besides.
	double gapError = kOff;
};
CLOD_API bool same(const GapSettings& l, const GapSettings& r);
// Empty when the settings can be used, otherwise one sentence naming the field and its value.
CLOD_API std::string settingsError(const GapSettings& settings);

struct CLOD_API GapResult : ContactResult
{
	double minDistance = std::numeric_limits<double>::infinity();  // signed gap; inf: nothing within the tolerance
	double errorBound = 0;  // the true gap is within it of minDistance; with minDistance = inf: true gap > tolerance -
							// errorBound; inf: no proof
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

// Contacts as contacts() finds them, and the gap. Preconditions: settings are valid, the pose is finite and rigid. Cost:
// that of the contacts where no hulls overlap; else a search of the input surfaces near the contacts besides, and some
// milliseconds for a depth where hundreds of leaves are pressed into each other. No allocation once buffers have grown. Of
// bodies of coarse levels alone (Hierarchy::load) the contacts, and of the gap nothing: an errorBound of inf.
CLOD_API void signedGap(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const GapSettings& settings,
						GapCache& cache, GapResult& result);
}  // namespace clod
