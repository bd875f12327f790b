// SPDX-License-Identifier: Zlib
#include "clod/manifold/ContactReducer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
// Lengths are shares of PointRules::length.
constexpr double kMatchShare = 0.004;    // a point that moved no farther in a step may be the same point
constexpr double kMatchCosine = 0.866;   // of 30 degrees: the most that its normal may have turned
constexpr double kMatchNormal = 0.05;    // the length that a unit of change of the normal counts for in matching,
constexpr double kNormalCounts = 0.25;   // and in the spacing of points
constexpr double kSpacing = 0.02;        // points nearer to each other than this add nothing,
constexpr double kCarrySpacing = 0.002;  // and this is enough where both carry
constexpr std::size_t kMostOfFlat = 8;   // points of a flat, of a body that lies alone
constexpr double kPreferred = 1.1;       // of a flat, a point that goes on counts as so many times farther out,
constexpr double kLowCounts = 10;        // and so does one that is as low as the lowest,
constexpr double kAsLow = 2e-5;          // up to this
constexpr double kOpposing = -0.5;       // cosine of normals that hold from opposing sides,
constexpr double kSoonMet = 0.007;       // of which facets up to this height come before all that are higher
constexpr double kAlike = 0.011;         // normals that are alike (kSameNormal) differ by less in every coordinate

const HeldPoint& pointAt(const ClusterSet& set, std::uint32_t index)
{
	return set.slots[index / kClusterPoints].points[index % kClusterPoints];
}
}  // namespace

void ContactReducer::reduce(const std::vector<Facet>& facets, const std::vector<ContactPoint>& points,
						  const ClusterSet& previous, const PointRules& rules, ClusterSet& next)
{
	m_facets = &facets;
	m_points = &points;
	m_length = rules.length;
	m_most = holdFromOpposingSides() ? kMostPoints : kMostOpen;
	m_candidates.assign(facets.size(), Candidate{});
	match(previous);
	m_isNeeded.assign(facets.size(), 1);
	if (rules.liesAlone) thinOutFlats();
	choose(rules.foundOnce);
	place(previous, next);
}

// Looks for two normals that are far apart: from any, the farthest, and the farthest from that.
bool ContactReducer::holdFromOpposingSides() const
{
	if (m_points->empty()) return false;
	const auto farthestFrom = [this](const Vec3& normal)
	{
		const auto isFarther = [&](const ContactPoint& l, const ContactPoint& r) { return dot(l.normal, normal) < dot(r.normal, normal); };
		return std::min_element(m_points->begin(), m_points->end(), isFarther)->normal;
	};
	const Vec3 first = farthestFrom((*m_points)[0].normal), second = farthestFrom(first);
	return dot(first, second) < kOpposing;
}

// Where two flats lie on each other there is a facet for every corner and every crossing of edges. The outermost of
// them can carry any load that all of them could, so only those are needed; the lowest, which would else be left out
// while the others stand above it. First come three that carry by the pair's own solve, as a body that slides or is tilted
// by next to nothing tips over others within a step.
void ContactReducer::thinOutFlats()
{
	const auto isLower = [&](std::uint32_t i, std::uint32_t j) { return lowest(i) < lowest(j); };
	const auto worthOf = [&](std::uint32_t i)
	{
		const double apart = m_candidates[i].apart * (m_candidates[i].previous == kNone ? 1 : kPreferred);
		return m_candidates[i].isLow ? kLowCounts * apart : apart;
	};
	m_isNeeded.assign(m_candidates.size(), 0);
	m_byNormal.clear();
	for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		if ((*m_facets)[i].hasFeatures()) m_byNormal.push_back({(*m_points)[i].normal.x, i});
	std::sort(m_byNormal.begin(), m_byNormal.end());
	for (std::uint32_t first = 0; first < m_candidates.size(); ++first)
	{
		if (m_candidates[first].isOfFlat) continue;
		const Vec3& normal = (*m_points)[first].normal;
		m_order.assign(1, first);
		for (auto other = std::lower_bound(m_byNormal.begin(), m_byNormal.end(), std::make_pair(normal.x - kAlike, std::uint32_t(0)));
			 other != m_byNormal.end() && other->first <= normal.x + kAlike; ++other)
			if (other->second > first && !m_candidates[other->second].isOfFlat &&
				dot((*m_points)[other->second].normal, normal) >= kSameNormal)
				m_order.push_back(other->second);
		std::sort(m_order.begin(), m_order.end());
		Vec3 middle;
		for (const std::uint32_t i : m_order)
		{
			m_candidates[i].isOfFlat = true;
			middle += (*m_points)[i].pointOnA;
		}
		if (m_order.size() <= kMostOfFlat)
		{
			for (const std::uint32_t i : m_order) m_isNeeded[i] = 1;
			continue;
		}
		middle = (1.0 / double(m_order.size())) * middle;
		for (const std::uint32_t i : m_order) m_candidates[i].apart = length((*m_points)[i].pointOnA - middle) / m_length;
		const std::uint32_t lowestOne = *std::min_element(m_order.begin(), m_order.end(), isLower);
		m_isNeeded[lowestOne] = 1;
		const double low = lowest(lowestOne) + kAsLow * m_length;
		for (const std::uint32_t i : m_order) m_candidates[i].isLow = lowest(i) < low;
		const auto need = [&](std::uint32_t next)
		{
			m_isNeeded[next] = 1;
			m_candidates[next].apart = -1;
			for (const std::uint32_t i : m_order)
				if (m_candidates[i].apart > 0)
					m_candidates[i].apart = std::min(m_candidates[i].apart, distanceBetween(i, next));
		};
		carryLoad();
		for (const std::uint32_t i : m_carrying) need(i);
		for (std::size_t k = m_carrying.size(); k < kMostOfFlat; ++k)
		{
			std::uint32_t next = m_order[0];
			double most = worthOf(next);
			for (const std::uint32_t i : m_order)
				if (const double worth = worthOf(i); worth > most)
				{
					most = worth;
					next = i;
				}
			need(next);
		}
	}
}

