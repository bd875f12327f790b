// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs: up to kGreedyLimit nodes, the pair whose common box has the least surface first; beyond that, neighbours in a
// kd-order (halving the widest axis), which costs n log n instead of n^2.
#include "builder/assemble/Completion.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "builder/assemble/HullPlanes.h"
#include "builder/assemble/Parallel.h"

namespace clod::builder
{
namespace
{
constexpr std::size_t kGreedyLimit = 1500;
constexpr std::size_t kCornerLimit = 64;

using Pairs = std::vector<std::array<std::uint32_t, 2>>;  // the second may be kNone

double surface(const AxisBox& b)
{
	const Vec3 e = b.extent();
	return e.x * e.y + e.y * e.z + e.z * e.x;
}

Pairs pairGreedily(const std::vector<AxisBox>& boxes)
{
	struct Candidate
	{
		double surface;
		std::uint32_t i, j;
	};
	std::vector<Candidate> candidates;
	for (std::uint32_t i = 0; i < boxes.size(); ++i)
		for (std::uint32_t j = i + 1; j < boxes.size(); ++j)
		{
			AxisBox both = boxes[i];
			both.add(boxes[j]);
			candidates.push_back({surface(both), i, j});
		}
	std::sort(candidates.begin(), candidates.end(),
			  [](const Candidate& a, const Candidate& b)
			  { return std::tie(a.surface, a.i, a.j) < std::tie(b.surface, b.i, b.j); });
	std::vector<bool> used(boxes.size(), false);
	Pairs pairs;
	for (const Candidate& c : candidates)
	{
		if (used[c.i] || used[c.j]) continue;
		used[c.i] = used[c.j] = true;
		pairs.push_back({c.i, c.j});
	}
	for (std::uint32_t i = 0; i < boxes.size(); ++i)
		if (!used[i]) pairs.push_back({i, kNone});
	return pairs;
}

void orderByHalving(const std::vector<AxisBox>& boxes, std::vector<std::uint32_t>& order, std::size_t first,
					std::size_t count)
{
	if (count <= 2) return;
	const auto center = [&boxes](std::uint32_t i, int axis) { return boxes[i].low[axis] + boxes[i].high[axis]; };
	AxisBox centers;
	for (std::size_t k = first; k < first + count; ++k)
		centers.add(Vec3{center(order[k], 0), center(order[k], 1), center(order[k], 2)});
	const Vec3 e = centers.extent();
	const int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
	const std::size_t half = (count / 2 + 1) / 2 * 2;
	const auto begin = order.begin() + std::ptrdiff_t(first);
	std::nth_element(begin, begin + std::ptrdiff_t(half), begin + std::ptrdiff_t(count),
					 [&](std::uint32_t i, std::uint32_t j)
					 { return std::make_pair(center(i, axis), i) < std::make_pair(center(j, axis), j); });
	orderByHalving(boxes, order, first, half);
	orderByHalving(boxes, order, first + half, count - half);
}

Pairs pairByOrder(const std::vector<AxisBox>& boxes)
{
	std::vector<std::uint32_t> order(boxes.size());
	std::iota(order.begin(), order.end(), 0u);
	orderByHalving(boxes, order, 0, order.size());
	Pairs pairs;
	for (std::size_t i = 0; i < order.size(); i += 2)
	{
		const std::uint32_t second = i + 1 < order.size() ? order[i + 1] : kNone;
		pairs.push_back({std::min(order[i], second), second == kNone ? kNone : std::max(order[i], second)});
	}
	return pairs;
}

// At most kCornerLimit points whose hull contains all points: the extreme ones in evenly spread directions, moved away
// from the middle until nothing is outside.
std::vector<Vec3> modestHull(const std::vector<Vec3>& corners, double size)
{
	if (corners.size() <= kCornerLimit) return corners;
	std::vector<std::size_t> chosen;
	for (std::size_t k = 0; k < kCornerLimit; ++k)
	{
		const double z = 1 - (2 * double(k) + 1) / double(kCornerLimit), angle = 2.399963229728653 * double(k);
		const double r = std::sqrt(1 - z * z);
		const Vec3 direction{r * std::cos(angle), r * std::sin(angle), z};
		chosen.push_back(std::size_t(std::max_element(corners.begin(), corners.end(),
													  [&](const Vec3& a, const Vec3& b)
													  { return dot(a, direction) < dot(b, direction); }) -
									 corners.begin()));
	}
	std::sort(chosen.begin(), chosen.end());
	chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
	std::vector<Vec3> points;
	Vec3 middle;
	for (std::size_t i : chosen) points.push_back(corners[i]);
	for (const Vec3& p : points) middle += (1 / double(points.size())) * p;
	double scale = 1;
	for (const HalfSpace& plane : hullShape(points, 1e-6 * size).planes)
	{
		const double room = plane.offset - dot(plane.normal, middle);
		for (const Vec3& p : corners)
			scale = std::max(scale, (dot(plane.normal, p) - dot(plane.normal, middle)) / room);
	}
	for (Vec3& p : points) p = middle + scale * (p - middle);
	return points;
}

// Rounds the vertices to float. Every point of the hull moves by at most the largest move of a vertex: that is h.
void store(NodeDraft& node, const std::vector<Vec3>& points)
{
	for (const Vec3& p : points)
	{
		node.vertices.push_back(toVec3(toFloat3(p)));
		node.hausdorff = std::max(node.hausdorff, length(node.vertices.back() - p));
	}
}
// A completion child's stored hull may reach beyond what it encloses, and beyond this hull: h accounts for it.
void include(NodeDraft& node, const NodeDraft& child)
{
	if (!child.faces.empty()) return;
	for (const Vec3& v : child.vertices)
		node.hausdorff = std::max(node.hausdorff, child.hausdorff + distanceBound(v, node.hull()));
}
}  // namespace

void completeToRoot(HierarchyDraft& draft, std::vector<std::vector<Vec3>> corners, const ThreadLimit& threads)
{
	while (draft.levels.back().nodeCount > 1)
	{
		const LevelDraft below = draft.levels.back();
		std::vector<AxisBox> boxes(below.nodeCount);
		for (std::uint32_t i = 0; i < below.nodeCount; ++i)
			for (const Vec3& p : corners[i]) boxes[i].add(p);
		const Pairs pairs = below.nodeCount <= kGreedyLimit ? pairGreedily(boxes) : pairByOrder(boxes);
		std::vector<std::vector<Vec3>> merged(pairs.size());
		std::vector<NodeDraft> nodes(pairs.size());
		parallelFor(pairs.size(), threads,
					[&](std::size_t k)
					{
						std::vector<Vec3> points;
						for (std::uint32_t child : pairs[k])
						{
							if (child == kNone) continue;
							points.insert(points.end(), corners[child].begin(), corners[child].end());
							nodes[k].children.push_back(below.firstNode + child);
						}
						AxisBox box;
						for (const Vec3& p : points) box.add(p);
						const double size = length(box.extent());
						merged[k] = hullShape(points, 1e-6 * size).corners;
						nodes[k].primaryChildren = std::uint32_t(nodes[k].children.size());
						store(nodes[k], modestHull(merged[k], size));
						for (std::uint32_t child : nodes[k].children) include(nodes[k], draft.nodes[child]);
					});
		corners = std::move(merged);
		draft.levels.push_back({std::uint32_t(draft.nodes.size()), std::uint32_t(nodes.size()), false, 0});
		for (NodeDraft& node : nodes) draft.nodes.push_back(std::move(node));
	}
}
}  // namespace clod::builder
