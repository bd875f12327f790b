// SPDX-License-Identifier: Zlib
// Ring, box and ball: the wrinkled torus of the benchmark and the plain test shapes.
#include <algorithm>
#include <cmath>
#include <map>

#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr int SAMPLES_PER_WAVE = 4;

struct BoxSize
{
	std::array<int, 3> cells = {0, 0, 0};
	double triangles() const
	{
		return 4.0 * (double(cells[0]) * cells[1] + double(cells[1]) * cells[2] + double(cells[2]) * cells[0]);
	}
};

BoxSize boxSize(const Vec3& size, size_t triangles)
{
	const double area = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
	const double cell = std::sqrt(2 * area / double(triangles));
	BoxSize best;
	// Candidates: cell edges within 30 % of the one that the area gives.
	for (int i = 0; i <= 600; ++i)
	{
		BoxSize b;
		for (int k = 0; k < 3; ++k)
			b.cells[size_t(k)] = std::max(1, int(std::lround(size[k] / (cell * (0.7 + i * 0.001)))));
		const double error = std::fabs(b.triangles() - double(triangles));
		if (best.cells[0] == 0 || error < std::fabs(best.triangles() - double(triangles))) best = b;
	}
	return best;
}

// The surface of a grid of cells, each lattice point once.
ModelMesh latticeBox(const std::array<int, 3>& cells)
{
	ModelMesh mesh;
	std::map<std::array<int, 3>, uint32_t> ids;
	const auto id = [&](const std::array<int, 3>& p)
	{
		const auto [entry, isNew] = ids.emplace(p, uint32_t(mesh.vertices.size()));
		if (isNew) mesh.vertices.push_back({double(p[0]), double(p[1]), double(p[2])});
		return entry->second;
	};
	for (size_t axis = 0; axis < 3; ++axis)
		for (const bool high : {false, true})
		{
			const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
			for (int i = 0; i < cells[u]; ++i)
				for (int j = 0; j < cells[v]; ++j)
				{
					const auto corner = [&](int di, int dj)
					{
						std::array<int, 3> p = {};
						p[axis] = high ? cells[axis] : 0;
						p[u] = i + di;
						p[v] = j + dj;
						return id(p);
					};
					std::array<uint32_t, 4> quad = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
					if (!high) std::swap(quad[1], quad[3]);
					mesh.triangles.push_back({quad[0], quad[1], quad[2]});
					mesh.triangles.push_back({quad[0], quad[2], quad[3]});
				}
		}
	return mesh;
}
}  // namespace

ModelMesh makeTorus(size_t triangles, double wrinkle)
{
	const RingSize size = ringSize(triangles, 6.4);
	const double amplitude = size.along >= SAMPLES_PER_WAVE * TORUS_WAVES ? wrinkle : 0;
	return ringGrid(size,
					[&](double section, double turn) -> Vec3
					{
						const double u = 2 * PI * turn, v = 2 * PI * section;
						// The waves swing to and fro round the tube, so that they are curved like folds of cloth.
						const double tube =
							TORUS_TUBE_RADIUS * (1 + amplitude * std::cos(TORUS_WAVES * u + 2 * std::sin(2 * v)));
						const double ring = TORUS_RING_RADIUS + tube * std::cos(v);
						return {ring * std::cos(u), tube * std::sin(v), ring * std::sin(u)};
					});
}

ModelMesh makeBox(const Vec3& size, size_t triangles)
{
	const BoxSize grid = boxSize(size, triangles);
	ModelMesh mesh = latticeBox(grid.cells);
	for (Vec3& v : mesh.vertices)
		for (int k = 0; k < 3; ++k) v[k] = size[k] * (v[k] / grid.cells[size_t(k)] - 0.5);
	return mesh;
}

double landscapeHeight(double x, double z)
{
	constexpr double AMPLITUDE = 0.01, ACROSS = 0.5, ALONG = 0.4;
	return AMPLITUDE * std::sin(2 * PI / ACROSS * x) * std::cos(2 * PI / ALONG * z);
}

ModelMesh makeLandscape(size_t triangles)
{
	ModelMesh mesh = makeBox({LANDSCAPE_WIDTH, LANDSCAPE_THICKNESS, LANDSCAPE_WIDTH}, triangles);
	for (Vec3& v : mesh.vertices) v.y += landscapeHeight(v.x, v.z) - 0.5 * LANDSCAPE_THICKNESS;
	return mesh;
}

ModelMesh makeSphere(size_t triangles, double radius)
{
	const int n = std::max(1, int(std::lround(std::sqrt(double(triangles) / 12))));
	ModelMesh mesh = latticeBox({n, n, n});
	for (Vec3& v : mesh.vertices)
	{
		// Even angles along the cube's edges keep the cells alike.
		for (int k = 0; k < 3; ++k) v[k] = std::tan(PI / 4 * (2 * v[k] / n - 1));
		v = radius * normalized(v);
	}
	return mesh;
}
}  // namespace clod::demo
