// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/builder/PatchesMeshes.h"

#include <cmath>
#include <map>

#include "builder/patches/Clip.h"

namespace clod::builder::test
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

// Joins equal coordinates, so that pieces made side by side become one surface.
struct Welder
{
	Mesh mesh;
	std::map<std::array<double, 3>, std::uint32_t> known;
	std::uint32_t operator()(const Vec3& p)
	{
		const Vec3 r = roundedToFloat(p);
		const auto [at, isNew] = known.insert({{r.x, r.y, r.z}, std::uint32_t(mesh.vertices.size())});
		if (isNew) mesh.vertices.push_back(r);
		return at->second;
	}
	void triangle(const Vec3& a, const Vec3& b, const Vec3& c)
	{
		const std::array<std::uint32_t, 3> t = {(*this)(a), (*this)(b), (*this)(c)};
		mesh.triangles.push_back(t);
	}
	// The parallelogram o, o + a, o + a + b, o + b, counter-clockwise from outside.
	void grid(const Vec3& o, const Vec3& a, const Vec3& b, int steps)
	{
		const auto at = [&](int i, int j) { return o + (double(i) / steps) * a + (double(j) / steps) * b; };
		for (int i = 0; i < steps; ++i)
			for (int j = 0; j < steps; ++j)
			{
				triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
				triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
			}
	}
};
}  // namespace

Mesh icosphere(int subdivisions)
{
	const double g = (1 + std::sqrt(5.0)) / 2;
	const Vec3 v[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
						{0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
	const int t[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
						  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
						  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
	std::vector<std::array<Vec3, 3>> faces;
	for (const auto& f : t) faces.push_back({normalized(v[f[0]]), normalized(v[f[1]]), normalized(v[f[2]])});
	for (int s = 0; s < subdivisions; ++s)
	{
		std::vector<std::array<Vec3, 3>> finer;
		for (const auto& [a, b, c] : faces)
		{
			const Vec3 ab = normalized(a + b), bc = normalized(b + c), ca = normalized(c + a);
			for (const auto& f : {std::array<Vec3, 3>{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
				finer.push_back(f);
		}
		faces.swap(finer);
	}
	Welder welder;
	for (const auto& f : faces) welder.triangle(f[0], f[1], f[2]);
	return welder.mesh;
}

Mesh gridBox(const Vec3& size, int steps)
{
	const Vec3 x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
	Welder welder;
	welder.grid({}, y, x, steps);
	welder.grid({}, z, y, steps);
	welder.grid({}, x, z, steps);
	welder.grid(z, x, y, steps);
	welder.grid(x, y, z, steps);
	welder.grid(y, z, x, steps);
	return welder.mesh;
}

Mesh lPlate(double height, int steps)
{
	const Vec3 up{0, 0, height};
	Welder welder;
	const int cells[3][2] = {{0, 0}, {1, 0}, {0, 1}};
	for (const auto& c : cells)
	{
		const Vec3 o{double(c[0]), double(c[1]), 0};
		welder.grid(o + up, {1, 0, 0}, {0, 1, 0}, steps);
		welder.grid(o, {0, 1, 0}, {1, 0, 0}, steps);
	}
	const Vec3 outline[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
	for (int i = 0; i < 8; ++i) welder.grid(outline[i], outline[(i + 1) % 8] - outline[i], up, steps);
	return welder.mesh;
}

Mesh notchedPlate(double height, double width, double depth)
{
	const Vec3 up{0, 0, height}, middle{0.5, 0.3, 0};
	const double left = 0.5 - 0.5 * width, right = 0.5 + 0.5 * width;
	const Vec3 outline[] = {{0, 0, 0},           {1, 0, 0},    {1, 1, 0}, {right, 1, 0},
							{0.5, 1 - depth, 0}, {left, 1, 0}, {0, 1, 0}};
	Welder welder;
	for (std::size_t i = 0; i < 7; ++i)
	{
		const Vec3 &p = outline[i], &q = outline[(i + 1) % 7];
		welder.triangle(middle + up, p + up, q + up);
		welder.triangle(middle, q, p);
		welder.grid(p, q - p, up, 1);
	}
	return welder.mesh;
}

Mesh periodicGrid(int columns, int rows, const std::function<Vec3(double, double)>& point)
{
	Welder welder;
	const auto at = [&](int i, int j) { return point(double(i % columns) / columns, double(j % rows) / rows); };
	for (int i = 0; i < columns; ++i)
		for (int j = 0; j < rows; ++j)
		{
			welder.triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
			welder.triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
		}
	return welder.mesh;
}

Mesh wrinkledTorus(int columns, int rows, double amplitude, int waves)
{
	return periodicGrid(columns, rows,
						[=](double s, double t)
						{
							const double a = 2 * kPi * s, b = 2 * kPi * t;
							const double tube = 0.4 * (1 + amplitude * std::cos(waves * a));
							const double ring = 1 + tube * std::cos(b);
							return Vec3{ring * std::cos(a), ring * std::sin(a), tube * std::sin(b)};
						});
}

Mesh thickCup(int columns, int perSide, double wall)
{
	// Profile from the outer bottom centre round the rim to the inner bottom centre, in (radius, height).
	const Point2 corners[] = {{0, 0}, {0.8, 0}, {1, 1.6}, {1 - wall, 1.6}, {0.8 - wall, wall}, {0, wall}};
	std::vector<Point2> profile;
	for (int c = 0; c < 5; ++c)
		for (int k = 0; k < perSide; ++k)
			profile.push_back({corners[c].x + (corners[c + 1].x - corners[c].x) * k / perSide,
							   corners[c].y + (corners[c + 1].y - corners[c].y) * k / perSide});
	profile.push_back(corners[5]);
	const auto at = [&](const Point2& p, int i)
	{
		const double a = 2 * kPi * (i % columns) / columns;
		return Vec3{p.x * std::cos(a), p.y, -p.x * std::sin(a)};
	};
	Welder welder;
	for (std::size_t k = 0; k + 1 < profile.size(); ++k)
		for (int i = 0; i < columns; ++i)
		{
			const Vec3 a = at(profile[k], i), b = at(profile[k], i + 1);
			const Vec3 c = at(profile[k + 1], i + 1), d = at(profile[k + 1], i);
			if (profile[k].x != 0) welder.triangle(a, b, c);
			if (profile[k + 1].x != 0) welder.triangle(a, c, d);
		}
	return welder.mesh;
}
}  // namespace clod::builder::test
