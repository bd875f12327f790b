// SPDX-License-Identifier: Zlib
// Bins, clusters and chooses contact points. Ties fall to the lower index everywhere.
#include "clod/query/ContactClusters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clod
{
namespace
{
// A cell of place and normal, packed; cells far apart may share a key, which only costs a candidate of the same normal
// 2^13 cells away.
std::uint64_t binKey(const ContactPoint& point, double cell)
{
	const auto place = [cell](double x) { return std::uint64_t(std::int64_t(std::floor(x / cell))) & 0x1FFF; };
	const auto direction = [](double x) { return std::uint64_t(std::int64_t(std::lround(3 * x) + 4)) & 0xF; };
	const Vec3& p = point.pointOnA;
	const Vec3& n = point.normal;
	return place(p.x) | place(p.y) << 13 | place(p.z) << 26 | direction(n.x) << 39 | direction(n.y) << 43 |
		   direction(n.z) << 47;
}

bool lower(const std::vector<ContactPoint>& points, std::uint32_t i, std::uint32_t j)
{
	return points[i].predicted != points[j].predicted ? points[i].predicted < points[j].predicted : i < j;
}
}  // namespace

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
			old.placeWithB = bodyMotion * old.point.pointOnB + old.point.height * old.normalWithB;
		}
}

void ContactReducer::binCandidates()
{
	const std::vector<ContactPoint>& candidates = *m_candidates;
	std::size_t size = 64;
	while (size < 2 * candidates.size()) size *= 2;
	m_table.assign(size, kNone);
	m_keys.resize(size);
	m_binned.clear();
	for (std::uint32_t i = 0; i < candidates.size(); ++i)
	{
		if ((*m_excluded)[i]) continue;
		const std::uint64_t key = binKey(candidates[i], m_rules.binSize * m_rules.length);
		std::size_t at = std::size_t((key * 0x9E3779B97F4A7C15u) >> 20) & (size - 1);
		while (m_table[at] != kNone && m_keys[at] != key) at = (at + 1) & (size - 1);
		if (m_table[at] == kNone)
		{
			m_keys[at] = key;
			m_table[at] = std::uint32_t(m_binned.size());
			m_binned.push_back(i);
		}
		else if (lower(candidates, i, m_binned[m_table[at]]))
			m_binned[m_table[at]] = i;
	}
	std::sort(m_binned.begin(), m_binned.end(),
			  [&candidates](std::uint32_t i, std::uint32_t j) { return lower(candidates, i, j); });
}

bool ContactReducer::belongs(const Seed& seed, const ContactPoint& point, double& score) const
{
	const double cosine = dot(seed.normal, point.normal);
	const double distance = length(point.pointOnA - seed.center) / (m_rules.clusterRadius * m_rules.length);
	score = (1 - cosine) / (1 - m_rules.clusterCosine) + distance;
	return cosine >= m_rules.clusterCosine && distance <= 1;
}

void ContactReducer::findSeeds(const ClusterSet& previous)
{
	m_seeds.clear();
	std::array<bool, kMaxClusters> used{};
	double score = 0;
	// Last step's clusters first, where a candidate still supports them.
	for (int slot = 0; slot < kMaxClusters; ++slot)
	{
		const ContactCluster& cluster = previous.slots[std::size_t(slot)];
		if (cluster.count == 0) continue;
		const Seed seed{cluster.normal, cluster.center, slot, {}};
		const bool supported = std::any_of(m_binned.begin(), m_binned.end(),
										   [&](std::uint32_t i) { return belongs(seed, (*m_candidates)[i], score); });
		if (!supported) continue;
		used[std::size_t(slot)] = true;
		m_seeds.push_back(seed);
	}
	// Then the lowest candidates that no cluster covers.
	for (const std::uint32_t i : m_binned)
	{
		if (m_seeds.size() == std::size_t(kMaxClusters)) break;
		const ContactPoint& point = (*m_candidates)[i];
		const bool covered =
			std::any_of(m_seeds.begin(), m_seeds.end(), [&](const Seed& seed) { return belongs(seed, point, score); });
		if (covered) continue;
		const int slot = int(std::find(used.begin(), used.end(), false) - used.begin());
		used[std::size_t(slot)] = true;
		m_seeds.push_back({point.normal, point.pointOnA, slot, {}});
	}
}

// Every candidate goes to the seed that suits it best: one that covers it, or, when all slots are taken, the nearest.
void ContactReducer::assign()
{
	for (const std::uint32_t i : m_binned)
	{
		Seed* best = nullptr;
		double bestScore = 0;
		bool bestCovers = false;
		for (Seed& seed : m_seeds)
		{
			double score = 0;
			const bool covers = belongs(seed, (*m_candidates)[i], score);
			const bool better = !best || (covers != bestCovers ? covers : score < bestScore);
			if (!better) continue;
			best = &seed;
			bestScore = score;
			bestCovers = covers;
		}
		best->members.push_back(i);
	}
}

