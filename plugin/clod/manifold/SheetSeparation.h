// SPDX-License-Identifier: Zlib
// A body apart from triangles near it: how much the two may move before these have to be compared again.
#pragma once
#include <cstdint>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/HullDistance.h"
#include "clod/manifold/PartnerContacts.h"
#include "clod/query/SafeMotion.h"

namespace clod
{
class CLOD_API SheetSeparation
{
public:
	// Nothing is near still of the triangles that the search was made among.
	bool holds(const Hierarchy& hierarchy, const Transform& aFromB, const Metric& metric, double tolerance);
	// Lists those that it was not made among, as others have come near or were edited.
	void listOthers(const NearTriangles& triangles, NearTriangles& others) const;
	// Before a comparison that may find nothing: true if it would not. farthest: more motion than that is of no use.
	bool seek(PartnerContacts& contacts, const Hierarchy& hierarchy, const NearTriangles& triangles, const Transform& aFromB,
			  const Metric& metric, double tolerance, double farthest, PartnerStats& stats);

private:
	RelativePose about(const Hierarchy& hierarchy, const Transform& aFromB) const;

	SafeMotion m_motion;
	Metric m_metric;
	double m_tolerance = 0;
	RelativePose m_pose;   // of the triangles
	Vec3 m_middle;         // about their middle, frame B,
	double m_radius = 0;   // which no corner is farther from
	std::vector<std::uint64_t> m_known;  // hashes of their corners, sorted
};
}  // namespace clod
