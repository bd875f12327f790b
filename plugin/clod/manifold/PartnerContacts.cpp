// SPDX-License-Identifier: Zlib
#include "clod/manifold/PartnerContacts.h"

#include <algorithm>
#include <utility>

#include "clod/collide/HullDistance.h"

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

// Farther apart than `distance` along one of the box's axes or the triangle's normal?
bool separated(const OrientedBox& box, const Triangle& triangle, const Vec3& normal, double distance)
{
	const Vec3 center = toVec3(box.center);
	for (int i = 0; i < 3; ++i)
	{
		const Vec3 axis = toVec3(box.axis[i]);
		const double t[3] = {dot(axis, triangle[0] - center), dot(axis, triangle[1] - center),
							 dot(axis, triangle[2] - center)};
		const double low = *std::min_element(t, t + 3), high = *std::max_element(t, t + 3);
		if (low > double(box.half[i]) + distance || high < -double(box.half[i]) - distance) return true;
	}
	const auto [low, high] = interval(box, normal);
	const double offset = dot(normal, triangle[0]);
	return low - offset > distance || offset - high > distance;
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

// May a node answer against an exact partner? This is the rule of StopRule.h with f = 0 and D = inf on the partner's
// side; the place of the contact is taken to be in the node's own culling box.
class PartnerRule
{
public:
	PartnerRule(const Hierarchy& hierarchy, const Metric& metric)
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

}  // namespace

// Visits the nodes that answer and are not separated from the partner, each once. Exact answers follow the tree of
// bounding volumes, coarser ones the whole graph of the dual hierarchy.
template <class Separated, class Distance>
void PartnerContacts::visit(const Hierarchy& hierarchy, const Metric& metric, const Separated& apart,
							const Distance& distanceOf, std::uint32_t partner, std::vector<Contact>& contacts,
							PartnerStats& stats)
{
	if (m_visited.size() < hierarchy.nodes().size) m_visited.resize(hierarchy.nodes().size, 0);
	if (++m_visit == 0)
	{
		std::fill(m_visited.begin(), m_visited.end(), 0);
		m_visit = 1;
	}
	const PartnerRule rule(hierarchy, metric);
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
			++stats.nodes;
			stats.finestLevel = std::min(stats.finestLevel, node.level);
			stats.coarsestLevel = std::max(stats.coarsestLevel, node.level);
			stats.errorBound = std::max({stats.errorBound, double(node.cover), double(node.protrude)});
			const double distance = distanceOf(index, node);
			contacts.push_back({index, partner, distance, distance, {}, {}, {}});
			continue;
		}
		const Span<std::uint32_t> children = hierarchy.children(node);
		const std::size_t count = metric.exact ? node.primaryChildCount : children.size;
		for (std::size_t i = count; i-- > 0;) m_stack.push_back(children[i]);
	}
}

void PartnerContacts::withHalfSpace(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
									double tolerance, std::vector<Contact>& contacts, PartnerStats& stats)
{
	const auto apart = [&](const OrientedBox& box) { return interval(box, normal).first - offset > tolerance; };
	const auto unknown = [](std::uint32_t, const Node&) { return 0.0; };
	visit(hierarchy, metric, apart, unknown, 0, contacts, stats);
}

void PartnerContacts::withTriangle(const Hierarchy& hierarchy, const Triangle& triangle, std::uint32_t index,
								   const Vec3& beneath, const Metric& metric, double tolerance,
								   std::vector<Contact>& contacts, PartnerStats& stats)
{
	const Vec3 normal = normalized(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
	const SunkTriangle sunk(triangle, beneath, hierarchy.originRadius());
	const auto apart = [&](const OrientedBox& box) { return separated(box, triangle, normal, tolerance); };
	const auto distanceOf = [&](std::uint32_t node, const Node& hull)
	{
		const Vec3 center = toVec3(hierarchy.cullBox(node).center);
		return std::max(0.0, sunk.distanceTo(contactHull(hierarchy, hull), center, 0));
	};
	visit(hierarchy, metric, apart, distanceOf, index, contacts, stats);
}
}  // namespace clod
