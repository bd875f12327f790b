// SPDX-License-Identifier: Zlib
// Matches, seeds, chooses and links contact points, and clips pairs of nodes on the way. Ties fall to the lower index
// everywhere.
#include "clod/query/ContactClusters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
void ContactReducer::PlaceSlabs::start(double limit)
{
	m_limit = limit;
	m_bits = {};
}

std::int64_t ContactReducer::PlaceSlabs::slabOf(double x) const
{
	const double slab = x / m_limit;
	const std::int64_t whole = std::int64_t(slab);
	return whole - (slab < double(whole) ? 1 : 0);
}

void ContactReducer::PlaceSlabs::add(std::uint32_t bit, const Vec3& place)
{
	const double reach = 1.001 * m_limit;  // rounding included
	for (int axis = 0; axis < 3; ++axis)
	{
		const std::int64_t first = slabOf(place[axis] - reach), last = slabOf(place[axis] + reach);
		for (std::int64_t i = first; i <= last; ++i)
			m_bits[std::size_t(axis)][std::size_t(i & (kCount - 1))] |= 1U << bit;
	}
}

std::uint32_t ContactReducer::PlaceSlabs::near(const Vec3& place) const
{
	const auto bits = [&](std::size_t axis, double x) { return m_bits[axis][std::size_t(slabOf(x) & (kCount - 1))]; };
	return bits(0, place.x) & bits(1, place.y) & bits(2, place.z);
}

bool ContactReducer::isLower(std::uint32_t i, std::uint32_t j) const
{
	const double first = candidate(i).predicted, second = candidate(j).predicted;
	return first != second ? first < second : i < j;
}

void ContactReducer::clip(std::uint32_t pair)
{
	m_pool->clip(pair);
	admit();
}

// Candidates that have come are compared with the old points, and join a group once there are groups.
void ContactReducer::admit()
{
	const double most = limit() * limit();
	m_taken.resize(m_pool->points().size(), 0);
	for (; m_admitted < m_taken.size(); ++m_admitted)
	{
		if (m_pool->isDropped(m_admitted)) continue;
		const ContactPoint& point = candidate(m_admitted);
		for (std::uint32_t bits = m_slabs.near(point.pointOnA); bits != 0; bits &= bits - 1)
		{
			const std::uint32_t old = std::uint32_t(__builtin_ctz(bits));
			const double squared = mismatch(oldPoint(old), point);
			if (squared < most) m_matches[old].push_back({squared, m_admitted});
		}
		if (m_isGrouped) join(m_admitted);
	}
}

// Squared: how far the point is from the old one, on A or on B, turned normals counted as length; infinite when too
// far.
double ContactReducer::mismatch(const ClusterPoint& old, const ContactPoint& point) const
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

// Makes the candidates near where an old point would be had it moved with the body that was clipped, not with the
// reference: more often than not it is a corner of that body.
void ContactReducer::searchFor(const ClusterPoint& old)
{
	const Vec3& place = old.point.referenceIsA ? old.placeWithB : old.point.pointOnA;
	const Vec3& normal = old.point.referenceIsA ? old.normalWithB : old.point.normal;
	const double within = m_rules.searchRadius * m_rules.length;
	const double withinOther = within + m_rules.tolerance * m_rules.length;
	// The surfaces were expected so far apart by now, unless they have stopped each other.
	const double margin = dot(old.point.pointOnA - old.point.pointOnB, old.point.normal) - old.point.height;
	const double apart = margin + std::max(old.point.predicted, std::min(old.point.height, 0.0));
	const PointClipper::Near near{place, place - apart * normal, within, withinOther, limit()};
	for (std::uint32_t i = 0; i < m_pool->pairs().size(); ++i)
	{
		const double reach = pair(i).radius + withinOther;
		if (m_pool->isClipped(i) || lengthSquared(pair(i).center - place) > reach * reach) continue;
		if (m_pool->isNear(i, near)) m_pool->clipNear(i, near);
	}
	admit();
}

