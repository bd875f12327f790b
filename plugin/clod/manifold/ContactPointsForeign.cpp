// SPDX-License-Identifier: Zlib
#include "clod/manifold/ContactPointsForeign.h"

#include <algorithm>
#include <utility>

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

// When may a node answer against an exact partner? The rule of StopRule.h with f = 0 and D = inf on the other side; the
// place of a contact is in the node's own culling box.
class ForeignRule
{
public:
	ForeignRule(const Hierarchy& hierarchy, const Metric& metric)
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

PointFilter partnerFilter(const PointRules& rules)
{
	return {&rules, {-rules.motion.linear, -rules.motion.angular, rules.motion.timeStep}};
}

// Height the motion may close in the step anywhere on the hierarchy.
double reachOf(const Hierarchy& hierarchy, const PointRules& rules)
{
	const Vec3 center = toVec3(hierarchy.asset().sphereCenter);
	const double speed =
		length(rules.motion.velocity(center)) + length(rules.motion.angular) * double(hierarchy.asset().radius);
	return rules.margin + rules.resting + kPredictionSlack * speed * rules.motion.timeStep;
}

using Planes = std::vector<std::pair<Vec3, double>>;

// Points of one hierarchy face against one triangle, the triangle being the reference.
void clipFaceToTriangle(FacePrism prism, const Face& face, const Triangle& corners, const PointRules& rules,
						ContactPoint named, std::vector<ContactPoint>& points)
{
	// Seen from the hierarchy's frame the triangle is at rest and the hierarchy moves.
	const PointFilter filter{&rules, rules.motion};
	const double cosine = dot(prism.normal, toVec3(face.normal));
	if (std::abs(cosine) < -kOpposingCosine) return;
	if (cosine > 0)
	{
		prism.normal = -prism.normal;
		prism.offset = -prism.offset;
	}
	const Vec3 middle = (1.0 / 3) * (corners[0] + corners[1] + corners[2]);
	prism.top = filter.topFor(prism, middle, length(corners[0] - middle));
	prism.bottom = -double(face.thickness);
	const std::array<std::pair<Vec3, double>, 1> under = {{{prism.normal, prism.offset}}};
	named.normal = prism.normal;
	named.referenceIsA = false;
	const auto emit = [&](const Vec3& point, double height, double predicted)
	{
		named.height = height - rules.margin;
		named.predicted = predicted;
		named.atBottom = atBottom(prism, height);
		named.pointOnA = point;
		named.pointOnB = point - height * prism.normal;
		points.push_back(named);
	};
	filter.visit(prism, corners, filter.carried(corners), under, emit);
}

// Points of one triangle against one hierarchy face, the face being the reference.
void clipTriangleToFace(FacePrism prism, const Triangle& triangle, const Vec3& triangleNormal, const PointRules& rules,
						const Planes& under, ContactPoint named, std::vector<ContactPoint>& points)
{
	const PointFilter filter = partnerFilter(rules);
	if (std::abs(dot(prism.normal, triangleNormal)) < -kOpposingCosine) return;
	const Vec3 middle = (1.0 / 3) * (triangle[0] + triangle[1] + triangle[2]);
	prism.top = filter.topFor(prism, middle, length(triangle[0] - middle));
	named.normal = -prism.normal;
	named.referenceIsA = true;
	const auto emit = [&](const Vec3& point, double height, double predicted)
	{
		named.height = height - rules.margin;
		named.predicted = predicted;
		named.atBottom = atBottom(prism, height);
		named.pointOnA = point - height * prism.normal;
		named.pointOnB = point;
		points.push_back(named);
	};
	filter.visit(prism, triangle, filter.carried(triangle), under, emit);
}
}  // namespace

