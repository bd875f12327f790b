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

// Which of up to 32 places are near a point, as bits: places by slabs along each axis, wrapped round, so that a few
// more may seem near.
class PlaceSlabs
{
public:
	explicit PlaceSlabs(double limit) : m_limit(limit) {}
	void add(std::uint32_t bit, const Vec3& place)
	{
		const double reach = 1.001 * m_limit;  // rounding included
		for (int axis = 0; axis < 3; ++axis)
		{
			const std::int64_t first = slabOf(place[axis] - reach), last = slabOf(place[axis] + reach);
			for (std::int64_t i = first; i <= last; ++i) m_bits[axis][std::size_t(i & kMask)] |= 1U << bit;
		}
	}
	std::uint32_t near(const Vec3& point) const { return bitsAt(0, point.x) & bitsAt(1, point.y) & bitsAt(2, point.z); }

private:
	static constexpr std::int64_t kMask = 255;
	std::int64_t slabOf(double x) const { return std::int64_t(std::floor(x / m_limit)); }
	std::uint32_t bitsAt(int axis, double x) const { return m_bits[axis][std::size_t(slabOf(x) & kMask)]; }
	const double m_limit;
	std::uint32_t m_bits[3][kMask + 1] = {};
};

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
		const Seed seed{cluster.normal, cluster.center, slot};
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
		m_seeds.push_back({point.normal, point.pointOnA, slot});
	}
}

