// SPDX-License-Identifier: GPL-3.0-or-later
// Gaertner's pivoting on Welzl's algorithm: the smallest sphere of a small support set is found exactly, the farthest
// point outside joins the set, until none is outside. "Fast and robust smallest enclosing balls", ESA 1999.
#include "builder/assemble/BoundingSphere.h"

#include <algorithm>
#include <cmath>

namespace clod::builder
{
namespace
{
// The smallest sphere with all of b on its boundary (0 to 4 affinely independent points).
bool circumsphere(const std::vector<Vec3>& b, Sphere& out)
{
	if (b.empty()) return out = {{}, -1}, true;
	const Vec3 o = b[0];
	if (b.size() == 1) return out = {o, 0}, true;
	const Vec3 p = b[1] - o;
	Vec3 c = 0.5 * p;
	if (b.size() >= 3)
	{
		const Vec3 q = b[2] - o, n = cross(p, q);
		const double nn = lengthSquared(n);
		if (nn <= 1e-24 * lengthSquared(p) * lengthSquared(q)) return false;
		if (b.size() == 3)
			c = (0.5 / nn) * (lengthSquared(p) * cross(q, n) + lengthSquared(q) * cross(n, p));
		else
		{
			const Vec3 r = b[3] - o;
			const double det = dot(r, n);
			if (std::fabs(det) <= 1e-12 * std::sqrt(nn * lengthSquared(r))) return false;
			c = (0.5 / det) * (lengthSquared(r) * n + lengthSquared(q) * cross(r, p) + lengthSquared(p) * cross(q, r));
		}
	}
	out = {o + c, length(c)};
	return true;
}

// Smallest enclosing sphere of at most five points by trying every support set.
Sphere smallest(const std::vector<Vec3>& points, std::vector<Vec3>& support)
{
	Sphere best{{}, -1};
	for (unsigned mask = 1; mask < (1u << points.size()); ++mask)
	{
		std::vector<Vec3> boundary;
		for (std::size_t i = 0; i < points.size(); ++i)
			if (mask & (1u << i)) boundary.push_back(points[i]);
		Sphere s;
		if (boundary.size() > 4 || !circumsphere(boundary, s)) continue;
		const bool inside =
			std::all_of(points.begin(), points.end(),
						[&](const Vec3& p) { return length(p - s.center) <= s.radius * (1 + 1e-12) + 1e-300; });
		if (!inside || (best.radius >= 0 && s.radius >= best.radius)) continue;
		best = s;
		support = boundary;
	}
	return best;
}
}  // namespace

Sphere boundingSphere(const std::vector<Vec3>& points)
{
	if (points.empty()) return {};
	std::vector<Vec3> support{points[0]};
	Sphere sphere{points[0], 0};
	for (int round = 0; round < 1000; ++round)
	{
		std::size_t farthest = 0;
		double distance = -1;
		for (std::size_t i = 0; i < points.size(); ++i)
		{
			const double d = lengthSquared(points[i] - sphere.center);
			if (d > distance) distance = d, farthest = i;
		}
		distance = std::sqrt(distance);
		if (distance <= sphere.radius * (1 + 1e-10)) break;
		std::vector<Vec3> candidates = support, next;
		candidates.push_back(points[farthest]);
		const Sphere grown = smallest(candidates, next);
		if (grown.radius <= sphere.radius) break;
		sphere = grown;
		support = next;
	}
	for (const Vec3& p : points) sphere.radius = std::max(sphere.radius, length(p - sphere.center));
	return sphere;
}
}  // namespace clod::builder