// The nearest candidate that is not taken, kNone where there is none.
std::uint32_t ContactReducer::nearestKnown(std::uint32_t old) const
{
	double best = kInfinity;
	std::uint32_t nearest = kNone;
	for (const Match& match : m_matches[old])
	{
		if (!(match.squared < best) || m_taken[match.candidate]) continue;
		best = match.squared;
		nearest = match.candidate;
	}
	return nearest;
}

// Of the candidates that are there; where there is none, of those that are made now. Points that were only expected to
// touch, and did not, are not looked for.
std::uint32_t ContactReducer::nearestTo(std::uint32_t old)
{
	const std::uint32_t nearest = nearestKnown(old);
	const ClusterPoint& point = oldPoint(old);
	if (nearest != kNone || m_isSearched[old] || !wasInTouch(point)) return nearest;
	m_isSearched[old] = true;
	searchFor(point);
	return nearestKnown(old);
}

bool ContactReducer::wasInTouch(const ClusterPoint& old) const
{
	return old.impulse > 0 || old.point.height <= m_rules.tolerance * m_rules.length;
}

bool ContactReducer::belongs(const Seed& seed, const Vec3& place, const Vec3& normal) const
{
	const double radius = m_rules.clusterRadius * m_rules.length;
	return dot(seed.normal, normal) >= m_rules.clusterCosine && lengthSquared(place - seed.center) <= radius * radius;
}

// How little a seed suits.
double ContactReducer::misfit(const Seed& seed, const Vec3& place, const Vec3& normal) const
{
	return (1 - dot(seed.normal, normal)) / (1 - m_rules.clusterCosine) +
		   length(place - seed.center) / (m_rules.clusterRadius * m_rules.length);
}

template <class Counts>
std::uint8_t ContactReducer::bestSeed(const Vec3& place, const Vec3& normal, const Counts& counts) const
{
	std::uint8_t best = kNoSeed;
	double least = kInfinity;
	for (std::size_t i = 0; i < m_seeds.size(); ++i)
	{
		if (!counts(m_seeds[i])) continue;
		const double score = misfit(m_seeds[i], place, normal);
		if (best != kNoSeed && !(score < least)) continue;
		best = std::uint8_t(i);
		least = score;
	}
	return best;
}

// The seed that suits best of those that cover the place; kNoSeed: none does.
std::uint8_t ContactReducer::coveringSeed(const Vec3& place, const Vec3& normal) const
{
	return bestSeed(place, normal, [&](const Seed& seed) { return belongs(seed, place, normal); });
}

// The same, or, when all slots are taken, the nearest.
std::uint8_t ContactReducer::seedFor(const Vec3& place, const Vec3& normal) const
{
	const std::uint8_t covering = coveringSeed(place, normal);
	return covering != kNoSeed ? covering : bestSeed(place, normal, [](const Seed&) { return true; });
}

// By a candidate; pairs that may have one are clipped.
bool ContactReducer::isSupported(const Seed& seed)
{
	std::uint32_t seen = 0;
	const auto isSeen = [&]
	{
		for (; seen < m_admitted; ++seen)
			if (!m_pool->isDropped(seen) && belongs(seed, candidate(seen).pointOnA, candidate(seen).normal))
				return true;
		return false;
	};
	if (isSeen()) return true;
	for (std::uint32_t i = 0; i < m_pool->pairs().size(); ++i)
	{
		if (!mayBeChosen(i) ||
			!(belongs(seed, pair(i).place, pair(i).normal) || belongs(seed, pair(i).place, pair(i).steepNormal)))
			continue;
		clip(i);
		if (isSeen()) return true;
	}
	return false;
}

void ContactReducer::findSeeds()
{
	m_seeds.clear();
	std::array<bool, kMaxClusters> used{};
	// Last step's clusters first, where a candidate still supports them.
	for (int slot = 0; slot < kMaxClusters; ++slot)
	{
		const ContactCluster& cluster = m_previous->slots[std::size_t(slot)];
		if (cluster.count == 0) continue;
		const Seed seed{cluster.normal, cluster.center, slot};
		if (!isSupported(seed)) continue;
		used[std::size_t(slot)] = true;
		m_seeds.push_back(seed);
	}
	addSeeds(used);
}