// Of the flat in m_order. What carries by the pair's own solve can be three points with the same load at the same place:
// of any four, one gives its load to the others (Caratheodory).
void ContactReducer::carryLoad()
{
	std::array<Load, 4> loads;
	std::size_t count = 0;
	m_carrying.clear();
	for (const bool asNew : {false, true})
		for (const std::uint32_t next : m_order)
		{
			if (isNew(next) != asNew || !((*m_facets)[next].multiplier > 0)) continue;
			loads[count++] = {next, (*m_facets)[next].multiplier};
			if (count < loads.size()) continue;
			const std::size_t freed = unload(loads);
			if (freed == loads.size())
				m_carrying.push_back(loads[--count].candidate);
			else
				loads[freed] = loads[--count];
		}
	for (std::size_t k = 0; k < count; ++k) m_carrying.push_back(loads[k].candidate);
}

// Shifts the loads, whose sum and place stay as they are, until one is none, rather that of a new point. Returns which; 4
// where all are on a line.
std::size_t ContactReducer::unload(std::array<Load, 4>& loads) const
{
	const auto placeOf = [&](std::size_t k) { return (*m_points)[loads[k].candidate].pointOnA; };
	const Vec3& normal = (*m_points)[m_order[0]].normal;
	const auto areaOf = [&](std::size_t i, std::size_t j, std::size_t k)
	{ return dot(normal, cross(placeOf(j) - placeOf(i), placeOf(k) - placeOf(i))); };
	const std::array<double, 4> shift{areaOf(1, 2, 3), -areaOf(0, 2, 3), areaOf(0, 1, 3), -areaOf(0, 1, 2)};
	std::size_t freed = loads.size();
	double by = 0;
	for (const double way : {1.0, -1.0})
	{
		std::size_t first = loads.size();  // to lose its load, shifted this way
		double farthest = std::numeric_limits<double>::infinity();
		for (std::size_t k = 0; k < loads.size(); ++k)
			if (const double lost = -way * shift[k]; lost > 0 && loads[k].load < farthest * lost)
			{
				farthest = loads[k].load / lost;
				first = k;
			}
		if (first == loads.size()) return first;
		if (freed < loads.size() && (isNew(loads[freed].candidate) || !isNew(loads[first].candidate))) continue;
		freed = first;
		by = way * farthest;
	}
	for (std::size_t k = 0; k < loads.size(); ++k) loads[k].load += by * shift[k];
	return freed;
}

double ContactReducer::lowest(std::uint32_t i) const
{
	return std::min((*m_facets)[i].distance, (*m_facets)[i].then);
}

void ContactReducer::match(const ClusterSet& previous)
{
	m_links.clear();
	const double limit = kMatchShare * m_length;
	for (std::uint32_t old = 0; old < previous.slots.size() * kClusterPoints; ++old)
	{
		if (int(old % kClusterPoints) >= previous.slots[old / kClusterPoints].count) continue;
		const ContactPoint& point = pointAt(previous, old).point;
		const Vec3 placeWithB = previous.motionOfB * point.pointOnA;
		const Vec3 normalWithB = previous.motionOfB.rotation * point.normal;
		for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		{
			const ContactPoint& now = (*m_points)[i];
			if (now.feature == point.feature)
			{
				m_links.emplace_back(-1, old, i);
				continue;
			}
			// Most are farther apart along one axis already.
			const auto isFar = [&](const Vec3& p) { return std::abs(now.pointOnA.x - p.x) > limit; };
			if (isFar(point.pointOnA) && isFar(placeWithB)) continue;
			const double place =
				std::min(lengthSquared(now.pointOnA - point.pointOnA), lengthSquared(now.pointOnA - placeWithB));
			if (place > limit * limit) continue;
			const double cosine = std::max(dot(now.normal, point.normal), dot(now.normal, normalWithB));
			if (cosine < kMatchCosine) continue;
			m_links.emplace_back(place + (2 - 2 * cosine) * kMatchNormal * kMatchNormal * m_length * m_length, old, i);
		}
	}
	std::sort(m_links.begin(), m_links.end());
	std::array<bool, kMostPoints> isLinked{};
	for (const auto& [squared, old, i] : m_links)
	{
		Candidate& candidate = m_candidates[i];
		if (isLinked[old] || candidate.previous != kNone) continue;
		isLinked[old] = true;
		candidate.previous = old;
		candidate.weight = std::max(candidate.weight, pointAt(previous, old).impulse);
	}
	for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		m_candidates[i].weight = std::max(m_candidates[i].weight, (*m_facets)[i].multiplier);
}

