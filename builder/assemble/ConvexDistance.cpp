// SPDX-License-Identifier: GPL-3.0-or-later
// Gilbert, Johnson & Keerthi 1988, with closest points of the simplex by its faces (Ericson 2005, sec. 5.1, 9.5).
#include "builder/assemble/ConvexDistance.h"

#include "builder/assemble/Geometry.h"

namespace clod::builder
{
namespace
{
struct Simplex
{
	Vec3 point[4];
	int size = 0;
};

// Closest point to the origin of each kind of simplex; reduces the simplex to the corners that carry it.
Vec3 closestOnSegment(Simplex& s)
{
	const Vec3 d = s.point[1] - s.point[0];
	const double t = -dot(s.point[0], d), n = lengthSquared(d);
	if (t <= 0 || n == 0) return s.size = 1, s.point[0];
	if (t >= n)
	{
		s.point[0] = s.point[1];
		return s.size = 1, s.point[0];
	}
	return s.point[0] + (t / n) * d;
}

Vec3 closestOnTriangle(Simplex& s)
{
	const Triangle t{s.point[0], s.point[1], s.point[2]};
	const ClosestPoint c = closestPoint(Vec3{}, t);
	const auto keep = [&s, &t](int i, int j)
	{
		s.point[0] = t[i];
		s.size = 1;
		if (j >= 0) s.point[s.size++] = t[j];
	};
	switch (c.feature)
	{
		case Feature::vertexA:
			keep(0, -1);
			break;
		case Feature::vertexB:
			keep(1, -1);
			break;
		case Feature::vertexC:
			keep(2, -1);
			break;
		case Feature::edgeAB:
			keep(0, 1);
			break;
		case Feature::edgeBC:
			keep(1, 2);
			break;
		case Feature::edgeCA:
			keep(0, 2);
			break;
		case Feature::face:
			break;
	}
	return c.point;
}

// Inside: the length of the convex combination that cancels best, rounding included, tells how far the claim may be
// off.
Vec3 closestOnTetrahedron(Simplex& s, bool& inside)
{
	constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
	const Simplex whole = s;
	double weight[4], total = 0;
	bool within = true;
	for (int f = 0; f < 4; ++f)
	{
		const Vec3 &a = whole.point[kFaces[f][0]], &b = whole.point[kFaces[f][1]], &c = whole.point[kFaces[f][2]];
		const Vec3& apex = whole.point[3 - f];
		const Vec3 n = cross(b - a, c - a);
		const double height = dot(n, apex - a), origin = -dot(n, a);
		weight[f] = height != 0 ? origin / height : -1;
		within = within && weight[f] >= 0;
		total += weight[f];
	}
	if (within && total > 0.5 && total < 2)
	{
		Vec3 rest;
		for (int f = 0; f < 4; ++f) rest += (weight[f] / total) * whole.point[3 - f];
		inside = true;
		return rest;
	}
	Vec3 best;
	double bestLength = std::numeric_limits<double>::infinity();
	for (const auto& face : kFaces)
	{
		Simplex part;
		part.size = 3;
		for (int k = 0; k < 3; ++k) part.point[k] = whole.point[face[k]];
		const Vec3 v = closestOnTriangle(part);
		if (lengthSquared(v) >= bestLength) continue;
		bestLength = lengthSquared(v);
		best = v;
		s = part;
	}
	return best;
}

Vec3 closestOn(Simplex& s, bool& inside)
{
	switch (s.size)
	{
		case 1:
			return s.point[0];
		case 2:
			return closestOnSegment(s);
		case 3:
			return closestOnTriangle(s);
		default:
			return closestOnTetrahedron(s, inside);
	}
}
}  // namespace

Vec3 ConvexSet::support(const Vec3& direction) const
{
	std::size_t best = 0;
	double value = dot(vertices[0], direction);
	for (std::size_t i = 1; i < count; ++i)
	{
		const double d = dot(vertices[i], direction);
		if (d > value) value = d, best = i;
	}
	return dot(sweep, direction) > 0 ? vertices[best] + sweep : vertices[best];
}

double distanceBound(const Vec3& p, const ConvexSet& set, double enough)
{
	constexpr int kIterations = 64;
	constexpr double kRelative = 1e-3;
	Simplex s;
	s.point[s.size++] = set.vertices[0] - p;
	Vec3 v = s.point[0];
	double best = length(v);
	bool inside = false;
	for (int i = 0; i < kIterations && best > enough; ++i)
	{
		const Vec3 w = set.support(-v) - p;
		if (lengthSquared(v) - dot(v, w) <= kRelative * lengthSquared(v)) break;
		s.point[s.size++] = w;
		const Vec3 next = closestOn(s, inside);
		const double d = length(next);
		if (inside) return d;
		if (d >= best) break;
		best = d;
		v = next;
	}
	return best;
}
}  // namespace clod::builder
