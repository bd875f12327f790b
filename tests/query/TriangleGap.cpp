// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/query/TriangleGap.h"

#include <algorithm>
#include <queue>

namespace clod::test
{
namespace
{
double pointSegment(const Vec3& p, const Vec3& a, const Vec3& b)
{
	const Vec3 d = b - a;
	const double l = lengthSquared(d);
	const double t = l > 0 ? std::clamp(dot(p - a, d) / l, 0.0, 1.0) : 0;
	return length(p - (a + t * d));
}

double segmentSegment(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s)
{
	double best =
		std::min({pointSegment(p, r, s), pointSegment(q, r, s), pointSegment(r, p, q), pointSegment(s, p, q)});
	const Vec3 u = q - p, v = s - r, w = p - r, n = cross(u, v);
	const double nn = lengthSquared(n);
	if (nn > 0)
	{
		const double t = dot(cross(v, w), n) / nn, k = dot(cross(u, w), n) / nn;
		if (t > 0 && t < 1 && k > 0 && k < 1) best = std::min(best, std::abs(dot(w, n)) / std::sqrt(nn));
	}
	return best;
}

// Does the segment cross the triangle's inside?
bool crosses(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t)
{
	const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
	{ return dot(cross(b - a, c - a), d - a); };
	const double sp = volume(t[0], t[1], t[2], p), sq = volume(t[0], t[1], t[2], q);
	if (!(sp * sq < 0)) return false;
	const double a = volume(p, q, t[0], t[1]), b = volume(p, q, t[1], t[2]), c = volume(p, q, t[2], t[0]);
	return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}

// A point and its depth below the surface, > 0 inside.
struct Sample
{
	Vec3 point;
	double depth = 0;
};
struct Cell
{
	std::array<Vec3, 3> corner;
	double upper;
	Sample center;
	bool operator<(const Cell& o) const { return upper < o.upper; }
};

// Of the box round a triangle.
double squaredToBox(const Vec3& p, const std::array<Vec3, 3>& t)
{
	double squared = 0;
	for (int k = 0; k < 3; ++k)
	{
		const double low = std::min({t[0][k], t[1][k], t[2][k]}), high = std::max({t[0][k], t[1][k], t[2][k]});
		const double d = std::max({low - p[k], p[k] - high, 0.0});
		squared += d * d;
	}
	return squared;
}

// From the surface, and the triangle that is nearest.
double distanceAt(const TriangleSoup& mesh, const Vec3& p, std::size_t& nearest)
{
	double best = 1e300;
	for (std::size_t i = 0; i < mesh.size(); ++i)
	{
		if (squaredToBox(p, mesh[i]) >= best * best) continue;
		const double distance = pointTriangleDistance(p, mesh[i]);
		if (distance >= best) continue;
		best = distance;
		nearest = i;
	}
	return best;
}
// The side of a point is that of another where no surface lies between.
bool isInside(const TriangleSoup& mesh, const Vec3& p, const Sample& other)
{
	return length(p - other.point) < std::abs(other.depth) ? other.depth > 0 : windingNumber(mesh, p) > 0.5;
}

// Deepest point of `surface` inside `solid`, at least `known`.
GapInterval deepest(const TriangleSoup& surface, const TriangleSoup& solid, double known, double accuracy)
{
	std::priority_queue<Cell> cells;
	double best = known;
	const auto push = [&](const std::array<Vec3, 3>& corner, const Sample& before)
	{
		const Vec3 center = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
		std::size_t nearest = 0;
		const double distance = distanceAt(solid, center, nearest);
		// No point of the cell is deeper than its centre by more than the radius, nor farther from the nearest triangle
		// than the farthest corner is (the distance to a convex set is convex).
		double radius = 0, farthest = 0;
		for (const Vec3& c : corner)
		{
			radius = std::max(radius, length(c - center));
			farthest = std::max(farthest, pointTriangleDistance(c, solid[nearest]));
		}
		if (std::min(distance + radius, farthest) <= best + accuracy) return;  // on either side
		const double depth = isInside(solid, center, before) ? distance : -distance;
		best = std::max(best, depth);
		const double upper = std::min(depth + radius, farthest);
		if (upper > best + accuracy) cells.push({corner, upper, {center, depth}});
	};
	for (const auto& t : surface) push(t, {});
	double upper = best + accuracy;
	while (!cells.empty())
	{
		const Cell cell = cells.top();
		cells.pop();
		if (cell.upper <= best + accuracy) break;
		const auto& c = cell.corner;
		const Vec3 m[3] = {0.5 * (c[0] + c[1]), 0.5 * (c[1] + c[2]), 0.5 * (c[2] + c[0])};
		push({c[0], m[0], m[2]}, cell.center);
		push({c[1], m[1], m[0]}, cell.center);
		push({c[2], m[2], m[1]}, cell.center);
		push({m[0], m[1], m[2]}, cell.center);
		upper = best + accuracy;
	}
	return {best, std::max(upper, best + accuracy)};
}
}  // namespace

double pointTriangleDistance(const Vec3& p, const std::array<Vec3, 3>& t)
{
	const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
	bool over = lengthSquared(n) > 0;
	for (int i = 0; i < 3 && over; ++i)
		over = dot(cross(t[std::size_t(i + 1) % 3] - t[std::size_t(i)], p - t[std::size_t(i)]), n) >= 0;
	if (over) return std::abs(dot(p - t[0], n)) / length(n);
	return std::min({pointSegment(p, t[0], t[1]), pointSegment(p, t[1], t[2]), pointSegment(p, t[2], t[0])});
}

double triangleDistance(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t)
{
	double best = 1e300;
	for (std::size_t i = 0; i < 3; ++i)
	{
		if (crosses(s[i], s[(i + 1) % 3], t) || crosses(t[i], t[(i + 1) % 3], s)) return 0;
		best = std::min({best, pointTriangleDistance(s[i], t), pointTriangleDistance(t[i], s)});
		for (std::size_t j = 0; j < 3; ++j)
			best = std::min(best, segmentSegment(s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]));
	}
	return best;
}

