// SPDX-License-Identifier: Zlib
#include "clod/manifold/PartnerContacts.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "clod/collide/HullDistance.h"
#include "clod/query/Constants.h"

namespace clod
{
namespace
{
// Interval of dot(direction, p) over the box.
std::pair<double, double> interval(const OrientedBox& box, const Vec3& direction)
{
	const double middle = dot(direction, toVec3(box.center));
	double extent = 0;
	for (int i = 0; i < 3; ++i) extent += double(box.half[i]) * std::abs(dot(direction, toVec3(box.axis[i])));
	return {middle - extent, middle + extent};
}

// A triangle, frame A.
struct MovedTriangle
{
	Triangle corners;
	Vec3 normal;
	double offset;
	MovedTriangle(const NearTriangles& triangles, std::size_t index, const Transform& aFromB)
		: corners(triangles.corners[index]), normal(aFromB.rotation * triangles.normals[index])
	{
		for (Vec3& corner : corners) corner = aFromB * corner;
		offset = dot(normal, corners[0]);
	}
};

// How far apart they are along the box's axes and the triangle's normal: the largest, or the first that exceeds `enough`.
double separation(const OrientedBox& box, const MovedTriangle& triangle, double enough)
{
	const Vec3 center = toVec3(box.center);
	const Vec3 a = triangle.corners[0] - center, b = triangle.corners[1] - center, c = triangle.corners[2] - center;
	double most = -std::numeric_limits<double>::infinity();
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 axis = toVec3(box.axis[i]);
		const double atA = dot(axis, a), atB = dot(axis, b), atC = dot(axis, c);
		const double low = std::min(std::min(atA, atB), atC), high = std::max(std::max(atA, atB), atC);
		most = std::max(most, std::max(low, -high) - double(box.half[i]));
		if (most > enough) return most;
	}
	const auto [low, high] = interval(box, triangle.normal);
	return std::max(most, std::max(low - triangle.offset, triangle.offset - high));
}

// A triangle swept downwards, as far as what has sunk through it may lie beneath it; for its distance from nodes' hulls.
class SunkTriangle
{
public:
	// radius: of the hulls, about frame A.
	SunkTriangle(const Triangle& triangle, const Vec3& beneath, double radius) : m_beneath(beneath)
	{
		const Vec3 middle = (1.0 / 3) * (triangle[0] + triangle[1] + triangle[2]);
		double farthest = 0;
		for (std::size_t i = 0; i < kVertexLanes; ++i)
		{
			const Vec3 corner = triangle[std::min<std::size_t>(i, 2)] - middle;
			m_x[i] = float(corner.x), m_y[i] = float(corner.y), m_z[i] = float(corner.z);
			farthest = std::max(farthest, length(corner));
		}
		m_rounded = kRootOf3 * kFloatUnit * farthest;
		m_pose = RelativePose({Mat3{}, middle}, std::max(radius, farthest));
	}
	// Certified lower bound of the distance to a hull; the search stops once that is beyond `most`.
	double distanceTo(const ConvexHull& hull, const Vec3& center, double most) const
	{
		const ConvexHull triangle{{m_x, m_y, m_z, 3, kVertexLanes}, {}};
		const Vec3 start = center - m_pose.translation;
		return hullDistance(hull, triangle, m_pose, start, most + m_rounded, m_beneath).lower - m_rounded;
	}

private:
	alignas(16) float m_x[kVertexLanes], m_y[kVertexLanes], m_z[kVertexLanes];
	Vec3 m_beneath;
	RelativePose m_pose;
	double m_rounded;
};

}  // namespace

// May a node answer against an exact partner? This is the rule of StopRule.h with f = 0 and D = inf on the partner's
// side; the place of the contact is taken to be in the node's own culling box.
class PartnerContacts::Rule
{
public:
	Rule(const Hierarchy& hierarchy, const Metric& metric)
		: m_hierarchy(hierarchy), m_metric(metric), m_threshold(metric, fastest(hierarchy, metric))
	{
	}

	bool accepts(std::uint32_t index, const Node& node) const
	{
		if (node.level == 0) return true;
		if (m_metric.exact || (node.flags & kClodNode) == 0) return false;
		const OrientedBox& box = m_hierarchy.cullBox(index);
		const double s0 = m_threshold.isConstant() ? m_threshold.constant()
												   : m_threshold.at({toVec3(box.center), double(box.radius)});
		const double deviation = node.featureVolume > 0 ? double(node.featureVolume) / double(node.contactArea) : 0;
		return deviation <= s0 && std::max(double(node.cover), double(node.protrude)) <= m_metric.maxError;
	}
	bool isExact() const { return m_metric.exact; }

private:
	static double fastest(const Hierarchy& hierarchy, const Metric& metric)
	{
		const Asset& asset = hierarchy.asset();
		const Vec3& turning = metric.velocity.angular;
		return length(metric.velocity.linear + cross(turning, toVec3(asset.sphereCenter))) +
			   length(turning) * double(asset.radius);
	}

	const Hierarchy& m_hierarchy;
	const Metric& m_metric;
	const Threshold m_threshold;
};

