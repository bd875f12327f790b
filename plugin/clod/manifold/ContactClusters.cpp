// SPDX-License-Identifier: Zlib
// Seeds clusters, groups what may be chosen, chooses, and clips pairs of nodes on the way. Ties fall to the lower index
// everywhere.
#include "clod/manifold/ContactClusters.h"

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

bool ContactReducer::isLower(std::uint32_t i, std::uint32_t j) const
{
	const double first = candidate(i).predicted, second = candidate(j).predicted;
	return first != second ? first < second : i < j;
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
		for (; seen < m_pool->points().size(); ++seen)
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
		m_pool->clip(i);
		if (isSeen()) return true;
	}
	return false;
}

void ContactReducer::findSeeds(const ClusterSet& previous)
{
	m_seeds.clear();
	std::array<bool, kMaxClusters> used{};
	// Last step's clusters first, where a candidate still supports them.
	for (int slot = 0; slot < kMaxClusters; ++slot)
	{
		const ContactCluster& cluster = previous.slots[std::size_t(slot)];
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
		for (std::uint32_t i = std::uint32_t(m_seedOfPoint.size()); i < m_pool->points().size(); ++i)
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
			m_pool->clip(m_openPairs.back());
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

// Candidates that have come go to a seed that covers them, or to the nearest.
void ContactReducer::joinNew()
{
	for (; m_joined < m_pool->points().size(); ++m_joined)
	{
		if (m_pool->isDropped(m_joined)) continue;
		const ContactPoint& point = candidate(m_joined);
		const std::uint8_t covering = m_joined < m_seedOfPoint.size() ? m_seedOfPoint[m_joined] : kNoSeed;
		m_groups[covering != kNoSeed ? covering : seedFor(point.pointOnA, point.normal)].candidates.push_back(m_joined);
	}
}

// All candidates, and likewise every pair that is not clipped, by both of its normals.
void ContactReducer::group()
{
	for (Group& group : m_groups)
	{
		group.candidates.clear();
		group.pairs.clear();
	}
	m_joined = 0;
	if (m_seeds.empty()) return;
	joinNew();
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
		m_pool->clip(next);
		joinNew();
		look();
	}
}

// Adds candidates far from those kept, preferring low ones, until the cluster is full.
void ContactReducer::fill(Group& group, double spacing, ChosenPoints& kept)
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
			if (weight <= 0 || m_memory.isTaken(i)) continue;
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
			m_pool->clip(bestPair);
			joinNew();
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
	ChosenPoints kept;
	m_memory.remember(m_seeds[seed].slot, spacing, kept);
	joinNew();
	// The lowest candidate enters if it is clearly lower than everything remembered.
	double clear = kInfinity;
	for (const std::uint32_t i : kept)
		clear = std::min(clear, candidate(i).predicted - m_rules.enterShare * m_rules.tolerance * m_rules.length);
	const std::uint32_t lowest = lowestBelow(clear, group);
	if (lowest != kNone && candidate(lowest).predicted < clear && !m_memory.isTaken(lowest))
	{
		kept.count = std::min(kept.count, std::size_t(kClusterPoints - 1));
		kept.push(lowest);
	}
	if (kept.count == 0) return;
	fill(group, spacing, kept);

	ContactCluster& cluster = next.slots[slot];
	for (const std::uint32_t i : kept)
	{
		m_memory.take(i);
		m_chosen[slot][std::size_t(cluster.count)] = i;
		cluster.points[std::size_t(cluster.count++)].point = candidate(i);
		cluster.normal += candidate(i).normal;
		cluster.center += (1.0 / double(kept.count)) * candidate(i).pointOnA;
	}
	cluster.normal = normalized(cluster.normal);
	if (lengthSquared(cluster.normal) == 0) cluster.normal = candidate(*kept.begin()).normal;
}

void ContactReducer::reduce(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules,
							ClusterSet& next)
{
	m_pool = &pool;
	m_rules = rules;
	next.clear();
	m_memory.start(pool, previous, rules);
	findSeeds(previous);
	group();
	for (std::size_t seed = 0; seed < m_seeds.size(); ++seed) choose(seed, next);
	m_memory.link(next);
}
}  // namespace clod
