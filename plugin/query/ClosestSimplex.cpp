// SPDX-License-Identifier: Zlib
// Nearest point of a segment, triangle or tetrahedron to the origin, by descending to the faces that the origin is
// outside of.
#include "clod/query/ClosestSimplex.h"

#include <algorithm>
#include <limits>

namespace clod
{
namespace
{
// Below this share of the product of its sides an area or volume is rounding noise of the corners.
constexpr double kDegenerate = 1e-13;
constexpr double kResidual = 1e-14;  // of an enclosure, relative to the farthest corner

SimplexPoint atCorner(const Vec3* corner, int i)
{
	SimplexPoint result;
	result.nearest = corner[i];
	result.weight[i] = 1;
	result.squared = lengthSquared(corner[i]);
	return result;
}

SimplexPoint onSegment(const Vec3* corner, int i, int j)
{
	const Vec3 edge = corner[j] - corner[i];
	const double along = -dot(corner[i], edge), squared = lengthSquared(edge);
	if (along <= 0) return atCorner(corner, i);
	if (along >= squared) return atCorner(corner, j);
	SimplexPoint result;
	const double share = along / squared;
	// From the nearer end: less cancellation.
	result.nearest = share <= 0.5 ? corner[i] + share * edge : corner[j] - (1 - share) * edge;
	result.weight[i] = 1 - share;
	result.weight[j] = share;
	result.squared = lengthSquared(result.nearest);
	return result;
}

const SimplexPoint& nearer(const SimplexPoint& a, const SimplexPoint& b)
{
	return b.squared < a.squared ? b : a;
}

SimplexPoint onTriangle(const Vec3* corner, int i, int j, int k)
{
	const Vec3 &a = corner[i], &b = corner[j], &c = corner[k];
	const Vec3 ab = b - a, ac = c - a, bc = c - b;
	const Vec3 normal = cross(ab, ac);
	const double area = lengthSquared(normal);
	const double scale = lengthSquared(ab) * lengthSquared(ac);
	if (!(area > kDegenerate * kDegenerate * scale))
		return nearer(nearer(onSegment(corner, i, j), onSegment(corner, i, k)), onSegment(corner, j, k));

	// Barycentric coordinates of the projection; a negative one names an edge that the origin is outside of.
	const double ofC = dot(cross(a, ab), normal), ofB = dot(cross(ac, a), normal), ofA = dot(cross(b, bc), normal);
	if (ofA > 0 && ofB > 0 && ofC > 0)
	{
		SimplexPoint result;
		const double sum = ofA + ofB + ofC, height = dot(a, normal) / area;
		result.nearest = height * normal;
		result.weight[i] = ofA / sum;
		result.weight[j] = ofB / sum;
		result.weight[k] = ofC / sum;
		result.squared = lengthSquared(result.nearest);
		return result;
	}
	SimplexPoint best;
	best.squared = std::numeric_limits<double>::infinity();
	if (ofC <= 0) best = nearer(best, onSegment(corner, i, j));
	if (ofB <= 0) best = nearer(best, onSegment(corner, i, k));
	if (ofA <= 0) best = nearer(best, onSegment(corner, j, k));
	return best;
}

constexpr int kFaces[4][4] = {{1, 2, 3, 0}, {0, 3, 2, 1}, {0, 1, 3, 2}, {0, 2, 1, 3}};  // three corners, opposite one

// Weights that reproduce the origin to rounding prove that a tetrahedron encloses it. gradient[i] is that of weight i.
// Those of a sliver are noise at first: two steps of iterative refinement. Negative weights left: not enclosed.
SimplexPoint enclosure(const Vec3* corner, const Vec3* gradient, SimplexPoint first)
{
	for (int step = 0; step < 3; ++step)
	{
		first.nearest = Vec3{};
		for (int i = 0; i < 4; ++i) first.nearest += first.weight[i] * corner[i];
		if (step == 2) break;
		double sum = 0;
		for (int i = 0; i < 4; ++i)
		{
			first.weight[i] = std::max(0.0, first.weight[i] - dot(gradient[i], first.nearest));
			sum += first.weight[i];
		}
		for (double& weight : first.weight) weight /= sum;
	}
	first.squared = lengthSquared(first.nearest);
	double size = 0;
	for (int i = 0; i < 4; ++i) size = std::max(size, lengthSquared(corner[i]));
	first.inside = first.squared <= kResidual * kResidual * size;
	return first;
}

SimplexPoint inTetrahedron(const Vec3* corner)
{
	SimplexPoint best, enclosed;
	best.squared = std::numeric_limits<double>::infinity();
	bool inside = true;
	Vec3 gradient[4];
	for (const auto& face : kFaces)
	{
		const Vec3& base = corner[face[0]];
		const Vec3 toOpposite = corner[face[3]] - base;
		const Vec3 normal = cross(corner[face[1]] - base, corner[face[2]] - base);
		const double ofOrigin = -dot(normal, base), ofOpposite = dot(normal, toOpposite);
		const bool flat =
			ofOpposite * ofOpposite <= kDegenerate * kDegenerate * lengthSquared(normal) * lengthSquared(toOpposite);
		enclosed.weight[face[3]] = flat ? 0 : ofOrigin / ofOpposite;
		if (!flat) gradient[face[3]] = (1 / ofOpposite) * normal;
		if (!flat && enclosed.weight[face[3]] > 0) continue;
		inside = false;
		best = nearer(best, onTriangle(corner, face[0], face[1], face[2]));
	}
	if (!inside) return best;
	enclosed = enclosure(corner, gradient, enclosed);
	if (enclosed.inside) return enclosed;
	for (const auto& face : kFaces) best = nearer(best, onTriangle(corner, face[0], face[1], face[2]));
	return best;
}
}  // namespace

SimplexPoint closestToOrigin(const Vec3* corner, int count)
{
	switch (count)
	{
		case 1:
			return atCorner(corner, 0);
		case 2:
			return onSegment(corner, 0, 1);
		case 3:
			return onTriangle(corner, 0, 1, 2);
		default:
			return inTetrahedron(corner);
	}
}
}  // namespace clod
