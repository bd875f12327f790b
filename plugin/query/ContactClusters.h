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
	struct Seed
	{
		Vec3 normal, center;
		int slot;
		std::vector<std::uint32_t> members;
	};
	void binCandidates();
	void findSeeds(const ClusterSet& previous);
	void assign();
	void choose(const Seed& seed, const ClusterSet& previous, ClusterSet& next);
	double spacingOf(const Seed& seed) const;
	void remember(const Seed& seed, const ClusterSet& previous, double spacing, std::vector<std::uint32_t>& kept);
	void fill(const Seed& seed, double spacing, std::vector<std::uint32_t>& kept) const;
	void link(const ClusterSet& previous, ClusterSet& next) const;
	bool belongs(const Seed& seed, const ContactPoint& point, double& score) const;
	double mismatch(const ClusterPoint& old, const ContactPoint& point) const;
	std::uint32_t nearestTo(const ClusterPoint& old) const;

	const std::vector<ContactPoint>* m_candidates = nullptr;
	const std::vector<char>* m_excluded = nullptr;
	ClusterRules m_rules;
	std::vector<std::uint32_t> m_binned, m_table;
	std::vector<std::uint64_t> m_keys;
	std::vector<Seed> m_seeds;
	std::vector<char> m_taken;
	struct Place
	{
		Vec3 onA;
		std::uint32_t candidate;
		bool operator<(const Place& other) const
		{
			return onA.x != other.onA.x ? onA.x < other.onA.x : candidate < other.candidate;
		}
	};
	std::vector<Place> m_byX;  // candidates along A's x axis
	std::array<std::array<std::uint32_t, kClusterPoints>, kMaxClusters> m_chosen{};
};
}  // namespace clod