// Then the lowest candidates that no cluster covers; a pair stands for its points until it is the lowest.
void ContactReducer::addSeeds(std::array<bool, kMaxClusters>& used)
{
	m_open.clear();
	m_seedOfPoint.clear();
	const auto openNew = [&]
	{
		for (std::uint32_t i = std::uint32_t(m_seedOfPoint.size()); i < m_admitted; ++i)
		{
			m_seedOfPoint.push_back(coveringSeed(candidate(i).pointOnA, candidate(i).normal));
			if (m_seedOfPoint[i] == kNoSeed && !m_pool->isDropped(i)) m_open.push_back(i);
		}
	};
	openNew();
	m_openPairs.clear();
	m_seedOfPair.assign(m_pool->pairs().size(), kNoSeed);
	m_steepSeedOfPair.assign(m_pool->pairs().size(), kNoSeed);
	for (std::uint32_t i = 0; i < m_pool->pairs().size(); ++i)
	{
		if (!mayBeChosen(i)) continue;
		m_seedOfPair[i] = coveringSeed(pair(i).place, pair(i).normal);
		m_steepSeedOfPair[i] = coveringSeed(pair(i).place, pair(i).steepNormal);
		if (m_seedOfPair[i] == kNoSeed || m_steepSeedOfPair[i] == kNoSeed) m_openPairs.push_back(i);
	}
	std::sort(m_openPairs.begin(), m_openPairs.end(),
			  [this](std::uint32_t i, std::uint32_t j)
			  { return pair(i).lowest != pair(j).lowest ? pair(i).lowest > pair(j).lowest : i > j; });
	std::size_t seen = 0;
	std::uint32_t lowest = kNone;
	while (m_seeds.size() < std::size_t(kMaxClusters))
	{
		for (; seen < m_open.size(); ++seen)
			if (lowest == kNone || isLower(m_open[seen], lowest)) lowest = m_open[seen];
		if (!m_openPairs.empty() && (lowest == kNone || pair(m_openPairs.back()).lowest < candidate(lowest).predicted))
		{
			clip(m_openPairs.back());
			m_openPairs.pop_back();
			openNew();
			continue;
		}
		if (lowest == kNone) return;
		const ContactPoint& point = candidate(lowest);
		const int slot = int(std::find(used.begin(), used.end(), false) - used.begin());
		used[std::size_t(slot)] = true;
		m_seeds.push_back({point.normal, point.pointOnA, slot});
		cover();
		seen = 0;
		lowest = kNone;
	}
}

// By the last seed what is open.
void ContactReducer::cover()
{
	const Seed& seed = m_seeds.back();
	const std::uint8_t index = std::uint8_t(m_seeds.size() - 1);
	const auto cover = [&](std::uint8_t& of, const Vec3& place, const Vec3& normal)
	{
		if (of == kNoSeed && belongs(seed, place, normal)) of = index;
		return of != kNoSeed;
	};
	const auto leaves = [](Indices& open, const auto& isCovered)
	{ open.erase(std::remove_if(open.begin(), open.end(), isCovered), open.end()); };
	leaves(m_open,
		   [&](std::uint32_t i) { return cover(m_seedOfPoint[i], candidate(i).pointOnA, candidate(i).normal); });
	leaves(m_openPairs,
		   [&](std::uint32_t i)
		   {
			   const bool isCovered = cover(m_seedOfPair[i], pair(i).place, pair(i).normal);
			   return cover(m_steepSeedOfPair[i], pair(i).place, pair(i).steepNormal) && isCovered;
		   });
}

void ContactReducer::join(std::uint32_t i)
{
	m_groups[seedFor(candidate(i).pointOnA, candidate(i).normal)].candidates.push_back(i);
}

