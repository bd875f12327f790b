// SPDX-License-Identifier: Zlib
// What is expected of a pair of nodes, from its contact and its culling volumes.
#include "clod/manifold/CandidatePool.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clod/collide/BoxSeparation.h"

namespace clod
{
namespace
{
// Points of a pair are lower than estimated by hardly more than this share of what tilts: a face of the reference, or
// the whole pair if that is smaller.
constexpr double kTiltShare = 0.1;
constexpr double kBentCosine = 0.7;  // of faces of a patch that meet what is over its nearest one

// The face of a patch that a point near it is over: of a convex one that whose plane it is highest over, else lowest.
const Face& faceBelow(const Hierarchy& hierarchy, const Node& node, const Vec3& point, double& height)
{
	const Face* below = nullptr;
	const double sign = node.curvature > 0 ? 1 : -1;
	for (const Face& face : hierarchy.faces(node))
	{
		const double over = dot(toVec3(face.normal), point) - double(face.offset);
		if (below && sign * over <= sign * height) continue;
		below = &face;
		height = over;
	}
	return *below;
}

// The least height over a face of the corners of a node of the other body that are within reach of a place (all in the
// face's frame, which thereFromHere maps to the other), or `lowest` where none is lower.
double lowestOver(const Face& face, const Hierarchy& other, const Node& node, const Transform& thereFromHere,
				  const Vec3& place, double reach, double lowest)
{
	const Vec3 direction = thereFromHere.rotation * toVec3(face.normal), middle = thereFromHere * place;
	const double offset = double(face.offset) + dot(direction, thereFromHere.translation);
	const HullView hull = other.hull(node);
	for (std::uint32_t i = 0; i < hull.count; ++i)
	{
		const Vec3 corner = hull.vertex(i);
		if (lengthSquared(corner - middle) <= reach * reach) lowest = std::min(lowest, dot(direction, corner) - offset);
	}
	return lowest;
}

// A contact as its reference sees it, in the reference's frame.
struct Side
{
	const Hierarchy &reference, &other;
	const Node &node, &otherNode;
	const OrientedBox& box;  // of the reference's node
	const Transform& otherFromHere;
	Vec3 onOther, carried;  // the other body's nearest point, and how the step carries it
};

double approachTo(const Side& side, const Face& face)
{
	return std::max(0.0, -dot(side.carried, toVec3(face.normal)));
}

// Of the reference's faces that bend away little from this one, the one that the other body approaches fastest.
const Face& steepestFace(const Side& side, const Face& face)
{
	const Face* steepest = &face;
	for (const Face& other : side.reference.faces(side.node))
	{
		if (!(approachTo(side, other) > approachTo(side, *steepest))) continue;
		if (dot(toVec3(other.normal), toVec3(face.normal)) >= kBentCosine) steepest = &other;
	}
	return *steepest;
}

// Of hulls that are apart: fills what the estimate says of heights; apart: the distance of their nearest points.
void estimateHeights(const Side& side, double apart, const PointRules& rules, PairEstimate& estimate)
{
	double height = 0;
	const Face& face = faceBelow(side.reference, side.node, side.onOther, height);
	const Face& steepest = steepestFace(side, face);
	estimate.normal = toVec3(face.normal);
	estimate.steepNormal = toVec3(steepest.normal);
	const double approach = approachTo(side, face);
	estimate.predicted = height - rules.margin - approach;
	estimate.radius += rules.margin + rules.resting + approach;
	const double beside = std::sqrt(std::max(0.0, apart * apart - height * height));
	// Beside the reference the other hull may be lower than where it is nearest, and be carried over the reference
	// there. Prisms widen upwards over convex edges.
	const bool comesOver = beside <= length(side.carried) + std::abs(height) + 2 * rules.resting;
	if (comesOver && beside > rules.resting)
		height = lowestOver(face, side.other, side.otherNode, side.otherFromHere, centerOf(side.box) - side.carried,
							double(side.box.radius) + rules.resting, height);
	estimate.lowest = height - rules.margin - approachTo(side, steepest);
	const double faceSize = 1.5 * double(side.box.radius) / std::sqrt(double(side.node.faceCount));
	const double tilt = kTiltShare * std::min(estimate.radius, faceSize);
	// What is not in touch must end under the reference (PointFilter::keep).
	const bool comesLow =
		height - rules.margin <= rules.resting + tilt || estimate.lowest <= kUnderPatchShare * rules.length + tilt;
	estimate.isLikely = comesLow && comesOver;
}

PairEstimate estimateOf(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const Transform& bFromA,
						const Contact& contact, const PointRules& rules)
{
	const OrientedBox &boxA = a.cullBox(contact.nodeA), &boxB = b.cullBox(contact.nodeB);
	const Node &nodeA = a.node(contact.nodeA), &nodeB = b.node(contact.nodeB);
	PairEstimate estimate;
	const bool aIsSmaller = boxA.radius <= boxB.radius;
	estimate.center = aIsSmaller ? centerOf(boxA) : aFromB * centerOf(boxB);
	estimate.radius = double(aIsSmaller ? boxA.radius : boxB.radius);
	estimate.referenceIsA = referenceIsA(a, nodeA, b, nodeB, rules.length);
	if (contact.upper > 0)
	{
		const Vec3 carried = -rules.motion.timeStep * rules.motion.velocity(contact.pointOnA);  // B, as A sees it
		const double apart = length(contact.pointOnA - contact.pointOnB);
		estimate.place = contact.pointOnA;
		if (estimate.referenceIsA)
			estimateHeights({a, b, nodeA, nodeB, boxA, bFromA, contact.pointOnB, carried}, apart, rules, estimate);
		else
			estimateHeights({b, a, nodeB, nodeA, boxB, aFromB, bFromA * contact.pointOnA, -(bFromA.rotation * carried)},
							apart, rules, estimate);
	}
	else
	{
		estimate.place = estimate.center;
		estimate.normal = estimate.steepNormal = toVec3((estimate.referenceIsA ? nodeA : nodeB).meanNormal);
		estimate.predicted = estimate.lowest = -std::numeric_limits<double>::infinity();
	}
	// Normals point from B to A.
	for (Vec3* normal : {&estimate.normal, &estimate.steepNormal})
		*normal = estimate.referenceIsA ? -*normal : aFromB.rotation * *normal;
	return estimate;
}
}  // namespace

void CandidatePool::start(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
						  const std::vector<Contact>& contacts, const PointRules& rules)
{
	startWithPoints();
	m_clipper.start(a, b, aFromB, rules);
	m_a = &a;
	m_b = &b;
	m_bFromA = inverse(aFromB);
	m_contacts = &contacts;
	for (const Contact& contact : contacts) m_pairs.push_back(estimateOf(a, b, aFromB, m_bFromA, contact, rules));
	m_isClipped.assign(contacts.size(), 0);
	m_unclipped = contacts.size();
}

std::vector<ContactPoint>& CandidatePool::startWithPoints()
{
	m_points.clear();
	m_pairs.clear();
	m_isClipped.clear();
	m_dropped.clear();
	m_unclipped = 0;
	return m_points;
}

bool CandidatePool::isNear(std::uint32_t pair, const PointClipper::Near& near) const
{
	const Contact& contact = (*m_contacts)[pair];
	return boxDistance(m_a->cullBox(contact.nodeA), near.onA) <= near.within &&
		   boxDistance(m_b->cullBox(contact.nodeB), m_bFromA * near.onB) <= near.withinOther;
}

void CandidatePool::clip(std::uint32_t pair, const PointClipper::Near* near)
{
	if (!near)
	{
		m_isClipped[pair] = 1;
		--m_unclipped;
	}
	m_clipper.clip((*m_contacts)[pair], m_pairs[pair].referenceIsA, near, m_points);
}

void CandidatePool::clipAsBefore(const ContactPoint& before)
{
	const auto nodesOf = [](const auto& pair) { return std::pair(pair.nodeA, pair.nodeB); };
	if (m_pairs.empty()) return;
	const auto found = std::lower_bound(m_contacts->begin(), m_contacts->end(), before,
										[&](const Contact& contact, const ContactPoint& point)
										{ return nodesOf(contact) < nodesOf(point); });
	if (found == m_contacts->end() || nodesOf(*found) != nodesOf(before)) return;
	m_clipper.clipFaces(*found, m_pairs[std::size_t(found - m_contacts->begin())].referenceIsA, before.faceA,
						before.faceB, m_points);
}

bool CandidatePool::isDropped(std::uint32_t point) const
{
	const auto isSame = [&](std::uint32_t dropped)
	{
		const ContactPoint &l = m_points[point], &r = m_points[dropped];
		return l.faceA == r.faceA && l.faceB == r.faceB && l.pointOnA == r.pointOnA;
	};
	return std::any_of(m_dropped.begin(), m_dropped.end(), isSame);
}
}  // namespace clod
