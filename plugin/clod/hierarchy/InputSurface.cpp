// SPDX-License-Identifier: Zlib
// Pseudonormals and the nearest face of the input surface.
#include "clod/hierarchy/InputSurface.h"

#include <algorithm>

#include "clod/collide/BoxSeparation.h"

namespace clod
{
namespace
{
// Angle of a triangle at corner i.
double angleAt(const Triangle& triangle, int i)
{
	const Vec3 u = normalized(triangle[(i + 1) % 3] - triangle[i]);
	const Vec3 v = normalized(triangle[(i + 2) % 3] - triangle[i]);
	return std::acos(std::max(-1.0, std::min(1.0, dot(u, v))));
}

Vec3 normalOf(const Face& face)
{
	return {double(face.normal[0]), double(face.normal[1]), double(face.normal[2])};
}

// Which corner is there. Precondition: one is.
int cornerAt(const Triangle& triangle, const Vec3& position)
{
	int i = 0;
	while (i < 2 && triangle[i] != position) ++i;
	return i;
}

// Each face leads to the one across its edge that ends in the corner, and none is led to by two: neighbours are mutual,
// and no face has two corners in one place (hierarchy/Layout.h). So the walk comes back to where it began.
Vec3 normalRoundCorner(const Hierarchy& hierarchy, std::uint32_t first, int corner)
{
	const auto triangleAt = [&](std::uint32_t face)
	{ return triangleOf(hierarchy, hierarchy.node(ownerOf(hierarchy, face)), hierarchy.faces()[face]); };
	const Vec3 position = triangleAt(first)[corner];
	Vec3 sum;
	std::uint32_t index = first;
	do
	{
		const Face& face = hierarchy.faces()[index];
		const Triangle triangle = triangleAt(index);
		const int at = cornerAt(triangle, position);
		sum += angleAt(triangle, at) * normalOf(face);
		index = face.neighbour[(at + 2) % 3];
	} while (index != first);
	return sum;
}

}  // namespace

std::uint32_t ownerOf(const Hierarchy& hierarchy, std::uint32_t face)
{
	const Level& nodes = hierarchy.levels()[0];
	std::uint32_t low = nodes.firstNode, high = nodes.firstNode + nodes.nodeCount;
	while (high - low > 1)
	{
		const std::uint32_t middle = low + (high - low) / 2;
		(hierarchy.node(middle).firstFace <= face ? low : high) = middle;
	}
	return low;
}

Vec3 pseudonormal(const Hierarchy& hierarchy, std::uint32_t face, int feature)
{
	const Face& nearest = hierarchy.faces()[face];
	if (feature == 6) return normalOf(nearest);
	if (feature < 3) return normalRoundCorner(hierarchy, face, feature);
	return normalOf(nearest) + normalOf(hierarchy.faces()[nearest.neighbour[feature - 3]]);
}

SignedDistance distanceToInput(const Hierarchy& hierarchy, const Vec3& point, std::uint32_t& visited, double within)
{
	struct Candidate
	{
		double distance;
		std::uint32_t node;
	};
	constexpr int kDepth = 256;
	thread_local std::vector<Candidate> stack;
	stack.clear();
	stack.reserve(kDepth);
	stack.push_back({0, hierarchy.root()});
	// Room for rounding; what is farther is not looked for.
	double best = 1.0001 * within * within;
	SignedDistance result{best, kNone, 6};
	Vec3 nearest;
	while (!stack.empty())
	{
		const Candidate candidate = stack.back();
		stack.pop_back();
		if (candidate.distance * candidate.distance >= best) continue;
		const Node& node = hierarchy.node(candidate.node);
		for (std::uint32_t i = 0; node.childCount == 0 && i < node.faceCount; ++i)
		{
			const Face& face = hierarchy.faces(node)[i];
			const NearestOnTriangle here = nearestOnTriangle(triangleOf(hierarchy, node, face), point);
			if (here.squared >= best) continue;
			best = here.squared;
			nearest = here.point;
			result.face = node.firstFace + i;
			result.feature = here.feature;
		}
		// Nearest child on top of the stack.
		const std::size_t first = stack.size();
		for (std::uint32_t i = 0; i < node.primaryChildCount; ++i)
		{
			const std::uint32_t child = hierarchy.children(node)[i];
			const double distance = boxDistance(hierarchy.cullBox(child), point);
			++visited;
			if (distance * distance < best) stack.push_back({distance, child});
		}
		std::sort(stack.begin() + std::ptrdiff_t(first), stack.end(),
				  [](const Candidate& l, const Candidate& r)
				  { return l.distance != r.distance ? l.distance > r.distance : l.node > r.node; });
	}
	if (result.face == kNone) return distanceToInput(hierarchy, point, visited);
	const Vec3 normal = pseudonormal(hierarchy, result.face, result.feature);
	result.distance = dot(point - nearest, normal) >= 0 ? std::sqrt(best) : -std::sqrt(best);
	return result;
}
}  // namespace clod