// Squared: how far the point is from the old one, on A or on B, turned normals counted as length; infinite when too
// far.
double ContactReducer::mismatch(const ClusterPoint& old, const ContactPoint& point) const
{
	const double limit = m_rules.matchRadius * m_rules.length, weight = m_rules.matchNormal * m_rules.length;
	double best = std::numeric_limits<double>::infinity();
	const auto compare = [&](const Vec3& place, const Vec3& normal)
	{
		const double placeSquared = lengthSquared(point.pointOnA - place);
		if (placeSquared > limit * limit || dot(point.normal, normal) < m_rules.matchCosine) return;
		best = std::min(best, placeSquared + weight * weight * lengthSquared(point.normal - normal));
	};
	compare(old.point.pointOnA, old.point.normal);
	compare(old.placeWithB, old.normalWithB);
	return best;
}

// Ties fall to the lower index, so that the order of the search makes no difference.
std::uint32_t ContactReducer::nearestTo(const ClusterPoint& old) const
{
	const double limit = m_rules.matchRadius * m_rules.length;
	double bestSquared = limit * limit;
	std::uint32_t best = kNone;
	// False where nothing farther along x can be nearer. A mismatch is no less than the distance of the places.
	const auto visit = [&](const Place& place, double x)
	{
		const double along = place.onA.x - x;
		if (along * along > bestSquared) return false;
		const double least =
			std::min(lengthSquared(place.onA - old.point.pointOnA), lengthSquared(place.onA - old.placeWithB));
		if (least > bestSquared || m_taken[place.candidate]) return true;
		const double squared = mismatch(old, (*m_candidates)[place.candidate]);
		const bool isNearer = squared < bestSquared || (squared == bestSquared && place.candidate < best);
		if (!isNearer || squared == limit * limit) return true;
		best = place.candidate;
		bestSquared = squared;
		return true;
	};
	for (const double x : {old.point.pointOnA.x, old.placeWithB.x})
	{
		const auto middle = std::lower_bound(m_byX.begin(), m_byX.end(), Place{{x, 0, 0}, 0});
		for (auto at = middle; at != m_byX.end() && visit(*at, x); ++at)
		{
		}
		for (auto at = middle; at != m_byX.begin() && visit(*(at - 1), x); --at)
		{
		}
	}
	return best;
}

void ContactReducer::remember(const Seed& seed, const ClusterSet& previous, double spacing,
							  std::vector<std::uint32_t>& kept)
{
	const ContactCluster& old = previous.slots[std::size_t(seed.slot)];
	std::array<int, kClusterPoints> order{};
	for (int i = 0; i < old.count; ++i) order[std::size_t(i)] = i;
	std::stable_sort(order.begin(), order.begin() + old.count,
					 [&old](int i, int j)
					 { return old.points[std::size_t(i)].impulse > old.points[std::size_t(j)].impulse; });
	for (int i = 0; i < old.count; ++i)
	{
		const std::uint32_t match = nearestTo(old.points[std::size_t(order[std::size_t(i)])]);
		if (match == kNone) continue;
		const Vec3& place = (*m_candidates)[match].pointOnA;
		const bool crowded =
			std::any_of(kept.begin(), kept.end(),
						[&](std::uint32_t other) { return length((*m_candidates)[other].pointOnA - place) < spacing; });
		if (crowded) continue;  // remembered points that drifted together hold nothing
		m_taken[match] = 1;
		kept.push_back(match);
	}
}

// Least distance between two points of a cluster: a share of how far its lowest candidates reach.
double ContactReducer::spacingOf(const Seed& seed) const
{
	const std::vector<ContactPoint>& candidates = *m_candidates;
	const ContactPoint& first = candidates[seed.members.front()];
	double extent = 0;
	for (const std::uint32_t i : seed.members)
		if (candidates[i].predicted < first.predicted + m_rules.tolerance * m_rules.length)
			extent = std::max(extent, length(candidates[i].pointOnA - first.pointOnA));
	return std::max(m_rules.spacing * m_rules.length, m_rules.spacingOfExtent * extent);
}