// Every candidate goes to the seed that suits it best: one that covers it, or, when all slots are taken, the nearest.
void ContactReducer::assign()
{
	for (Members& members : m_members) members.clear();
	for (const std::uint32_t i : m_binned)
	{
		std::size_t best = m_seeds.size();
		double bestScore = 0;
		bool bestCovers = false;
		for (std::size_t seed = 0; seed < m_seeds.size(); ++seed)
		{
			double score = 0;
			const bool covers = belongs(m_seeds[seed], (*m_candidates)[i], score);
			const bool better = best == m_seeds.size() || (covers != bestCovers ? covers : score < bestScore);
			if (!better) continue;
			best = seed;
			bestScore = score;
			bestCovers = covers;
		}
		m_members[best].push_back(i);
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

// For each old point the candidates that it may have become.
void ContactReducer::matchWithOld(const ClusterSet& previous)
{
	for (std::vector<Match>& matches : m_matches) matches.clear();
	if (previous.pointCount() == 0) return;
	const double limit = m_rules.matchRadius * m_rules.length;
	PlaceSlabs slabs(limit);
	const auto oldPoint = [&](std::uint32_t old) -> const ClusterPoint&
	{ return previous.slots[old / kClusterPoints].points[old % kClusterPoints]; };
	for (std::uint32_t old = 0; old < kMostPoints; ++old)
	{
		if (int(old % kClusterPoints) >= previous.slots[old / kClusterPoints].count) continue;
		slabs.add(old, oldPoint(old).point.pointOnA);
		slabs.add(old, oldPoint(old).placeWithB);
	}
	for (std::uint32_t i = 0; i < m_candidates->size(); ++i)
	{
		if ((*m_excluded)[i]) continue;
		const ContactPoint& point = (*m_candidates)[i];
		for (std::uint32_t bits = slabs.near(point.pointOnA); bits != 0; bits &= bits - 1)
		{
			const std::uint32_t old = std::uint32_t(__builtin_ctz(bits));
			const double squared = mismatch(oldPoint(old), point);
			if (squared < limit * limit) m_matches[old].push_back({squared, i});
		}
	}
}

// Ties fall to the lower index.
std::uint32_t ContactReducer::nearestTo(std::uint32_t old) const
{
	double best = std::numeric_limits<double>::infinity();
	std::uint32_t nearest = kNone;
	for (const Match& match : m_matches[old])
	{
		if (!(match.squared < best) || m_taken[match.candidate]) continue;
		best = match.squared;
		nearest = match.candidate;
	}
	return nearest;
}

void ContactReducer::remember(int slot, const ClusterSet& previous, double spacing, Kept& kept)
{
	const ContactCluster& old = previous.slots[std::size_t(slot)];
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
		const Vec3& place = (*m_candidates)[match].pointOnA;
		const bool crowded =
			std::any_of(kept.begin(), kept.end(),
						[&](std::uint32_t other) { return length((*m_candidates)[other].pointOnA - place) < spacing; });
		if (crowded) continue;  // remembered points that drifted together hold nothing
		m_taken[match] = 1;
		kept.push(match);
	}
}

// Least distance between two points of a cluster: a share of how far its lowest candidates reach.
double ContactReducer::spacingOf(const Members& members) const
{
	const std::vector<ContactPoint>& candidates = *m_candidates;
	const ContactPoint& first = candidates[members.front()];
	double extent = 0;
	for (const std::uint32_t i : members)
		if (candidates[i].predicted < first.predicted + m_rules.tolerance * m_rules.length)
			extent = std::max(extent, length(candidates[i].pointOnA - first.pointOnA));
	return std::max(m_rules.spacing * m_rules.length, m_rules.spacingOfExtent * extent);
}

// Adds candidates far from those kept, preferring low ones, until the cluster is full.
void ContactReducer::fill(const Members& members, double spacing, Kept& kept) const
{
	const std::vector<ContactPoint>& candidates = *m_candidates;
	const double tolerance = m_rules.tolerance * m_rules.length;
	double lowest = 1e300;
	for (const std::uint32_t i : kept) lowest = std::min(lowest, candidates[i].predicted);
	while (kept.count < std::size_t(kClusterPoints))
	{
		std::uint32_t best = kNone;
		double bestScore = 0;
		for (const std::uint32_t i : members)
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
		kept.push(best);
	}
}

void ContactReducer::choose(std::size_t seed, const ClusterSet& previous, ClusterSet& next)
{
	const Members& members = m_members[seed];
	if (members.empty()) return;
	const std::vector<ContactPoint>& candidates = *m_candidates;
	const std::size_t slot = std::size_t(m_seeds[seed].slot);
	const double spacing = spacingOf(members);
	Kept kept;
	remember(m_seeds[seed].slot, previous, spacing, kept);
	// The lowest candidate enters if it is clearly lower than everything remembered.
	const std::uint32_t lowest = members.front();
	const double clear = m_rules.enterShare * m_rules.tolerance * m_rules.length;
	const bool enters =
		std::all_of(kept.begin(), kept.end(),
					[&](std::uint32_t i) { return candidates[lowest].predicted < candidates[i].predicted - clear; });
	if (enters && !m_taken[lowest])
	{
		kept.count = std::min(kept.count, std::size_t(kClusterPoints - 1));
		kept.push(lowest);
	}
	if (kept.count == 0) return;
	fill(members, spacing, kept);

	ContactCluster& cluster = next.slots[slot];
	for (const std::uint32_t i : kept)
	{
		m_taken[i] = 1;
		m_chosen[slot][std::size_t(cluster.count)] = i;
		cluster.points[std::size_t(cluster.count++)].point = candidates[i];
		cluster.normal += candidates[i].normal;
		cluster.center += (1.0 / double(kept.count)) * candidates[i].pointOnA;
	}
	cluster.normal = normalized(cluster.normal);
	if (lengthSquared(cluster.normal) == 0) cluster.normal = candidates[*kept.begin()].normal;
}

// Each new point continues the nearest old one, of any cluster, that no other point has claimed.
void ContactReducer::link(const ClusterSet& previous, ClusterSet& next)
{
	m_links.clear();
	for (std::uint32_t i = 0; i < kMostPoints; ++i)
	{
		const ContactCluster& to = next.slots[i / kClusterPoints];
		if (int(i % kClusterPoints) >= to.count) continue;
		const ContactPoint& newPoint = to.points[i % kClusterPoints].point;
		for (std::uint32_t j = 0; j < kMostPoints; ++j)
		{
			const ContactCluster& from = previous.slots[j / kClusterPoints];
			if (int(j % kClusterPoints) >= from.count) continue;
			const double squared = mismatch(from.points[j % kClusterPoints], newPoint);
			if (squared < std::numeric_limits<double>::infinity()) m_links.push_back({squared, j, i});
		}
	}
	std::sort(m_links.begin(), m_links.end());
	std::array<bool, kMostPoints> claimed{};
	for (const Link& pair : m_links)
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
	next.clear();
	binCandidates();
	matchWithOld(previous);
	findSeeds(previous);
	assign();
	for (std::size_t seed = 0; seed < m_seeds.size(); ++seed) choose(seed, previous, next);
	link(previous, next);
}
}  // namespace clod