// Every candidate, and every pair that is not clipped, goes to a seed that covers it, or to the nearest.
void ContactReducer::group()
{
	for (Group& group : m_groups)
	{
		group.candidates.clear();
		group.pairs.clear();
	}
	m_isGrouped = true;
	if (m_seeds.empty()) return;
	for (std::uint32_t i = 0; i < m_admitted; ++i)
	{
		if (m_pool->isDropped(i)) continue;
		if (m_seedOfPoint[i] == kNoSeed)
			join(i);
		else
			m_groups[m_seedOfPoint[i]].candidates.push_back(i);
	}
	for (std::uint32_t i = 0; i < m_pool->pairs().size(); ++i)
	{
		if (!mayBeChosen(i)) continue;
		const auto seedOf = [&](std::uint8_t covering, const Vec3& normal)
		{ return covering != kNoSeed ? covering : seedFor(pair(i).place, normal); };
		const std::uint8_t seed = seedOf(m_seedOfPair[i], pair(i).normal);
		const std::uint8_t steep = seedOf(m_steepSeedOfPair[i], pair(i).steepNormal);
		m_groups[seed].pairs.push_back(i);
		if (steep != seed) m_groups[steep].pairs.push_back(i);
	}
}

void ContactReducer::remember(int slot, double spacing, Kept& kept)
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
		const Vec3& place = candidate(match).pointOnA;
		const bool crowded =
			std::any_of(kept.begin(), kept.end(),
						[&](std::uint32_t other) { return length(candidate(other).pointOnA - place) < spacing; });
		if (crowded) continue;  // remembered points that drifted together hold nothing
		m_taken[match] = 1;
		kept.push(match);
	}
}

// Least distance between two points of a cluster: a share of how far its lowest candidates reach.
double ContactReducer::spacingOf(const Group& group) const
{
	double extent = 0;
	if (!group.candidates.empty())
	{
		const ContactPoint& first =
			candidate(*std::min_element(group.candidates.begin(), group.candidates.end(),
										[this](std::uint32_t i, std::uint32_t j) { return isLower(i, j); }));
		const auto reach = [&](const Vec3& place, double predicted)
		{
			if (predicted < first.predicted + m_rules.tolerance * m_rules.length)
				extent = std::max(extent, length(place - first.pointOnA));
		};
		for (const std::uint32_t i : group.candidates) reach(candidate(i).pointOnA, candidate(i).predicted);
		for (const std::uint32_t i : group.pairs) reach(pair(i).place, pair(i).predicted);
	}
	return std::max(m_rules.spacing * m_rules.length, m_rules.spacingOfExtent * extent);
}

// The group's lowest candidate, if one is lower than this; else any of them, or none.
std::uint32_t ContactReducer::lowestBelow(double predicted, Group& group)
{
	std::uint32_t lowest = kNone;
	std::size_t seen = 0;
	const auto look = [&]
	{
		for (; seen < group.candidates.size(); ++seen)
			if (lowest == kNone || isLower(group.candidates[seen], lowest)) lowest = group.candidates[seen];
	};
	look();
	while (true)
	{
		double bound = lowest == kNone ? predicted : std::min(predicted, candidate(lowest).predicted);
		std::uint32_t next = kNone;
		for (const std::uint32_t i : group.pairs)
			if (pair(i).lowest < bound && !m_pool->isClipped(i))
			{
				next = i;
				bound = pair(i).lowest;
			}
		if (next == kNone) return lowest;
		clip(next);
		look();
	}
}