// Visits the nodes that answer and are not separated from the partner, each once. Exact answers follow the tree of
// bounding volumes, coarser ones the whole graph of the dual hierarchy.
template <class Separated, class Answer>
void PartnerContacts::visit(const Hierarchy& hierarchy, const Rule& rule, const Separated& apart, const Answer& answer,
							PartnerStats& stats)
{
	if (m_visited.size() < hierarchy.nodes().size) m_visited.resize(hierarchy.nodes().size, 0);
	if (++m_visit == 0)
	{
		std::fill(m_visited.begin(), m_visited.end(), 0);
		m_visit = 1;
	}
	m_stack.assign(1, hierarchy.root());
	while (!m_stack.empty())
	{
		const std::uint32_t index = m_stack.back();
		m_stack.pop_back();
		if (m_visited[index] == m_visit) continue;
		m_visited[index] = m_visit;
		++stats.boxTests;
		if (apart(hierarchy.cullBox(index))) continue;
		const Node& node = hierarchy.node(index);
		if (rule.accepts(index, node))
		{
			answer(index, node);
			continue;
		}
		const Span<std::uint32_t> children = hierarchy.children(node);
		const std::size_t count = rule.isExact() ? node.primaryChildCount : children.size;
		for (std::size_t i = count; i-- > 0;) m_stack.push_back(children[i]);
	}
}

namespace
{
void addAnswer(std::uint32_t index, const Node& node, std::uint32_t partner, double distance,
			   std::vector<Contact>& contacts, PartnerStats& stats)
{
	++stats.nodes;
	stats.finestLevel = std::min(stats.finestLevel, node.level);
	stats.coarsestLevel = std::max(stats.coarsestLevel, node.level);
	stats.errorBound = std::max({stats.errorBound, double(node.cover), double(node.protrude)});
	contacts.push_back({index, partner, distance, distance, {}, {}, {}});
}
}  // namespace

void PartnerContacts::withHalfSpace(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
									double tolerance, std::vector<Contact>& contacts, PartnerStats& stats)
{
	const auto apart = [&](const OrientedBox& box) { return interval(box, normal).first - offset > tolerance; };
	const auto answer = [&](std::uint32_t index, const Node& node) { addAnswer(index, node, 0, 0, contacts, stats); };
	visit(hierarchy, Rule(hierarchy, metric), apart, answer, stats);
}

void PartnerContacts::withTriangles(const Hierarchy& hierarchy, const NearTriangles& triangles, const Transform& aFromB,
									const SideOf& sideOf, double depth, const Metric& metric, double tolerance,
									std::vector<Contact>& contacts, PartnerStats& stats)
{
	const Rule rule(hierarchy, metric);
	PartnerStats found = stats;
	const std::size_t before = contacts.size();
	bool isNear = false;
	for (std::uint32_t i = 0; i < triangles.corners.size(); ++i)
	{
		if (!triangles.mayMeet[i]) continue;
		const MovedTriangle triangle(triangles, i, aFromB);
		std::optional<SunkTriangle> sunk;  // most triangles meet nothing
		const auto distanceTo = [&](std::uint32_t index, const Node& node, double most)
		{
			if (!sunk)
			{
				const double beneath = sideOf(triangle.normal, triangle.offset) < 0 ? depth : -depth;
				sunk.emplace(triangle.corners, beneath * triangle.normal, hierarchy.originRadius());
			}
			return sunk->distanceTo(contactHull(hierarchy, node), toVec3(hierarchy.cullBox(index).center), most);
		};
		const auto apart = [&](const OrientedBox& box) { return separation(box, triangle, tolerance) > tolerance; };
		const auto answer = [&](std::uint32_t index, const Node& node)
		{
			const double distance = std::max(0.0, distanceTo(index, node, 0));
			isNear = isNear || distance == 0 || distanceTo(index, node, tolerance) <= tolerance;
			addAnswer(index, node, i, distance, contacts, found);
		};
		visit(hierarchy, rule, apart, answer, found);
	}
	if (isNear)
		stats = found;
	else
	{
		contacts.resize(before);
		stats.boxTests = found.boxTests;
	}
}

double PartnerContacts::safeMotion(const Hierarchy& hierarchy, const NearTriangles& triangles, const Transform& aFromB,
								   const Metric& metric, double tolerance, double cap, PartnerStats& stats)
{
	const Rule rule(hierarchy, metric);
	double best = cap, last = 0;
	for (std::uint32_t i = 0; i < triangles.corners.size() && best > 0; ++i)
	{
		const MovedTriangle triangle(triangles, i, aFromB);
		const auto apart = [&](const OrientedBox& box)
		{
			const double limit = tolerance + kShareOfNearest * best;
			last = separation(box, triangle, limit);
			return best <= 0 || last > limit;
		};
		const auto answer = [&](std::uint32_t, const Node&) { best = std::min(best, last - tolerance); };
		visit(hierarchy, rule, apart, answer, stats);
	}
	return best > 0 ? kShareOfNearest * best : best;
}
}  // namespace clod
