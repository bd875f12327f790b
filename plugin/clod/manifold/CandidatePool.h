// SPDX-License-Identifier: Zlib
// The candidate points of two bodies, made only where they may count: a pair of nodes is clipped once it is asked for.
// Until then an estimate stands for its points, so that whoever chooses among points clips a pair when the estimate
// would be chosen, and looks again.
//
// Frame A, unit of the hierarchies; signs as in ContactPoints.h.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
// What is known of the points of a pair of nodes before they are made.
struct PairEstimate
{
	Vec3 place;   // where the two are nearest, on A
	Vec3 normal;  // there; unit, from B to A
	// As ContactPoint::predicted, there; minus infinity where hulls overlap: its points may be as deep as they like.
	double predicted = 0;
	// The normal of the reference's face that the other body approaches fastest, of those that bend away little; what
	// the step carries over it may be predicted so low.
	Vec3 steepNormal;
	double lowest = 0;
	bool isLikely = true;  // to have points at all
	bool referenceIsA = true;
	Vec3 center;  // of a ball that holds them
	double radius = 0;
};

class CLOD_API CandidatePool
{
public:
	// Of node pairs within the tolerance, none of them clipped. What is pointed to must live while pairs are clipped.
	void start(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const std::vector<Contact>& contacts,
			   const PointRules& rules);
	// Of no pairs: for points made elsewhere, to be appended to what is returned.
	std::vector<ContactPoint>& startWithPoints();

	// In the order they were made.
	const std::vector<ContactPoint>& points() const { return m_points; }
	// No longer a candidate, nor when it comes again.
	void drop(std::uint32_t point) { m_dropped.push_back(point); }
	bool isDropped(std::uint32_t point) const;
	// Pairs by their index in the contacts.
	const std::vector<PairEstimate>& pairs() const { return m_pairs; }
	// Do the culling volumes of its nodes come so near to places on A and B (frame A)?
	bool isNear(std::uint32_t pair, const PointClipper::Near& near) const;
	bool isClipped(std::uint32_t pair) const { return m_isClipped[pair] != 0; }
	// Appends the pair's points; if a place is given, those only of faces near it, and they may come again.
	// Precondition: it is not clipped.
	void clip(std::uint32_t pair, const PointClipper::Near* near = nullptr);
	// Those only of the pair and the faces that made another point, in another pose; none where it is no pair any
	// more.
	void clipAsBefore(const ContactPoint& before);
	bool isEmpty() const { return m_points.empty() && m_unclipped == 0; }

private:
	PointClipper m_clipper;
	const Hierarchy *m_a = nullptr, *m_b = nullptr;
	Transform m_bFromA;
	const std::vector<Contact>* m_contacts = nullptr;
	std::vector<ContactPoint> m_points;
	std::vector<PairEstimate> m_pairs;
	std::vector<char> m_isClipped;
	std::vector<std::uint32_t> m_dropped;
	std::size_t m_unclipped = 0;
};
}  // namespace clod