// How different two points are, in place and normal, as a share of the length.
double ContactReducer::distanceBetween(std::uint32_t i, std::uint32_t j) const
{
	const ContactPoint &a = (*m_points)[i], &b = (*m_points)[j];
	return std::sqrt(lengthSquared(a.pointOnA - b.pointOnA)) / m_length +
		   kNormalCounts * std::sqrt(lengthSquared(a.normal - b.normal));
}

void ContactReducer::take(std::uint32_t i)
{
	m_candidates[i].isChosen = true;
	m_chosen.push_back(i);
	for (std::uint32_t j = 0; j < m_candidates.size(); ++j)
		if (m_isNeeded[j] && !m_candidates[j].isChosen)
			m_candidates[j].apart = std::min(m_candidates[j].apart, distanceBetween(i, j));
}

void ContactReducer::choose(bool foundOnce)
{
	m_chosen.clear();
	m_order.clear();
	for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
	{
		m_candidates[i].apart = std::numeric_limits<double>::infinity();
		if (m_isNeeded[i] && m_candidates[i].weight > 0) m_order.push_back(i);
	}
	std::sort(m_order.begin(), m_order.end(), [this](std::uint32_t i, std::uint32_t j)
			  { return std::tie(m_candidates[j].weight, i) < std::tie(m_candidates[i].weight, j); });
	// Middles first: friction, which is not solved for yet, may turn the bodies so that no other row holds them.
	for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		if ((*m_facets)[i].isOfMiddle()) take(i);
	// The deepest is always taken, whichever points carry: it tells how deep the bodies are.
	std::uint32_t deepest = kNone;
	for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		if (m_isNeeded[i] && (*m_facets)[i].distance < (deepest == kNone ? 0 : (*m_facets)[deepest].distance)) deepest = i;
	const auto takeApart = [&](std::uint32_t i, std::uint32_t most)
	{
		if (m_chosen.size() < most && !m_candidates[i].isChosen && m_candidates[i].apart >= kCarrySpacing) take(i);
	};
	for (const std::uint32_t i : m_order) takeApart(i, deepest == kNone ? m_most : m_most - 1);
	if (deepest != kNone) takeApart(deepest, m_most);
	if (m_most > kMostOpen && foundOnce) spread(true, kSoonMet * m_length);
	spread(false);
	spread(true);
}

// Adds points no higher than that which are farthest from all chosen; the lowest where nothing is chosen yet.
// withPossible: facets that only third bodies may lead to take part, too.
void ContactReducer::spread(bool withPossible, double highest)
{
	while (m_chosen.size() < m_most)
	{
		std::uint32_t best = kNone;
		for (std::uint32_t i = 0; i < m_candidates.size(); ++i)
		{
			if (!m_isNeeded[i] || m_candidates[i].isChosen || m_candidates[i].apart < kSpacing || lowest(i) > highest) continue;
			if (!withPossible && (*m_facets)[i].reach == Facet::Reach::kPossible) continue;
			const auto worth = [this](std::uint32_t k) { return std::make_pair(m_candidates[k].apart, -lowest(k)); };
			if (best == kNone || worth(i) > worth(best)) best = i;
		}
		if (best == kNone) return;
		take(best);
	}
}

// Points that go on stay in their group, which is one Bullet manifold; new ones fill what is free.
void ContactReducer::place(const ClusterSet& previous, ClusterSet& next)
{
	next.slots.clear();
	const auto put = [&](std::uint32_t i, std::size_t slot)
	{
		ContactCluster& cluster = next.slots[slot];
		m_facetOf[slot][std::size_t(cluster.count)] = i;
		HeldPoint& point = cluster.points[std::size_t(cluster.count++)];
		point.point = (*m_points)[i];
		point.previous = m_candidates[i].previous;
		point.impulse = point.previous == kNone ? 0 : pointAt(previous, point.previous).impulse;
	};
	for (const std::uint32_t i : m_chosen)
		if (m_candidates[i].previous != kNone) put(i, m_candidates[i].previous / kClusterPoints);
	std::size_t slot = 0;
	for (const std::uint32_t i : m_chosen)
	{
		if (m_candidates[i].previous != kNone) continue;
		while (next.slots[slot].count == kClusterPoints) ++slot;
		put(i, slot);
	}
}
}  // namespace clod
