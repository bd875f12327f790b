// SPDX-License-Identifier: Zlib
// The contact points of the step before, and which of the new candidates continue them. This memory is what makes
// contacts rest (it cuts jitter five to ten times) and carries impulses across steps, levels of detail and changes of
// reference.
//
// A point goes on as the nearest candidate of where it was or where B has carried it: of the two faces that made it
// first, then, where it had been in touch, of all faces near where it would be now.
//
// Frame A, unit of the hierarchies.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/CandidatePool.h"

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
struct CLOD_API ClusterSet
{
	std::array<ContactCluster, kMaxClusters> slots{};
	void clear() { slots = {}; }
	int pointCount() const;
};

// Fills placeWithB and normalWithB: a corner of B that slides over A is the same point although it moves in A's frame.
// bodyMotion maps B's material of the last step to now, both in frame A.
CLOD_API void carryWithB(ClusterSet& set, const Transform& bodyMotion);

// All shares of the length unless named otherwise.
struct ClusterRules
{
	double length = 1, margin = 0;  // lengths, as in PointRules
	double tolerance = 0.001;       // heights within it of the lowest are equally good; up to it points are in touch
	// Of the memory.
	double matchRadius = 0.004;   // how far a remembered point may move
	double searchRadius = 0.001;  // how far from it faces are looked for that may have it now
	double matchNormal = 0.05;    // length one unit of normal change counts for
	double matchCosine = 0.866;   // 30 degrees
	// Of the choice (ContactClusters.h).
	double clusterCosine = 0.906;  // 25 degrees between a cluster's normal and its points'
	double clusterRadius = 0.25;
	double enterShare = 0.3;  // the lowest candidate replaces memory only if lower by this share of the tolerance
	double spacing = 0.001;   // least distance of two points of a cluster
	double spacingOfExtent = 0.15;
};

// Candidates chosen for one cluster: those remembered first.
struct ChosenPoints
{
	std::array<std::uint32_t, kClusterPoints> candidate{};
	std::size_t count = 0;
	void push(std::uint32_t i) { candidate[count++] = i; }
	const std::uint32_t* begin() const { return candidate.data(); }
	const std::uint32_t* end() const { return candidate.data() + count; }
};

// Buffers only.
class ContactMemory
{
public:
	// Makes the candidates that may continue the previous points. Pool and set must live as long as they are asked
	// about.
	void start(CandidatePool& pool, const ClusterSet& previous, const ClusterRules& rules);
	// Takes the candidates that continue a slot's points, strong ones first, none nearer than the spacing to one kept.
	// More may be made on the way.
	void remember(int slot, double spacing, ChosenPoints& kept);
	// What is taken continues no other point.
	void take(std::uint32_t candidate);
	bool isTaken(std::uint32_t candidate) const { return candidate < m_taken.size() && m_taken[candidate]; }
	// Each new point continues the nearest old one, of any cluster, that no other point has claimed.
	void link(ClusterSet& next);

private:
	static constexpr std::uint32_t kMostPoints = kMaxClusters * kClusterPoints;
	struct Match
	{
		double squared;  // mismatch
		std::uint32_t candidate;
	};
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

	// Old points by cluster * kClusterPoints + index.
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
	bool wasInTouch(const ClusterPoint& old) const;
	double mismatch(const ClusterPoint& old, const ContactPoint& point) const;
	void admit();
	std::uint32_t nearestKnown(std::uint32_t old);
	std::uint32_t nearestTo(std::uint32_t old);
	void searchFor(const ClusterPoint& old);

	CandidatePool* m_pool = nullptr;
	const ClusterSet* m_previous = nullptr;
	ClusterRules m_rules;
	PlaceSlabs m_slabs;
	std::uint32_t m_admitted = 0;                           // candidates compared with the old points
	std::array<std::vector<Match>, kMostPoints> m_matches;  // of an old point
	std::array<bool, kMostPoints> m_isSearched{};           // all near an old point were made
	std::vector<char> m_taken;
	std::vector<Link> m_links;
};
}  // namespace clod
