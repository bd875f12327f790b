// SPDX-License-Identifier: Zlib
// Are the contact hulls of two nodes farther apart than a limit, now and on B's way in the coming step? From what is
// remembered of the pair where that proves it, else from the canonical start, so that the answer never depends on the
// cache: remembered bounds decide only where they are beyond the limit by more than the accuracy of an evaluation.
#pragma once
#include <optional>

#include "clod/query/Constants.h"
#include "clod/query/PairFront.h"
#include "clod/query/QueryContext.h"

namespace clod
{
// More than the evaluations of a hull distance near the limit can differ by.
inline double roomOf(const QueryContext& context, std::uint32_t a, std::uint32_t b, double limit)
{
	const double size = double(context.a.cullBox(a).radius) + double(context.b.cullBox(b).radius);
	return kEvaluationRoom * (size + limit + context.longestMove) + 4 * context.pose.rounding;
}
// A lower bound of their distance, of whatever axis, shows what an evaluation from the canonical start would.
inline bool isBeyond(const QueryContext& context, std::uint32_t a, std::uint32_t b, double lower, double limit)
{
	return lower > limit + roomOf(context, a, b, limit);
}

// What canonical evaluations of a pair have said of it.
struct HullEvaluations
{
	std::optional<HullDistance> atRest;  // canonicalContact
	std::optional<SweptBound> onTheWay;  // canonicalSweptBound, to either side of the tolerance
};

class HullCull
{
public:
	HullCull(const QueryContext& context, QueryStats& stats) : m_context(context), m_stats(stats) {}

	// The remembered bound alone says so.
	bool isProvenApart(std::uint32_t a, std::uint32_t b, double limit, const CachedSeparation& cached) const
	{
		return cached.isApart() && isBeyond(m_context, a, b, double(cached.lower), limit);
	}
	// As before, or seen along the remembered direction.
	bool isStillApart(std::uint32_t a, std::uint32_t b, double limit, CachedSeparation& cached)
	{
		if (!cached.isApart()) return false;
		if (isProvenApart(a, b, limit, cached))
		{
			++m_stats.skippedBySlack;
			return true;
		}
		const Vec3 axis = cached.axis.get();
		if (axis == Vec3{}) return false;
		++m_stats.hullTests;
		const double lower = sweptSeparationAlong(m_context, a, b, axis);
		if (!isBeyond(m_context, a, b, lower, limit)) return false;
		cached.setApart(lower, axis);
		return true;
	}
	// By corners that were near.
	bool isStillNear(std::uint32_t a, std::uint32_t b, double limit, const CachedSeparation& cached)
	{
		if (cached.kind != CachedSeparation::Kind::kNear) return false;
		const double most = limit - roomOf(m_context, a, b, limit);
		if (!(sweptCornerDistance(m_context, a, b, cached.corners) < most)) return false;
		++m_stats.skippedBySlack;
		return true;
	}
	bool isApart(std::uint32_t a, std::uint32_t b, double limit, CachedSeparation& cached)
	{
		if (isStillNear(a, b, limit, cached)) return false;
		if (isStillApart(a, b, limit, cached)) return true;
		++m_stats.hullTests;
		const SweptBound bound = canonicalSweptBound(m_context, a, b, limit, limit);
		if (bound.lower > limit)
		{
			cached.setApart(bound.lower, bound.normal);
			return true;
		}
		cached = {};
		if (bound.hasPoints) cached.setNear(bound.corners, bound.normal);
		return false;
	}
	// As they are, whatever the sweep; where they stay beyond the tolerance on the way as well, that is remembered.
	// What else had to be evaluated is handed on, as far as a contact needs it.
	bool areApart(std::uint32_t a, std::uint32_t b, double tolerance, CachedSeparation& cached, HullEvaluations& known)
	{
		if (isProvenApart(a, b, 0, cached))
		{
			++m_stats.skippedBySlack;
			return true;
		}
		if (isStillApart(a, b, tolerance, cached)) return true;
		++m_stats.hullTests;
		if (m_context.longestMove > 0)
		{
			known.onTheWay = canonicalSweptBound(m_context, a, b, tolerance, tolerance);
			if (isBeyond(m_context, a, b, known.onTheWay->lower, tolerance))
			{
				cached.setApart(known.onTheWay->lower, known.onTheWay->normal);
				return true;
			}
			++m_stats.hullTests;
		}
		known.atRest = canonicalContact(m_context, a, b, tolerance);
		return known.atRest->lower > 0;
	}

private:
	const QueryContext& m_context;
	QueryStats& m_stats;
};

// Nodes that may answer answer for surface within `cover` of their hulls: where the hulls are farther apart than this,
// nothing that both answer for is within the tolerance, and the pair need not be opened.
inline double cullLimit(const Node& a, const Node& b, double tolerance)
{
	return tolerance + double(a.cover) + double(b.cover);
}
inline bool mayCullByHulls(const Node& a, const Node& b)
{
	return (a.flags & b.flags & kClodNode) != 0;
}
}  // namespace clod
