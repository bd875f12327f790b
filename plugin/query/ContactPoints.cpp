// SPDX-License-Identifier: Zlib
// One-way face clipping of node pairs.
#include "clod/query/ContactPoints.h"

#include <algorithm>
#include <utility>

namespace clod
{
namespace
{
struct Bounds
{
	Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
	void add(const Vec3& p)
	{
		low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
		high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
	}
	void grow(double by)
	{
		low -= Vec3{by, by, by};
		high += Vec3{by, by, by};
	}
};

// No point within a radius of the center is carried farther in the step.
double farthestCarried(const PointFilter& filter, const Vec3& center, double radius)
{
	const double speed = length(filter.otherMotion.velocity(center)) + length(filter.otherMotion.angular) * radius;
	return speed * filter.otherMotion.timeStep;
}

// Is all of a box, where it is and where it is carried, beyond one side of the prism?
bool isBeside(const FacePrism& prism, const Vec3& center, const Vec3& half, double carried)
{
	for (std::size_t i = 0; i < 3; ++i)
	{
		const Vec3& side = prism.side[i];
		const double extent = half.x * std::abs(side.x) + half.y * std::abs(side.y) + half.z * std::abs(side.z);
		if (dot(side, center) - extent - carried > prism.sideOffset[i]) return true;
	}
	return false;
}

// Farthest a point of the node can move over the reference in the step, and the largest height worth looking at.
double speculativeReach(const PointFilter& filter, const Vec3& center, double radius)
{
	return filter.rules->margin + filter.rules->resting + kPredictionSlack * farthestCarried(filter, center, radius);
}

Bounds boundsOf(const Hierarchy& hierarchy, const Node& node)
{
	Bounds bounds;
	const HullView hull = hierarchy.hull(node);
	for (std::uint32_t i = 0; i < hull.count; ++i) bounds.add(hull.vertex(i));
	return bounds;
}

double deepest(const Hierarchy& hierarchy, const Node& node)
{
	double thickness = 0;
	for (const Face& face : hierarchy.faces(node)) thickness = std::max(thickness, double(face.thickness));
	return thickness;
}

// Lazily the planes of the node's faces, as (normal, offset) pairs for PointFilter::keep.
struct PatchPlanes
{
	const Face* data;
	std::size_t count;
	struct Iterator
	{
		const Face* face;
		std::pair<Vec3, double> operator*() const { return {toVec3(face->normal), double(face->offset)}; }
		Iterator& operator++()
		{
			++face;
			return *this;
		}
		bool operator!=(const Iterator& other) const { return face != other.face; }
	};
	Iterator begin() const { return {data}; }
	Iterator end() const { return {data + count}; }
};
}  // namespace

double PointFilter::topFor(const FacePrism& prism, const Vec3& near, double reach) const
{
	const double approach = -dot(otherMotion.velocity(near), prism.normal) + length(otherMotion.angular) * reach;
	return rules->margin + rules->resting + kPredictionSlack * std::max(0.0, approach * otherMotion.timeStep);
}

struct PointClipper::Side
{
	const Hierarchy& hierarchy;
	std::uint32_t node;
	bool isA;
};

namespace
{
// Is A's patch the reference? The less convex one; ties by border angles, then by content, so that exchanging the
// bodies exchanges the roles.
bool referenceIsA(const Hierarchy& a, const Node& nodeA, const Hierarchy& b, const Node& nodeB, double radius)
{
	const double tie = kTieCurvature / radius;
	const double difference = double(nodeA.curvature) - double(nodeB.curvature);
	if (std::abs(difference) > tie) return difference < 0;
	const double bend = bendWithBorder(a, nodeA) - bendWithBorder(b, nodeB);
	if (std::abs(bend) > tie) return bend < 0;
	return a.contentHash() <= b.contentHash();
}
}  // namespace

void PointClipper::clip(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB,
						const std::vector<Contact>& contacts, const PointRules& rules,
						std::vector<ContactPoint>& points)
{
	m_rules = &rules;
	m_aFromB = aFromB;
	for (Prepared& prepared : m_prepared) prepared.moved = prepared.reference = kNone;
	for (const Contact& contact : contacts)
	{
		const Side sideA{a, contact.nodeA, true}, sideB{b, contact.nodeB, false};
		const bool aIsReference = referenceIsA(a, a.node(contact.nodeA), b, b.node(contact.nodeB), rules.length);
		if (aIsReference)
			clipPair(sideA, sideB, points);
		else
			clipPair(sideB, sideA, points);
	}
}

MovedPatch& PointClipper::moved(const Side& other, const Transform& intoReference, const RelativeMotion& motion)
{
	Prepared& prepared = m_prepared[other.node % kPrepared];
	if (prepared.moved != other.node || prepared.movedIsOfA != other.isA)
	{
		prepared.moved = other.node;
		prepared.movedIsOfA = other.isA;
		prepared.patch.move(other.hierarchy, other.hierarchy.node(other.node), intoReference, motion);
	}
	return prepared.patch;
}

PointClipper::Prisms& PointClipper::prismsOf(const Side& reference)
{
	Prepared& prepared = m_prepared[reference.node % kPrepared];
	if (prepared.reference != reference.node || prepared.referenceIsOfA != reference.isA)
	{
		prepared.reference = reference.node;
		prepared.referenceIsOfA = reference.isA;
		const std::size_t faces = reference.hierarchy.node(reference.node).faceCount;
		prepared.prisms.of.resize(faces);
		prepared.prisms.isKnown.assign(faces, 0);
	}
	return prepared.prisms;
}

void PointClipper::clipPair(const Side& reference, const Side& other, std::vector<ContactPoint>& points)
{
	const Transform referenceFromOther = reference.isA ? m_aFromB : inverse(m_aFromB);
	PointFilter filter{m_rules, {}};
	if (reference.isA)
		filter.otherMotion = {-m_rules->motion.linear, -m_rules->motion.angular, m_rules->motion.timeStep};
	else
		filter.otherMotion = inFrame(m_rules->motion, m_aFromB);

	const Node& node = reference.hierarchy.node(reference.node);
	const CullBox& otherBox = other.hierarchy.cullBox(other.node);
	const Vec3 otherCenter = referenceFromOther * toVec3(otherBox.center);
	const double reach = speculativeReach(filter, otherCenter, double(otherBox.radius));
	Bounds near = boundsOf(reference.hierarchy, node);
	near.grow(std::max(reach, deepest(reference.hierarchy, node)));
	const Node& otherNode = other.hierarchy.node(other.node);
	MovedPatch& patch = moved(other, referenceFromOther, filter.otherMotion);
	if (!patch.keepNear(near.low, near.high)) return;
	Prisms& prisms = prismsOf(reference);

	const PatchPlanes under{reference.hierarchy.faces().data + node.firstFace, node.faceCount};
	const Vec3 center = 0.5 * (patch.low() + patch.high()), half = 0.5 * (patch.high() - patch.low());
	const double rounding = 1e-9 * (length(center) + length(half));
	const double carried = farthestCarried(filter, center, length(half)) + rounding;
	for (std::uint32_t i = 0; i < node.faceCount; ++i)
	{
		const Face& face = reference.hierarchy.faces()[node.firstFace + i];
		const Vec3 normal = toVec3(face.normal);
		const double middle = dot(normal, center) - double(face.offset);
		const double extent = half.x * std::abs(normal.x) + half.y * std::abs(normal.y) + half.z * std::abs(normal.z);
		if (middle - extent > reach || middle + extent < -double(face.thickness)) continue;
		if (!prisms.isKnown[i])
		{
			prisms.isKnown[i] = 1;
			prisms.of[i] = prismOf(reference.hierarchy, node, face);
		}
		FacePrism prism = prisms.of[i];
		prism.top = filter.topFor(prism, center, length(half));
		if (middle - extent > prism.top || isBeside(prism, center, half, carried)) continue;
		const auto clip = [&](std::uint32_t j, const Triangle& triangle, const Triangle& carriedTo)
		{
			const auto emit = [&](const Vec3& point, double height, double predicted)
			{
				ContactPoint out{};
				const Vec3 onReference = point - height * normal;
				out.height = height - m_rules->margin;
				out.predicted = predicted;
				out.referenceIsA = reference.isA;
				out.atBottom = atBottom(prism, height);
				out.pointOnA = reference.isA ? onReference : m_aFromB * point;
				out.pointOnB = reference.isA ? point : m_aFromB * onReference;
				out.normal = reference.isA ? -normal : m_aFromB.rotation * normal;
				out.nodeA = reference.isA ? reference.node : other.node;
				out.nodeB = reference.isA ? other.node : reference.node;
				out.faceA = reference.isA ? node.firstFace + i : otherNode.firstFace + j;
				out.faceB = reference.isA ? otherNode.firstFace + j : node.firstFace + i;
				points.push_back(out);
			};
			filter.visit(prism, triangle, carriedTo, under, emit);
		};
		patch.visitMeeting(prism, filter.stepCounts(prism), filter.arrivalTop(), clip);
	}
}
}  // namespace clod
