// SPDX-License-Identifier: Zlib
// From thousands of possible points to a few clusters of at most four, which remember last step's points: a point that
// has a candidate near its old place is kept before a better-looking new one. The memory is what makes contacts rest
// (it cuts jitter five to ten times) and carries impulses across steps, levels of detail and changes of reference.
//
// Pairs of nodes whose estimates are nowhere chosen are never clipped (CandidatePool.h): once contacts last, most.
//
// Frame A, unit of the hierarchies. A pure function of the pool's pairs and points and of the previous set.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "clod/query/CandidatePool.h"

namespace clod
{
inline constexpr int kMaxClusters = 8;
inline constexpr int kClusterPoints = 4;

struct ClusterPoint
{
	ContactPoint point{};
	std::uint32_t previous = kNone;  // cluster * kClusterPoints + index in the previous set; kNone = a new point
	double impulse = 0;              // set by the owner before the next reduction: strong points are remembered first
	// Where last step's point would be had it moved with body B (see carryWithB), in frame A.
	Vec3 placeWithB, normalWithB;
};

struct ContactCluster
{
	Vec3 normal, center;  // of its points
	int count = 0;        // 0: the slot is free
	std::array<ClusterPoint, kClusterPoints> points{};
};

// Slots keep their index while their cluster lives, so that one slot can be one manifold.
struct ClusterSet
{
	std::array<ContactCluster, kMaxClusters> slots{};
	void clear() { slots = {}; }
	int pointCount() const;
};

// Fills placeWithB and normalWithB: a corner of B that slides over A is the same point although it moves in A's frame.
// bodyMotion maps B's material of the last step to now, both in frame A.
void carryWithB(ClusterSet& set, const Transform& bodyMotion);

// All shares of PointRules::length unless named otherwise.
struct ClusterRules
{
	double length = 1;
	double clusterCosine = 0.906;  // 25 degrees between a cluster's normal and its points'
	double clusterRadius = 0.25;
	double matchRadius = 0.004;   // how far a remembered point may move
	double searchRadius = 0.001;  // how far from it faces are looked for that may have it now
	double matchNormal = 0.05;    // length one unit of normal change counts for
	double matchCosine = 0.866;   // 30 degrees
	double tolerance = 0.001;     // heights within it of the lowest are equally good
	double enterShare = 0.3;      // the lowest candidate replaces memory only if lower by this share of the tolerance
	double spacing = 0.001;       // least distance of two points of a cluster
	double spacingOfExtent = 0.15;
};

// Reduces candidates to clusters. Buffers only.
class ContactReducer
{
public:
	// Clips those pairs of the pool whose points may be chosen.
	void reduce(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules, ClusterSet& next);
	// Candidate behind each point of the last reduction, by slot and index.
	std::uint32_t candidateOf(int slot, int index) const { return m_chosen[std::size_t(slot)][std::size_t(index)]; }

private:
	static constexpr std::uint32_t kMostPoints = kMaxClusters * kClusterPoints;
	struct Seed
	{
		Vec3 normal, center;
		int slot;
	};
	// Candidates chosen for one cluster.
	struct Kept
	{
		std::array<std::uint32_t, kClusterPoints + 1> candidate{};
		std::size_t count = 0;
		void push(std::uint32_t i) { candidate[count++] = i; }
		const std::uint32_t* begin() const { return candidate.data(); }
		const std::uint32_t* end() const { return candidate.data() + count; }
	};
	using Indices = std::vector<std::uint32_t>;
	struct Match
	{
		double squared;  // mismatch
		std::uint32_t candidate;
	};
	struct Group
	{
		Indices candidates;
		Indices pairs;  // those not clipped when the seeds were found
	};
	// Which of the old points are near a place, as bits.
	class PlaceSlabs
	{
	public:
		void start(double limit);
		void add(std::uint32_t bit, const Vec3& place);
		// Of all places within the limit, and maybe a few more.
		std::uint32_t near(const Vec3& place) const;

