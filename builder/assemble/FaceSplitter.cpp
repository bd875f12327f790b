// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/FaceSplitter.h"

#include <algorithm>
#include <limits>

namespace clod::builder
{
void FaceSplitter::split(std::uint32_t face, const Triangle& t, const Lookups& at, std::uint32_t preferred,
						 std::vector<Piece>& out)
{
	m_face = face;
	m_normal = areaVector(t);
	m_preferred = preferred;
	m_out = &out;
	m_candidates.clear();
	m_seen.restart(kSide * kSide);
	m_points.clear();
	const Corners corners{0, kSide - 1, (kSide - 1) * kSide};
	for (std::size_t k = 0; k < 3; ++k)
	{
		addPoint(corners[k]);
		m_points.back() = {t[int(k)], at[k], {corners[k], corners[k]}, 0, {}};
	}
	split(corners, 0, Piece::kCodes);
}

void FaceSplitter::split(const Corners& c, std::uint32_t code, std::uint32_t count)
{
	double excess = 0;
	const bool loyal = m_preferred != kNone && excessOf(m_preferred, c, m_rule.loyalty) <= m_rule.loyalty;
	const std::uint32_t owner = loyal ? m_preferred : bestOwner(c, excess);
	const bool isSmall = count <= Piece::kCodes >> (2 * SplitRule::kFirstSplits);
	const double tolerance = isSmall ? m_rule.ofSmall : m_rule.tolerance;
	if (loyal || excess <= tolerance || count == 1 || longestEdge(c) <= m_rule.smallestEdge)
	{
		m_out->push_back({m_face, code, count, owner});
		return;
	}
	const std::uint32_t ab = midpoint(c[0], c[1]), bc = midpoint(c[1], c[2]), ca = midpoint(c[2], c[0]);
	const Corners children[4] = {{c[0], ab, ca}, {ab, c[1], bc}, {ca, bc, c[2]}, {ab, bc, ca}};  // as childTriangle
	for (std::uint32_t k = 0; k < 4; ++k) split(children[k], code + k * (count / 4), count / 4);
}

std::uint32_t FaceSplitter::midpoint(std::uint32_t a, std::uint32_t b)
{
	const std::uint32_t middle = (a / kSide + b / kSide) / 2 * kSide + (a % kSide + b % kSide) / 2;
	if (addPoint(middle))
	{
		const Vec3 p = 0.5 * (pointAt(a).p + pointAt(b).p);
		m_points.back() = {p, m_nearest.at(p, m_normal), {a, b}, 0, {}};
	}
	return middle;
}

bool FaceSplitter::addPoint(std::uint32_t place)
{
	if (!m_seen.add(place)) return false;
	m_numberOf[place] = std::uint32_t(m_points.size());
	m_points.emplace_back();
	return true;
}

double FaceSplitter::longestEdge(const Corners& c) const
{
	const Vec3 &u = pointAt(c[0]).p, &v = pointAt(c[1]).p, &w = pointAt(c[2]).p;
	return std::max({length(v - u), length(w - v), length(u - w)});
}

std::uint32_t FaceSplitter::bestOwner(const Corners& c, double& excess)
{
	std::uint32_t owner = kNone;
	excess = std::numeric_limits<double>::infinity();
	const auto consider = [&](std::uint32_t candidate)
	{
		if (candidate == owner) return;
		const double most = excessOf(candidate, c, excess);
		if (most < excess) excess = most, owner = candidate;
	};
	for (std::size_t k = 0; k < 3 && excess > m_rule.tolerance; ++k) consider(pointAt(c[k]).nearest.patch);
	if (excess > m_rule.tolerance)
		consider(m_nearest.at(centroid({pointAt(c[0]).p, pointAt(c[1]).p, pointAt(c[2]).p}), m_normal).patch);
	return owner;
}

double FaceSplitter::excessOf(std::uint32_t patch, const Corners& c, double limit)
{
	double most = 0;
	for (std::size_t i = 0; i < 3 && most <= limit; ++i)
		if (patch != pointAt(c[i]).nearest.patch) most = std::max(most, excessAt(c[i], patch));
	return most;
}

double FaceSplitter::excessAt(std::uint32_t place, std::uint32_t patch)
{
	Point& point = pointAt(place);
	const std::size_t slot = slotOf(patch);
	if (slot < kRemembered && (point.known >> slot & 1)) return point.excess[slot];
	// No farther than from the points it lies between, and the way from there.
	double limit = std::numeric_limits<double>::infinity();
	for (const std::uint32_t other : point.between)
	{
		const Point& from = pointAt(other);
		const bool isNearest = from.nearest.patch == patch;
		if (!isNearest && (slot >= kRemembered || !(from.known >> slot & 1))) continue;
		const double there = from.nearest.distance + (isNearest ? 0 : from.excess[slot]);
		limit = std::min(limit, (there + length(from.p - point.p)) * (1 + 1e-9) + 1e-300);
	}
	const double excess = m_nearest.distanceTo(patch, point.p, limit) - point.nearest.distance;
	if (slot < kRemembered)
	{
		point.known |= 1u << slot;
		point.excess[slot] = excess;
	}
	return excess;
}

std::size_t FaceSplitter::slotOf(std::uint32_t patch)
{
	const auto found = std::find(m_candidates.begin(), m_candidates.end(), patch);
	const std::size_t slot = std::size_t(found - m_candidates.begin());
	if (found == m_candidates.end()) m_candidates.push_back(patch);
	return slot;
}
}  // namespace clod::builder
