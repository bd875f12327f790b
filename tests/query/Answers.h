// SPDX-License-Identifier: GPL-3.0-or-later
// Answers of queries, compared bit for bit; their certificates, against the truth.
#pragma once
#include <cstring>
#include <limits>
#include <string>

#include "tests/query/Bodies.h"
#include "tests/query/TriangleGap.h"

namespace clod::test
{
struct BodyPair
{
	const Body& a;
	const Body& b;
};

// Without any cache.
inline GapResult fresh(const BodyPair& pair, const Transform& pose, const Settings& settings)
{
	GapCache cache;
	GapResult result;
	query(*pair.a.hierarchy, *pair.b.hierarchy, pose, settings, cache, result);
	return result;
}

inline bool sameBits(const Contact& l, const Contact& r)
{
	const double lv[] = {l.lower,      l.upper,      l.pointOnA.x, l.pointOnA.y, l.pointOnA.z, l.pointOnB.x,
						 l.pointOnB.y, l.pointOnB.z, l.normal.x,   l.normal.y,   l.normal.z};
	const double rv[] = {r.lower,      r.upper,      r.pointOnA.x, r.pointOnA.y, r.pointOnA.z, r.pointOnB.x,
						 r.pointOnB.y, r.pointOnB.z, r.normal.x,   r.normal.y,   r.normal.z};
	return l.nodeA == r.nodeA && l.nodeB == r.nodeB && std::memcmp(lv, rv, sizeof(lv)) == 0;
}

// What differs, or nothing.
inline std::string difference(const GapResult& l, const GapResult& r)
{
	if (l.contacts.size() != r.contacts.size())
		return std::to_string(l.contacts.size()) + " contacts instead of " + std::to_string(r.contacts.size());
	for (std::size_t i = 0; i < l.contacts.size(); ++i)
		if (!sameBits(l.contacts[i], r.contacts[i])) return "contact " + std::to_string(i);
	if (std::memcmp(&l.minDistance, &r.minDistance, sizeof(double)) != 0) return "minDistance";
	if (std::memcmp(&l.errorBound, &r.errorBound, sizeof(double)) != 0) return "errorBound";
	return l.deep != r.deep ? "deep" : "";
}

// What an answer promises of the gap and does not keep, or nothing. Room for the rounding of bodies some cm wide.
inline std::string broken(const GapResult& result, const GapInterval& truth, double tolerance)
{
	if (result.errorBound == std::numeric_limits<double>::infinity()) return {};
	if (result.minDistance == std::numeric_limits<double>::infinity())
		return truth.high > tolerance - result.errorBound - 1e-9 ? "" : "said to be beyond the tolerance";
	if (result.minDistance - result.errorBound > truth.high + 1e-8) return "gap is smaller than certified";
	if (result.minDistance + result.errorBound < truth.low - 1e-8) return "gap is larger than certified";
	return {};
}
}  // namespace clod::test