	private:
		static constexpr std::int64_t kCount = 256;
		std::int64_t slabOf(double x) const;
		double m_limit = 1;
		std::array<std::array<std::uint32_t, kCount>, 3> m_bits{};
	};

	const ContactPoint& candidate(std::uint32_t i) const { return m_pool->points()[i]; }
	const PairEstimate& pair(std::uint32_t i) const { return m_pool->pairs()[i]; }
	bool mayBeChosen(std::uint32_t pair) const { return !m_pool->isClipped(pair) && m_pool->pairs()[pair].isLikely; }
	bool isLower(std::uint32_t i, std::uint32_t j) const;
	const ClusterPoint& oldPoint(std::uint32_t old) const
	{
		return m_previous->slots[old / kClusterPoints].points[old % kClusterPoints];
	}
	template <class Visit>
	void forEachOld(const Visit& visit) const
	{
		for (std::uint32_t old = 0; old < kMostPoints; ++old)
			if (int(old % kClusterPoints) < m_previous->slots[old / kClusterPoints].count) visit(old);
	}
	double limit() const { return m_rules.matchRadius * m_rules.length; }
	void clip(std::uint32_t pair);
	void admit();
	void join(std::uint32_t candidate);

	double mismatch(const ClusterPoint& old, const ContactPoint& point) const;
	void searchFor(const ClusterPoint& old);
	std::uint32_t nearestKnown(std::uint32_t old) const;
	std::uint32_t nearestTo(std::uint32_t old);
	bool wasInTouch(const ClusterPoint& old) const;

	bool belongs(const Seed& seed, const Vec3& place, const Vec3& normal) const;
	double misfit(const Seed& seed, const Vec3& place, const Vec3& normal) const;
	template <class Counts>
	std::uint8_t bestSeed(const Vec3& place, const Vec3& normal, const Counts& counts) const;
	std::uint8_t coveringSeed(const Vec3& place, const Vec3& normal) const;
	std::uint8_t seedFor(const Vec3& place, const Vec3& normal) const;
	bool isSupported(const Seed& seed);
	void findSeeds();
	void addSeeds(std::array<bool, kMaxClusters>& used);
	void cover();
	void group();

	void choose(std::size_t seed, ClusterSet& next);
	std::uint32_t lowestBelow(double predicted, Group& group);
	double spacingOf(const Group& group) const;
	void remember(int slot, double spacing, Kept& kept);
	void fill(Group& group, double spacing, Kept& kept);
	void link(ClusterSet& next);

	CandidatePool* m_pool = nullptr;
	const ClusterSet* m_previous = nullptr;
	ClusterRules m_rules;
	std::uint32_t m_admitted = 0;  // candidates seen so far
	bool m_isGrouped = false;
	std::vector<char> m_taken;
	PlaceSlabs m_slabs;
	std::array<std::vector<Match>, kMostPoints> m_matches;  // of an old point
	std::array<bool, kMostPoints> m_isSearched{};           // all near an old point were made
	std::vector<Seed> m_seeds;
	static constexpr std::uint8_t kNoSeed = 255;
	// When the last seed was found; of a pair by both of its normals.
	std::vector<std::uint8_t> m_seedOfPoint, m_seedOfPair, m_steepSeedOfPair;
	Indices m_open, m_openPairs;                            // those that no seed covers; the lowest pair last
	std::array<Group, kMaxClusters> m_groups;
	struct Link
	{
		double squared;
		std::uint32_t from, to;
		bool operator<(const Link& other) const
		{
			if (squared != other.squared) return squared < other.squared;
			return to != other.to ? to < other.to : from < other.from;
		}
	};
	std::vector<Link> m_links;
	std::array<std::array<std::uint32_t, kClusterPoints>, kMaxClusters> m_chosen{};
};
}  // namespace clod
