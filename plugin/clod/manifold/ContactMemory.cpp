// SPDX-License-Identifier: Zlib
// Finds, makes and claims the candidates that continue old points. Ties fall to the lower index everywhere.
#include "clod/manifold/ContactMemory.h"

#include <algorithm>
#include <limits>

namespace clod
{
namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

int ClusterSet::pointCount() const
{
	int count = 0;
	for (const ContactCluster& cluster : slots) count += cluster.count;
	return count;
}

void carryWithB(ClusterSet& set, const Transform& bodyMotion)
{
	for (ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
		{
			ClusterPoint& old = cluster.points[std::size_t(i)];
			// Compared with points on A, so the gap between the surfaces is kept along the normal.
			old.normalWithB = bodyMotion.rotation * old.point.normal;
			old.placeWithB = bodyMotion * old.point.pointOnA;
		}
}

// Places by slabs along each axis, wrapped round.
void ContactMemory::PlaceSlabs::start(double limit)
{
	m_limit = limit;
	m_bits = {};
}

std::int64_t ContactMemory::PlaceSlabs::slabOf(double x) const
{
	const double slab = x / m_limit;
	const std::int64_t whole = std::int64_t(slab);
	return whole - (slab < double(whole) ? 1 : 0);
}

void ContactMemory::PlaceSlabs::add(std::uint32_t bit, const Vec3& place)
{
	const double reach = 1.001 * m_limit;  // rounding included
	for (int axis = 0; axis < 3; ++axis)
	{
		const std::int64_t first = slabOf(place[axis] - reach), last = slabOf(place[axis] + reach);
		for (std::int64_t i = first; i <= last; ++i)
			m_bits[std::size_t(axis)][std::size_t(i & (kCount - 1))] |= 1U << bit;
	}
}

std::uint32_t ContactMemory::PlaceSlabs::near(const Vec3& place) const
{
	const auto bits = [&](std::size_t axis, double x) { return m_bits[axis][std::size_t(slabOf(x) & (kCount - 1))]; };
	return bits(0, place.x) & bits(1, place.y) & bits(2, place.z);
}

// Squared: how far the point is from the old one, on A or on B, turned normals counted as length; infinite when too
// far.
double ContactMemory::mismatch(const ClusterPoint& old, const ContactPoint& point) const
{
	const double weight = m_rules.matchNormal * m_rules.length;
	double best = kInfinity;
	const auto compare = [&](const Vec3& place, const Vec3& normal)
	{
		const double placeSquared = lengthSquared(point.pointOnA - place);
		if (placeSquared > limit() * limit() || dot(point.normal, normal) < m_rules.matchCosine) return;
		best = std::min(best, placeSquared + weight * weight * lengthSquared(point.normal - normal));
	};
	compare(old.point.pointOnA, old.point.normal);
	compare(old.placeWithB, old.normalWithB);
	return best;
}

bool ContactMemory::wasInTouch(const ClusterPoint& old) const
{
	return old.impulse > 0 || old.point.height <= m_rules.tolerance * m_rules.length;
}

// Compares the candidates that have come with the old points.
void ContactMemory::admit()
{
	const double most = limit() * limit();
	for (; m_admitted < m_pool->points().size(); ++m_admitted)
	{
		if (m_pool->isDropped(m_admitted)) continue;
		const ContactPoint& point = m_pool->points()[m_admitted];
		for (std::uint32_t bits = m_slabs.near(point.pointOnA); bits != 0; bits &= bits - 1)
		{
			const std::uint32_t old = std::uint32_t(__builtin_ctz(bits));
			const double squared = mismatch(oldPoint(old), point);
			if (squared < most) m_matches[old].push_back({squared, m_admitted});
		}
	}
}

// The nearest candidate that is not taken, kNone where there is none.
std::uint32_t ContactMemory::nearestKnown(std::uint32_t old)
{
	admit();
	double best = kInfinity;
	std::uint32_t nearest = kNone;
	for (const Match& match : m_matches[old])
	{
		if (!(match.squared < best) || isTaken(match.candidate)) continue;
		best = match.squared;
		nearest = match.candidate;
	}
	return nearest;
}

// Makes the candidates near where an old point would be had it moved with the body that was clipped, not with the
// reference: more often than not it is a corner of that body.
void ContactMemory::searchFor(const ClusterPoint& old)
{
	const Vec3& place = old.point.referenceIsA ? old.placeWithB : old.point.pointOnA;
	const Vec3& normal = old.point.referenceIsA ? old.normalWithB : old.point.normal;
	const double within = m_rules.searchRadius * m_rules.length;
	const double withinOther = within + m_rules.tolerance * m_rules.length;
	// The surfaces were expected so far apart by now, unless they have stopped each other.
	const double apart = m_rules.margin + std::max(old.point.predicted, std::min(old.point.height, 0.0));
	const PointClipper::Near near{place, place - apart * normal, within, withinOther, limit()};
	for (std::uint32_t i = 0; i < m_pool->pairs().size(); ++i)
	{
		const PairEstimate& pair = m_pool->pairs()[i];
		const double reach = pair.radius + withinOther;
		if (m_pool->isClipped(i) || lengthSquared(pair.center - place) > reach * reach) continue;
		if (m_pool->isNear(i, near)) m_pool->clip(i, &near);
	}
}

// Of the candidates that are there; where there is none, of those that are made now. Points that were only expected to
// touch, and did not, are not looked for.
std::uint32_t ContactMemory::nearestTo(std::uint32_t old)
{
	const std::uint32_t nearest = nearestKnown(old);
	const ClusterPoint& point = oldPoint(old);
	if (nearest != kNone || m_isSearched[old] || !wasInTouch(point)) return nearest;
	m_isSearched[old] = true;
	searchFor(point);
	return nearestKnown(old);
}

void ContactMemory::start(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules)
{
	m_pool = &pool;
	m_previous = &previous;
	m_rules = rules;
	m_slabs.start(limit());
	m_admitted = 0;
	for (std::vector<Match>& matches : m_matches) matches.clear();
	m_isSearched = {};
	m_taken.clear();
	forEachOld(
		[&](std::uint32_t old)
		{
			m_slabs.add(old, oldPoint(old).point.pointOnA);
			m_slabs.add(old, oldPoint(old).placeWithB);
			pool.clipAsBefore(oldPoint(old).point);
		});
	forEachOld([&](std::uint32_t old) { nearestTo(old); });
}

void ContactMemory::take(std::uint32_t candidate)
{
	if (candidate >= m_taken.size()) m_taken.resize(candidate + 1, 0);
	m_taken[candidate] = 1;
}

void ContactMemory::remember(int slot, double spacing, ChosenPoints& kept)
{
	const ContactCluster& old = m_previous->slots[std::size_t(slot)];
	const auto impulseOf = [&old](int i) { return old.points[std::size_t(i)].impulse; };
	// Insertion sort: strong points first, of equal ones the first.
	std::array<int, kClusterPoints> order{};
	for (int i = 0; i < old.count; ++i)
	{
		int at = i;
		for (; at > 0 && impulseOf(order[std::size_t(at - 1)]) < impulseOf(i); --at)
			order[std::size_t(at)] = order[std::size_t(at - 1)];
		order[std::size_t(at)] = i;
	}
	for (int i = 0; i < old.count; ++i)
	{
		const std::uint32_t match = nearestTo(std::uint32_t(slot * kClusterPoints + order[std::size_t(i)]));
		if (match == kNone) continue;
		const Vec3& place = m_pool->points()[match].pointOnA;
		const bool crowded = std::any_of(kept.begin(), kept.end(),
										 [&](std::uint32_t other)
										 { return length(m_pool->points()[other].pointOnA - place) < spacing; });
		if (crowded) continue;  // remembered points that drifted together hold nothing
		take(match);
		kept.push(match);
	}
}

void ContactMemory::link(ClusterSet& next)
{
	m_links.clear();
	for (std::uint32_t i = 0; i < kMostPoints; ++i)
	{
		const ContactCluster& to = next.slots[i / kClusterPoints];
		if (int(i % kClusterPoints) >= to.count) continue;
		const ContactPoint& newPoint = to.points[i % kClusterPoints].point;
		forEachOld(
			[&](std::uint32_t old)
			{
				const double squared = mismatch(oldPoint(old), newPoint);
				if (squared < kInfinity) m_links.push_back({squared, old, i});
			});
	}
	std::sort(m_links.begin(), m_links.end());
	std::array<bool, kMostPoints> claimed{};
	for (const Link& pair : m_links)
	{
		ClusterPoint& point = next.slots[pair.to / kClusterPoints].points[pair.to % kClusterPoints];
		if (claimed[pair.from] || point.previous != kNone) continue;
		claimed[pair.from] = true;
		point.previous = pair.from;
		point.impulse = oldPoint(pair.from).impulse;
	}
}
}  // namespace clod
