// SPDX-License-Identifier: Zlib
// From thousands of candidate points to a few clusters of at most four, which remember last step's points: a point that
// has a candidate near its old place is kept before a better-looking new one. The memory is what makes contacts rest
// (it cuts jitter five to ten times) and carries impulses across steps, levels of detail and changes of reference.
//
// Frame A, unit of the hierarchies. A pure function of the candidates and the previous set.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "clod/query/ContactPoints.h"

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
	double binSize = 0.02;         // one candidate per place and normal takes part (the lowest)
	double clusterCosine = 0.906;  // 25 degrees between a cluster's normal and its points'
	double clusterRadius = 0.25;
	double matchRadius = 0.015;  // how far a remembered point may move
	double matchNormal = 0.05;   // length one unit of normal change counts for
	double matchCosine = 0.866;  // 30 degrees
	double tolerance = 0.001;    // heights within it of the lowest are equally good
	double enterShare = 0.3;     // the lowest candidate replaces memory only if lower by this share of the tolerance
	double spacing = 0.001;      // least distance of two points of a cluster
	double spacingOfExtent = 0.15;
};

// Reduces candidates to clusters. Candidates whose index is flagged in `excluded` are ignored. Buffers only.
class ContactReducer
{
public:
	void reduce(const std::vector<ContactPoint>& candidates, const std::vector<char>& excluded,
				const ClusterSet& previous, const ClusterRules& rules, ClusterSet& next);
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
	using Members = std::vector<std::uint32_t>;
	void binCandidates();
	void matchWithOld(const ClusterSet& previous);
	void findSeeds(const ClusterSet& previous);
	void assign();
	void choose(std::size_t seed, const ClusterSet& previous, ClusterSet& next);
	double spacingOf(const Members& members) const;
	void remember(int slot, const ClusterSet& previous, double spacing, Kept& kept);
	void fill(const Members& members, double spacing, Kept& kept) const;
	void link(const ClusterSet& previous, ClusterSet& next);
	bool belongs(const Seed& seed, const ContactPoint& point, double& score) const;
	double mismatch(const ClusterPoint& old, const ContactPoint& point) const;
	std::uint32_t nearestTo(std::uint32_t old) const;

	const std::vector<ContactPoint>* m_candidates = nullptr;
	const std::vector<char>* m_excluded = nullptr;
	ClusterRules m_rules;
	std::vector<std::uint32_t> m_binned, m_table;
	std::vector<std::uint64_t> m_keys;
	std::vector<Seed> m_seeds;
	std::array<Members, kMaxClusters> m_members;  // of a seed, the lowest first
	std::vector<char> m_taken;
	struct Match
	{
		double squared;  // mismatch
		std::uint32_t candidate;
	};
	std::array<std::vector<Match>, kMostPoints> m_matches;  // of an old point, by candidate
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
