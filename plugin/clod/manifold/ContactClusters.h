// SPDX-License-Identifier: Zlib
// From thousands of possible points to a few clusters of at most four: points that continue those of the step before
// (ContactMemory.h), where nothing is clearly lower, then low ones far from each other.
//
// Pairs of nodes whose estimates are nowhere chosen are never clipped (CandidatePool.h): once contacts last, most.
//
// Frame A, unit of the hierarchies. A pure function of the pool's pairs and points and of the previous set.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/ContactMemory.h"

namespace clod
{
// Reduces candidates to clusters. Buffers only.
class CLOD_API ContactReducer
{
public:
	// Clips those pairs of the pool whose points may be chosen.
	void reduce(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules, ClusterSet& next);
	// Candidate behind each point of the last reduction, by slot and index.
	std::uint32_t candidateOf(int slot, int index) const { return m_chosen[std::size_t(slot)][std::size_t(index)]; }

private:
	struct Seed
	{
		Vec3 normal, center;
		int slot;
	};
	using Indices = std::vector<std::uint32_t>;
	struct Group
	{
		Indices candidates;
		Indices pairs;  // those not clipped when the seeds were found
	};
	const ContactPoint& candidate(std::uint32_t i) const { return m_pool->points()[i]; }
	const PairEstimate& pair(std::uint32_t i) const { return m_pool->pairs()[i]; }
	bool mayBeChosen(std::uint32_t pair) const { return !m_pool->isClipped(pair) && m_pool->pairs()[pair].isLikely; }
	bool isLower(std::uint32_t i, std::uint32_t j) const;
	bool belongs(const Seed& seed, const Vec3& place, const Vec3& normal) const;
	double misfit(const Seed& seed, const Vec3& place, const Vec3& normal) const;
	template <class Counts>
	std::uint8_t bestSeed(const Vec3& place, const Vec3& normal, const Counts& counts) const;
	std::uint8_t coveringSeed(const Vec3& place, const Vec3& normal) const;
	std::uint8_t seedFor(const Vec3& place, const Vec3& normal) const;
	bool isSupported(const Seed& seed);
	void findSeeds(const ClusterSet& previous);
	void addSeeds(std::array<bool, kMaxClusters>& used);
	void cover();
	void joinNew();
	void group();

	void choose(std::size_t seed, ClusterSet& next);
	std::uint32_t lowestBelow(double predicted, Group& group);
	double spacingOf(const Group& group) const;
	void fill(Group& group, double spacing, ChosenPoints& kept);

	CandidatePool* m_pool = nullptr;
	ClusterRules m_rules;
	ContactMemory m_memory;
	std::vector<Seed> m_seeds;
	static constexpr std::uint8_t kNoSeed = 255;
	// When the last seed was found; of a pair by both of its normals.
	std::vector<std::uint8_t> m_seedOfPoint, m_seedOfPair, m_steepSeedOfPair;
	Indices m_open, m_openPairs;  // those that no seed covers; the lowest pair last
	std::array<Group, kMaxClusters> m_groups;
	std::uint32_t m_joined = 0;  // candidates that are in a group
	std::array<std::array<std::uint32_t, kClusterPoints>, kMaxClusters> m_chosen{};
};
}  // namespace clod