// Nodes that answer and are not separated, each once. Exact answers follow the tree, others the whole graph.
template <class Separated, class Sink>
void ForeignClipper::visit(const Hierarchy& hierarchy, const Metric& metric, const Separated& apart, const Sink& sink,
						   ForeignStats& stats)
{
	if (m_visited.size() != hierarchy.nodes().size)
	{
		m_visited.assign(hierarchy.nodes().size, 0);
		m_visit = 0;
	}
	++m_visit;
	const ForeignRule rule(hierarchy, metric);
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
			sink(index, node);
			continue;
		}
		const Span<std::uint32_t> children = hierarchy.children(node);
		const std::size_t count = metric.exact ? node.primaryChildCount : children.size;
		for (std::size_t i = count; i-- > 0;) m_stack.push_back(children[i]);
	}
}

void ForeignClipper::clipPlane(const Hierarchy& hierarchy, const Vec3& normal, double offset, const Metric& metric,
							   const PointRules& rules, std::vector<ContactPoint>& points, ForeignStats& stats)
{
	const double reach = reachOf(hierarchy, rules);
	const PointFilter filter{&rules, rules.motion};
	FacePrism plane;
	plane.normal = normal;
	plane.offset = offset;
	const std::array<std::pair<Vec3, double>, 1> under = {{{normal, offset}}};
	const auto apart = [&](const OrientedBox& box) { return interval(box, normal).first - offset > reach; };
	const auto sink = [&](std::uint32_t index, const Node& node)
	{
		const HullView hull = hierarchy.hull(node);
		m_met.assign(hull.count, 0);
		for (std::uint32_t i = 0; i < node.faceCount; ++i)
		{
			const Face& face = hierarchy.faces()[node.firstFace + i];
			if (dot(normal, toVec3(face.normal)) >= kOpposingCosine) continue;
			for (const std::uint16_t vertex : face.vertex)
			{
				ContactPoint point{};
				point.pointOnA = hull.vertex(vertex);
				const double height = plane.heightOf(point.pointOnA);
				if (m_met[vertex] || height > reach) continue;
				m_met[vertex] = 1;
				if (!filter.keep(plane, point.pointOnA, under, point.predicted)) continue;
				point.height = height - rules.margin;
				point.pointOnB = point.pointOnA - height * normal;
				point.normal = normal;
				point.nodeA = index;
				point.faceA = node.firstFace + i;
				points.push_back(point);
			}
		}
	};
	visit(hierarchy, metric, apart, sink, stats);
}

void ForeignClipper::clipTriangle(const Hierarchy& hierarchy, const Triangle& triangle, std::uint32_t part,
								  std::uint32_t index, const Metric& metric, const PointRules& rules,
								  std::vector<ContactPoint>& points, ForeignStats& stats)
{
	FacePrism prism;
	if (!prismOf(triangle, prism)) return;
	const double reach = reachOf(hierarchy, rules);
	Planes under;
	const auto apart = [&](const OrientedBox& box) { return separated(box, triangle, prism.normal, reach); };
	const auto sink = [&](std::uint32_t nodeIndex, const Node& node)
	{
		// The foreign triangle is flat: it is the reference unless the patch is flat too, borders included.
		const double tie = kTieCurvature / rules.length;
		const bool patchIsReference = double(node.curvature) <= tie && bendWithBorder(hierarchy, node) <= tie;
		under.clear();
		for (const Face& face : hierarchy.faces(node)) under.push_back({toVec3(face.normal), double(face.offset)});
		for (std::uint32_t i = 0; i < node.faceCount; ++i)
		{
			const Face& face = hierarchy.faces()[node.firstFace + i];
			ContactPoint named{};
			named.nodeA = nodeIndex;
			named.faceA = node.firstFace + i;
			named.nodeB = part;
			named.faceB = index;
			if (patchIsReference)
				clipTriangleToFace(prismOf(hierarchy, node, face), triangle, prism.normal, rules, under, named, points);
			else
				clipFaceToTriangle(prism, face, triangleOf(hierarchy, node, face), rules, named, points);
		}
	};
	visit(hierarchy, metric, apart, sink, stats);
}
}  // namespace clod