double windingNumber(const TriangleSoup& mesh, const Vec3& p)
{
	double sum = 0;
	for (const auto& t : mesh)
	{
		const Vec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
		const double la = length(a), lb = length(b), lc = length(c);
		sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
	}
	return sum / (4 * 3.14159265358979323846);
}

GapInterval triangleGap(const TriangleSoup& a, const TriangleSoup& b, const Transform& aFromB, double accuracy)
{
	TriangleSoup moved;
	for (const auto& t : b) moved.push_back({aFromB * t[0], aFromB * t[1], aFromB * t[2]});
	double distance = 1e300;
	for (const auto& s : a)
		for (const auto& t : moved)
		{
			// A lower bound first: the boxes of the two triangles.
			double squared = 0;
			for (int k = 0; k < 3; ++k)
			{
				const double low =
					std::max(std::min({s[0][k], s[1][k], s[2][k]}), std::min({t[0][k], t[1][k], t[2][k]}));
				const double high =
					std::min(std::max({s[0][k], s[1][k], s[2][k]}), std::max({t[0][k], t[1][k], t[2][k]}));
				squared += low > high ? (low - high) * (low - high) : 0;
			}
			if (squared < distance * distance) distance = std::min(distance, triangleDistance(s, t));
		}
	const bool inside = windingNumber(moved, a[0][0]) > 0.5 || windingNumber(a, moved[0][0]) > 0.5;
	if (distance > 0 && !inside) return {distance, distance};
	const GapInterval ofA = deepest(a, moved, 0, accuracy);
	const GapInterval ofB = deepest(moved, a, ofA.low, accuracy);
	return {-std::max(ofA.high, ofB.high), -ofB.low};
}
}  // namespace clod::test