// Adds candidates far from those kept, preferring low ones, until the cluster is full.
void ContactReducer::fill(Group& group, double spacing, Kept& kept)
{
	const double tolerance = m_rules.tolerance * m_rules.length;
	double lowest = kInfinity;
	for (const std::uint32_t i : kept) lowest = std::min(lowest, candidate(i).predicted);
	const auto weightOf = [&](double predicted) { return 1 - (predicted - lowest) / tolerance; };
	const auto distanceTo = [&](const Vec3& place)
	{
		double squared = kInfinity;
		for (const std::uint32_t i : kept) squared = std::min(squared, lengthSquared(place - candidate(i).pointOnA));
		return std::sqrt(squared);
	};
	std::uint32_t best = kNone;
	double bestScore = 0;
	std::size_t seen = 0;
	while (kept.count < std::size_t(kClusterPoints))
	{
		for (; seen < group.candidates.size(); ++seen)
		{
			const std::uint32_t i = group.candidates[seen];
			const double weight = weightOf(candidate(i).predicted);
			if (weight <= 0 || m_taken[i]) continue;
			const double distance = distanceTo(candidate(i).pointOnA);
			if (distance < spacing || weight * distance <= bestScore) continue;
			best = i;
			bestScore = weight * distance;
		}
		// A pair that may have a better one?
		std::uint32_t bestPair = kNone;
		double bestEstimate = bestScore;
		for (const std::uint32_t i : group.pairs)
		{
			const double weight = weightOf(pair(i).predicted);
			if (weight <= 0 || m_pool->isClipped(i)) continue;
			const double distance = distanceTo(pair(i).place);
			if (distance < spacing || weight * distance <= bestEstimate) continue;
			bestPair = i;
			bestEstimate = weight * distance;
		}
		if (bestPair != kNone)
		{
			clip(bestPair);
			continue;
		}
		if (best == kNone) return;
		kept.push(best);
		best = kNone;
		bestScore = 0;
		seen = 0;
	}
}

void ContactReducer::choose(std::size_t seed, ClusterSet& next)
{
	Group& group = m_groups[seed];
	const std::size_t slot = std::size_t(m_seeds[seed].slot);
	const double spacing = spacingOf(group);
	Kept kept;
	remember(m_seeds[seed].slot, spacing, kept);
	// The lowest candidate enters if it is clearly lower than everything remembered.
	double clear = kInfinity;
	for (const std::uint32_t i : kept)
		clear = std::min(clear, candidate(i).predicted - m_rules.enterShare * m_rules.tolerance * m_rules.length);
	const std::uint32_t lowest = lowestBelow(clear, group);
	if (lowest != kNone && candidate(lowest).predicted < clear && !m_taken[lowest])
	{
		kept.count = std::min(kept.count, std::size_t(kClusterPoints - 1));
		kept.push(lowest);
	}
	if (kept.count == 0) return;
	fill(group, spacing, kept);

	ContactCluster& cluster = next.slots[slot];
	for (const std::uint32_t i : kept)
	{
		m_taken[i] = 1;
		m_chosen[slot][std::size_t(cluster.count)] = i;
		cluster.points[std::size_t(cluster.count++)].point = candidate(i);
		cluster.normal += candidate(i).normal;
		cluster.center += (1.0 / double(kept.count)) * candidate(i).pointOnA;
	}
	cluster.normal = normalized(cluster.normal);
	if (lengthSquared(cluster.normal) == 0) cluster.normal = candidate(*kept.begin()).normal;
}

// Each new point continues the nearest old one, of any cluster, that no other point has claimed.
void ContactReducer::link(ClusterSet& next)
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

void ContactReducer::reduce(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules,
							ClusterSet& next)
{
	m_pool = &pool;
	m_previous = &previous;
	m_rules = rules;
	m_admitted = 0;
	m_isGrouped = false;
	m_taken.clear();
	next.clear();
	m_isSearched = {};
	m_slabs.start(limit());
	for (std::vector<Match>& matches : m_matches) matches.clear();
	forEachOld(
		[&](std::uint32_t old)
		{
			m_slabs.add(old, oldPoint(old).point.pointOnA);
			m_slabs.add(old, oldPoint(old).placeWithB);
			pool.clipAsBefore(oldPoint(old).point);
		});
	admit();
	forEachOld([&](std::uint32_t old) { nearestTo(old); });
	findSeeds();
	group();
	for (std::size_t seed = 0; seed < m_seeds.size(); ++seed) choose(seed, next);
	link(next);
}
}  // namespace clod
