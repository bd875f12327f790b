// SPDX-License-Identifier: Zlib
// One-way face clipping of node pairs.
#include "clod/manifold/ContactPoints.h"

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
	bool contains(const Vec3& p) const
	{
		return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z;
	}
	void grow(double by)
	{
		low -= Vec3{by, by, by};
		high += Vec3{by, by, by};
	}
	// To what is about a point.
	void cut(const Vec3& p, double by)
	{
		low = {std::max(low.x, p.x - by), std::max(low.y, p.y - by), std::max(low.z, p.z - by)};
		high = {std::min(high.x, p.x + by), std::min(high.y, p.y + by), std::min(high.z, p.z + by)};
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

bool referenceIsA(const Hierarchy& a, const Node& nodeA, const Hierarchy& b, const Node& nodeB, double length)
{
	const double tie = kTieCurvature / length;
	const double difference = double(nodeA.curvature) - double(nodeB.curvature);
	if (std::abs(difference) > tie) return difference < 0;
	const double bend = bendWithBorder(a, nodeA) - bendWithBorder(b, nodeB);
	if (std::abs(bend) > tie) return bend < 0;
	return a.contentHash() <= b.contentHash();
}

void PointClipper::start(const Hierarchy& a, const Hierarchy& b, const Transform& aFromB, const PointRules& rules)
{
	m_rules = rules;
	m_aFromB = aFromB;
	const RelativeMotion& motion = rules.motion;
	m_roles[0] = {&a, &b, aFromB, {&m_rules, {-motion.linear, -motion.angular, motion.timeStep}}, true};
	m_roles[1] = {&b, &a, inverse(aFromB), {&m_rules, inFrame(motion, aFromB)}, false};
	for (Prepared& prepared : m_prepared) prepared.moved = prepared.reference = kNone;
}

MovedPatch& PointClipper::moved(const Pair& pair)
{
	Prepared& prepared = m_prepared[pair.otherIndex % kPrepared];
	if (prepared.moved != pair.otherIndex || prepared.movedIsOfA == pair.role.isA)
	{
		prepared.moved = pair.otherIndex;
		prepared.movedIsOfA = !pair.role.isA;
		prepared.patch.move(*pair.role.other, pair.other, pair.role.referenceFromOther, pair.role.filter.otherMotion);
	}
	return prepared.patch;
}

PointClipper::Prepared& PointClipper::preparedReference(const Pair& pair)
{
	Prepared& prepared = m_prepared[pair.nodeIndex % kPrepared];
	if (prepared.reference != pair.nodeIndex || prepared.referenceIsOfA != pair.role.isA)
	{
		prepared.reference = pair.nodeIndex;
		prepared.referenceIsOfA = pair.role.isA;
		prepared.prisms.resize(pair.node.faceCount);
		prepared.isKnown.assign(pair.node.faceCount, 0);
		const Bounds bounds = boundsOf(*pair.role.reference, pair.node);
		prepared.low = bounds.low;
		prepared.high = bounds.high;
		prepared.deepest = deepest(*pair.role.reference, pair.node);
	}
	return prepared;
}

const FacePrism& PointClipper::prismOfFace(const Pair& pair, Prepared& prepared, std::uint32_t face) const
{
	if (!prepared.isKnown[face])
	{
		prepared.isKnown[face] = 1;
		const Hierarchy& reference = *pair.role.reference;
		prepared.prisms[face] = prismOf(reference, pair.node, reference.faces()[pair.node.firstFace + face]);
	}
	return prepared.prisms[face];
}

void PointClipper::chooseFaces(const Pair& pair, Prepared& prepared, const Near* near)
{
	m_faces.clear();
	Vec3 place;
	if (near) place = pair.role.isA ? near->onA : pair.role.referenceFromOther * near->onB;
	const Hierarchy& reference = *pair.role.reference;
	for (std::uint32_t i = 0; i < pair.node.faceCount; ++i)
	{
		if (near)
		{
			// Prisms are dearer than boxes.
			Bounds bounds;
			for (const Vec3& corner : triangleOf(reference, pair.node, reference.faces()[pair.node.firstFace + i]))
				bounds.add(corner);
			bounds.grow(near->within + near->withinOther);
			if (!bounds.contains(place) || prismOfFace(pair, prepared, i).besideBy(place) > near->within) continue;
		}
		m_faces.push_back(i);
	}
}

PointClipper::Pair PointClipper::pairOf(const Contact& contact, bool referenceIsA) const
{
	const Role& role = m_roles[referenceIsA ? 0 : 1];
	const std::uint32_t node = referenceIsA ? contact.nodeA : contact.nodeB;
	const std::uint32_t other = referenceIsA ? contact.nodeB : contact.nodeA;
	return {role, node, other, role.reference->node(node), role.other->node(other)};
}

// Emits the points over one of the reference's faces; visitFaces(prism, visit) tells the faces of the patch.
template <class Visit>
void PointClipper::clipFace(const Pair& pair, const MovedPatch& patch, FacePrism prism, std::uint32_t face,
							const Near* near, const Visit& visitFaces, std::vector<ContactPoint>& points) const
{
	const Role& role = pair.role;
	prism.top = role.filter.topFor(prism, patch.center(), patch.radius());
	const PatchPlanes under{role.reference->faces().data + pair.node.firstFace, pair.node.faceCount};
	const auto clip = [&](std::uint32_t j, const Triangle& triangle, const Triangle& carriedTo)
	{
		const auto emit = [&](const Vec3& point, double height, double predicted)
		{
			const Vec3 onReference = point - height * prism.normal;
			const Vec3 pointOnA = role.isA ? onReference : m_aFromB * point;
			if (near && lengthSquared(pointOnA - near->onA) > near->limit * near->limit) return;
			ContactPoint out{};
			out.height = height - m_rules.margin;
			out.predicted = predicted;
			out.referenceIsA = role.isA;
			out.atBottom = atBottom(prism, height);
			out.pointOnA = pointOnA;
			out.pointOnB = role.isA ? point : m_aFromB * onReference;
			out.normal = role.isA ? -prism.normal : m_aFromB.rotation * prism.normal;
			out.nodeA = role.isA ? pair.nodeIndex : pair.otherIndex;
			out.nodeB = role.isA ? pair.otherIndex : pair.nodeIndex;
			out.faceA = role.isA ? pair.node.firstFace + face : pair.other.firstFace + j;
			out.faceB = role.isA ? pair.other.firstFace + j : pair.node.firstFace + face;
			points.push_back(out);
		};
		role.filter.visit(prism, triangle, carriedTo, under, emit);
	};
	visitFaces(prism, clip);
}

void PointClipper::clip(const Contact& contact, bool referenceIsA, const Near* near, std::vector<ContactPoint>& points)
{
	const Pair pair = pairOf(contact, referenceIsA);
	const Role& role = pair.role;
	Prepared& prepared = preparedReference(pair);
	chooseFaces(pair, prepared, near);
	if (m_faces.empty()) return;

	MovedPatch& patch = moved(pair);
	const double reach = speculativeReach(role.filter, patch.center(), patch.radius());
	Bounds around{prepared.low, prepared.high};
	around.grow(std::max(reach, prepared.deepest));
	if (near) around.cut(role.isA ? near->onB : role.referenceFromOther * near->onA, near->withinOther);
	if (!patch.keepNear(around.low, around.high)) return;

	const Vec3 center = 0.5 * (patch.low() + patch.high()), half = 0.5 * (patch.high() - patch.low());
	const double rounding = 1e-9 * (length(center) + length(half));
	const double carried = farthestCarried(role.filter, center, length(half)) + rounding;
	for (const std::uint32_t i : m_faces)
	{
		const Face& face = role.reference->faces()[pair.node.firstFace + i];
		const Vec3 normal = toVec3(face.normal);
		const double middle = dot(normal, center) - double(face.offset);
		const double extent = half.x * std::abs(normal.x) + half.y * std::abs(normal.y) + half.z * std::abs(normal.z);
		if (middle - extent > reach || middle + extent < -double(face.thickness)) continue;
		const FacePrism& prism = prismOfFace(pair, prepared, i);
		if (isBeside(prism, center, half, carried)) continue;
		const auto meeting = [&](const FacePrism& over, const auto& visit)
		{ patch.visitMeeting(over, role.filter.stepCounts(over), role.filter.arrivalTop(), visit); };
		clipFace(pair, patch, prism, i, near, meeting, points);
	}
}

void PointClipper::clipFaces(const Contact& contact, bool referenceIsA, std::uint32_t faceA, std::uint32_t faceB,
							 std::vector<ContactPoint>& points)
{
	const Pair pair = pairOf(contact, referenceIsA);
	const std::uint32_t face = (referenceIsA ? faceA : faceB) - pair.node.firstFace;
	const std::uint32_t other = (referenceIsA ? faceB : faceA) - pair.other.firstFace;
	MovedPatch& patch = moved(pair);
	const auto one = [&](const FacePrism& over, const auto& visit) { patch.visitFace(other, over, visit); };
	clipFace(pair, patch, prismOfFace(pair, preparedReference(pair), face), face, nullptr, one, points);
}
}  // namespace clod