// Adds candidates far from those kept, preferring low ones, until the cluster is full.
void ContactReducer::fill(const Seed& seed, double spacing, std::vector<std::uint32_t>& kept) const
{
	const std::vector<ContactPoint>& candidates = *m_candidates;
	const double tolerance = m_rules.tolerance * m_rules.length;
	double lowest = 1e300;
	for (const std::uint32_t i : kept) lowest = std::min(lowest, candidates[i].predicted);
	while (kept.size() < std::size_t(kClusterPoints))
	{
		std::uint32_t best = kNone;
		double bestScore = 0;
		for (const std::uint32_t i : seed.members)
		{
			const double weight = 1 - (candidates[i].predicted - lowest) / tolerance;
			if (weight <= 0 || m_taken[i]) continue;
			double distance = 1e300;
			for (const std::uint32_t j : kept)
				distance = std::min(distance, length(candidates[i].pointOnA - candidates[j].pointOnA));
			if (distance < spacing || weight * distance <= bestScore) continue;
			best = i;
			bestScore = weight * distance;
		}
		if (best == kNone) return;
		kept.push_back(best);
	}
}

void ContactReducer::choose(const Seed& seed, const ClusterSet& previous, ClusterSet& next)
{
	if (seed.members.empty()) return;
	const std::vector<ContactPoint>& candidates = *m_candidates;
	std::vector<std::uint32_t> kept;
	kept.reserve(kClusterPoints + 1);
	const double spacing = spacingOf(seed);
	remember(seed, previous, spacing, kept);
	// The lowest candidate enters if it is clearly lower than everything remembered.
	const std::uint32_t lowest = seed.members.front();
	const double clear = m_rules.enterShare * m_rules.tolerance * m_rules.length;
	const bool enters =
		std::all_of(kept.begin(), kept.end(),
					[&](std::uint32_t i) { return candidates[lowest].predicted < candidates[i].predicted - clear; });
	if (enters && !m_taken[lowest])
	{
		if (kept.size() == std::size_t(kClusterPoints)) kept.pop_back();
		kept.push_back(lowest);
	}
	if (kept.empty()) return;
	fill(seed, spacing, kept);

	ContactCluster& cluster = next.slots[std::size_t(seed.slot)];
	for (const std::uint32_t i : kept)
	{
		m_taken[i] = 1;
		m_chosen[std::size_t(seed.slot)][std::size_t(cluster.count)] = i;
		cluster.points[std::size_t(cluster.count++)].point = candidates[i];
		cluster.normal += candidates[i].normal;
		cluster.center += (1.0 / double(kept.size())) * candidates[i].pointOnA;
	}
	cluster.normal = normalized(cluster.normal);
	if (lengthSquared(cluster.normal) == 0) cluster.normal = candidates[kept.front()].normal;
}

// Each new point continues the nearest old one, of any cluster, that no other point has claimed.
void ContactReducer::link(const ClusterSet& previous, ClusterSet& next) const
{
	struct Pair
	{
		double squared;
		std::uint32_t from, to;
	};
	std::vector<Pair> pairs;
	for (std::uint32_t i = 0; i < kMaxClusters * kClusterPoints; ++i)
	{
		const ContactCluster& to = next.slots[i / kClusterPoints];
		if (int(i % kClusterPoints) >= to.count) continue;
		const ContactPoint& newPoint = to.points[i % kClusterPoints].point;
		for (std::uint32_t j = 0; j < kMaxClusters * kClusterPoints; ++j)
		{
			const ContactCluster& from = previous.slots[j / kClusterPoints];
			if (int(j % kClusterPoints) >= from.count) continue;
			const double squared = mismatch(from.points[j % kClusterPoints], newPoint);
			if (squared < std::numeric_limits<double>::infinity()) pairs.push_back({squared, j, i});
		}
	}
	std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& p, const Pair& q) { return p.squared < q.squared; });
	std::array<bool, kMaxClusters * kClusterPoints> claimed{};
	for (const Pair& pair : pairs)
	{
		ClusterPoint& point = next.slots[pair.to / kClusterPoints].points[pair.to % kClusterPoints];
		if (claimed[pair.from] || point.previous != kNone) continue;
		claimed[pair.from] = true;
		point.previous = pair.from;
		point.impulse = previous.slots[pair.from / kClusterPoints].points[pair.from % kClusterPoints].impulse;
	}
}

void ContactReducer::reduce(const std::vector<ContactPoint>& candidates, const std::vector<char>& excluded,
							const ClusterSet& previous, const ClusterRules& rules, ClusterSet& next)
{
	m_candidates = &candidates;
	m_excluded = &excluded;
	m_rules = rules;
	m_taken.assign(candidates.size(), 0);
	m_byX.clear();
	for (std::uint32_t i = 0; i < candidates.size() && previous.pointCount() > 0; ++i)
		if (!excluded[i]) m_byX.push_back({candidates[i].pointOnA, i});
	std::sort(m_byX.begin(), m_byX.end());
	next.clear();
	binCandidates();
	findSeeds(previous);
	assign();
	for (const Seed& seed : m_seeds) choose(seed, previous, next);
	link(previous, next);
}
}  // namespace clod
