// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Meshes.h"

#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

void addQuad(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d)
{
	mesh.triangles.push_back({a, b, c});
	mesh.triangles.push_back({a, c, d});
}

Vec3 onCircle(double radius, double height, int i, int count)
{
	const double turn = 2 * kPi * i / count;
	return {radius * std::cos(turn), height, -radius * std::sin(turn)};
}
}  // namespace

TriangleMesh box(const Vec3& half)
{
	TriangleMesh mesh = ridges({{-half.x, half.y}, {half.x, half.y}}, -half.y, half.z);
	return mesh;
}

TriangleMesh turned(const std::vector<Point2>& profile, int segments)
{
	TriangleMesh mesh;
	std::vector<std::uint32_t> first;
	for (const Point2& p : profile)
	{
		first.push_back(std::uint32_t(mesh.vertices.size()));
		const int count = p.first > 0 ? segments : 1;
		for (int i = 0; i < count; ++i) mesh.vertices.push_back(onCircle(p.first, p.second, i, segments));
	}
	const auto at = [&](std::size_t k, int i)
	{ return first[k] + (profile[k].first > 0 ? std::uint32_t(i % segments) : 0); };
	for (std::size_t k = 0; k < profile.size(); ++k)
	{
		const std::size_t next = (k + 1) % profile.size();
		for (int i = 0; i < segments; ++i)
		{
			if (profile[k].first > 0) mesh.triangles.push_back({at(k, i), at(k, i + 1), at(next, i)});
			if (profile[next].first > 0) mesh.triangles.push_back({at(k, i + 1), at(next, i + 1), at(next, i)});
		}
	}
	return mesh;
}

TriangleMesh torus(double ring, double tube, int segments, int sides)
{
	std::vector<Point2> profile;
	for (int k = 0; k < sides; ++k)
		profile.push_back({ring + tube * std::cos(2 * kPi * k / sides), tube * std::sin(2 * kPi * k / sides)});
	return turned(profile, segments);
}

TriangleMesh ridges(const std::vector<Point2>& heights, double base, double half)
{
	TriangleMesh mesh;
	for (const Point2& p : heights)
		for (const double z : {half, -half})
			for (const double y : {base, p.second}) mesh.vertices.push_back({p.first, y, z});
	// 0 front below, 1 front above, 2 back below, 3 back above; front is +z.
	const auto last = std::uint32_t(4 * heights.size() - 4);
	for (std::uint32_t i = 0; i < last; i += 4)
	{
		addQuad(mesh, i + 1, i + 5, i + 7, i + 3);
		addQuad(mesh, i, i + 2, i + 6, i + 4);
		addQuad(mesh, i, i + 4, i + 5, i + 1);
		addQuad(mesh, i + 2, i + 3, i + 7, i + 6);
	}
	addQuad(mesh, 0, 1, 3, 2);
	addQuad(mesh, last, last + 2, last + 3, last + 1);
	return mesh;
}

TriangleMesh wedge(double angle, double height, double half)
{
	const double width = height * std::tan(0.5 * angle);
	return ridges({{-width, -height}, {0, 0}, {width, -height}}, -1.3 * height, half);
}

TriangleMesh prism(const std::vector<double>& radii, double half)
{
	TriangleMesh mesh;
	const auto count = std::uint32_t(radii.size());
	for (const double z : {half, -half})
		for (std::uint32_t i = 0; i < count; ++i)
		{
			const double turn = 2 * kPi * i / count;
			mesh.vertices.push_back({radii[i] * std::cos(turn), radii[i] * std::sin(turn), z});
		}
	mesh.vertices.push_back({0, 0, half});
	mesh.vertices.push_back({0, 0, -half});
	for (std::uint32_t i = 0; i < count; ++i)
	{
		const std::uint32_t next = (i + 1) % count;
		mesh.triangles.push_back({2 * count, i, next});
		mesh.triangles.push_back({2 * count + 1, count + next, count + i});
		addQuad(mesh, i, count + i, count + next, next);
	}
	return mesh;
}

TriangleMesh spike(int sides, double radius, double height)
{
	return turned({{0, 0}, {0, -height}, {radius, -height}}, sides);
}

TriangleMesh pit(int sides, double radius, double height, double below)
{
	return turned({{0, 0}, {0, -below}, {radius, -below}, {radius, height}}, sides);
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b, const Vec3& offsetOfB)
{
	const auto first = std::uint32_t(a.vertices.size());
	for (const Vec3& v : b.vertices) a.vertices.push_back(v + offsetOfB);
	for (const auto& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
	return a;
}

TriangleMesh moved(TriangleMesh mesh, const Transform& by)
{
	for (Vec3& v : mesh.vertices) v = by * v;
	return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double by)
{
	for (Vec3& v : mesh.vertices) v = by * v;
	return mesh;
}
}  // namespace clod::oracle
