// SPDX-License-Identifier: Zlib
#include "clod/manifold/FlatCorners.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
constexpr std::size_t kFew = 4;         // are not worth choosing from
constexpr double kBesideShare = 0.1;    // of the length: so far beside what the corners span a facet may be left out,
constexpr double kBeneathShare = 2e-5;  // and so far beneath it
constexpr double kPreferred = 1.1;      // those that are known may lack less

double cross2(double ax, double ay, double bx, double by)
{
	return ax * by - ay * bx;
}
}  // namespace

// The span is a point, a segment, or a convex polygon.
FlatCorners::Over FlatCorners::over(const Place& p) const
{
	Over nearest;
	nearest.beside = std::numeric_limits<double>::infinity();
	const std::size_t count = m_corners.size();
	bool isInside = count >= 3;
	for (std::size_t i = 0; i < count; ++i)
	{
		const Place &a = m_places[m_corners[i]], &b = m_places[m_corners[(i + 1) % count]];
		const double ex = b.x - a.x, ey = b.y - a.y, px = p.x - a.x, py = p.y - a.y;
		const double square = ex * ex + ey * ey;
		const double share = square > 0 ? std::max(0.0, std::min(1.0, (px * ex + py * ey) / square)) : 0;
		const double beside = std::hypot(px - share * ex, py - share * ey);
		if (beside < nearest.beside)
			nearest = {beside, a.distance + share * (b.distance - a.distance), a.then + share * (b.then - a.then)};
		isInside = isInside && cross2(ex, ey, px, py) >= 0;
	}
	if (!isInside) return nearest;
	const Place& a = m_places[m_corners[0]];
	for (std::size_t i = 1; i + 1 < count; ++i)
	{
		const Place &b = m_places[m_corners[i]], &c = m_places[m_corners[i + 1]];
		const double whole = cross2(b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
		const double ofB = cross2(p.x - a.x, p.y - a.y, c.x - a.x, c.y - a.y),
					 ofC = cross2(b.x - a.x, b.y - a.y, p.x - a.x, p.y - a.y);
		if (!(whole > 0) || (ofB < 0 && i + 2 < count)) continue;
		const double shareB = std::max(0.0, ofB / whole), shareC = std::max(0.0, ofC / whole);
		return {0, a.distance + shareB * (b.distance - a.distance) + shareC * (c.distance - a.distance),
				a.then + shareB * (b.then - a.then) + shareC * (c.then - a.then)};
	}
	return nearest;
}

// > 1: needed.
double FlatCorners::excess(const Place& place, double length) const
{
	const Over at = over(place);
	const double beneath = std::max(at.distance - place.distance, at.then - place.then);
	return (place.isKnown ? kPreferred : 1) * std::max(at.beside / (kBesideShare * length), beneath / (kBeneathShare * length));
}

// The convex polygon of all corners there are (Andrew 1979).
void FlatCorners::addCorner(std::uint32_t place)
{
	m_sorted = m_corners;
	m_sorted.push_back(place);
	std::sort(m_sorted.begin(), m_sorted.end(),
			  [&](std::uint32_t l, std::uint32_t r)
			  {
				  const Place &a = m_places[l], &b = m_places[r];
				  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : l < r;
			  });
	m_corners.clear();
	const auto extend = [&](std::uint32_t next, std::size_t from)
	{
		while (m_corners.size() >= from + 2)
		{
			const Place &a = m_places[m_corners.end()[-2]], &b = m_places[m_corners.end()[-1]], &c = m_places[next];
			if (cross2(b.x - a.x, b.y - a.y, c.x - b.x, c.y - b.y) > 0) break;
			m_corners.pop_back();
		}
		m_corners.push_back(next);
	};
	for (const std::uint32_t next : m_sorted) extend(next, 0);
	const std::size_t turn = m_corners.size() - 1;
	for (std::size_t i = m_sorted.size() - 1; i-- > 0;) extend(m_sorted[i], turn);
	if (m_corners.size() > 1) m_corners.pop_back();
}

void FlatCorners::choose(const std::vector<Facet>& facets, double length, const std::vector<char>& isKnown,
						 std::vector<char>& isNeeded)
{
	constexpr char kUnseen = 2;
	isNeeded.assign(facets.size(), kUnseen);
	for (std::uint32_t first = 0; first < facets.size(); ++first)
	{
		if (isNeeded[first] != kUnseen) continue;
		isNeeded[first] = 1;
		if (!facets[first].hasFeatures()) continue;
		const Vec3 normal = facets[first].normal;
		const Vec3 u = normalized(std::abs(normal.x) < 0.6 ? cross(normal, {1, 0, 0}) : cross(normal, {0, 1, 0}));
		const Vec3 v = cross(normal, u);
		m_places.clear();
		for (std::uint32_t i = first; i < facets.size(); ++i)
		{
			const Facet& f = facets[i];
			if ((i != first && isNeeded[i] != kUnseen) || !f.hasFeatures() || dot(f.normal, normal) < kSameNormal) continue;
			m_places.push_back({dot(u, f.onA - facets[first].onA), dot(v, f.onA - facets[first].onA), f.distance, f.then, i,
								isKnown[i] != 0});
			isNeeded[i] = 0;
		}
		if (m_places.size() <= kFew)
		{
			for (const Place& place : m_places) isNeeded[place.facet] = 1;
			continue;
		}
		m_corners.clear();
		// The first corner is the one farthest from the middle, and from then on what the span lacks most.
		Place middle{};
		for (const Place& place : m_places) middle.x += place.x / double(m_places.size()), middle.y += place.y / double(m_places.size());
		m_places.push_back(middle);
		m_corners.push_back(std::uint32_t(m_places.size() - 1));
		for (bool isFirst = true;; isFirst = false)
		{
			std::uint32_t worst = 0;
			double most = 0;
			for (std::uint32_t i = 0; i + 1 < m_places.size(); ++i)
			{
				if (isNeeded[m_places[i].facet]) continue;
				const double lacks = isFirst ? (m_places[i].isKnown ? kPreferred : 1) * (1 + over(m_places[i]).beside)
											 : excess(m_places[i], length);
				if (lacks > most) most = lacks, worst = i;
			}
			if (!isFirst && most <= 1) break;
			isNeeded[m_places[worst].facet] = 1;
			if (isFirst) m_corners.clear();
			addCorner(worst);
		}
	}
}
}  // namespace clod
