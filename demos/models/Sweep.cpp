// SPDX-License-Identifier: Zlib
#include "demos/models/Sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace clod::demo
{
namespace
{
constexpr int INTEGRATION_STEPS = 8192;

// A point of the cap grid: q = 1 on the border, 0 in the middle; turn as on the ring.
struct DiscPoint
{
	double q, turn;
};

DiscPoint discPoint(int i, int j, int cells)
{
	const double a = double(2 * i - cells) / cells, b = double(2 * j - cells) / cells;
	const double q = std::max(std::fabs(a), std::fabs(b));
	if (q == 0) return {0, 0};
	double eighths = 0;  // position along the square's border, 0 at (1, 0), counter-clockwise
	if (a == q)
		eighths = b / q;
	else if (b == q)
		eighths = 2 - a / q;
	else if (a == -q)
		eighths = 4 - b / q;
	else
		eighths = 6 + a / q;
	return {q, eighths / 8};
}

// The column of a border point of the cap; columns start at the corner (1, -1).
int borderColumn(int i, int j, int cells)
{
	if (i == cells && j < cells) return j;
	if (j == cells && i > 0) return cells + (cells - i);
	if (i == 0 && j > 0) return 2 * cells + (cells - j);
	return 3 * cells + i;
}

void addCap(ModelMesh& mesh, const SweepSurface& surface, const SweepGrid& grid, bool atEnd)
{
	const int m = grid.capCells;
	const double pole = atEnd ? grid.sEnd : grid.sBegin;
	const double ring = atEnd ? grid.rings.back() : grid.rings.front();
	const uint32_t ringStart = atEnd ? uint32_t((grid.rings.size() - 1) * size_t(grid.columns())) : 0;
	std::vector<uint32_t> index(size_t(m + 1) * size_t(m + 1));
	for (int i = 0; i <= m; ++i)
		for (int j = 0; j <= m; ++j)
		{
			uint32_t& id = index[size_t(i * (m + 1) + j)];
			if (i == 0 || j == 0 || i == m || j == m)
			{
				id = ringStart + uint32_t(borderColumn(i, j, m));
				continue;
			}
			const DiscPoint p = discPoint(i, j, m);
			id = uint32_t(mesh.vertices.size());
			mesh.vertices.push_back(surface(pole + (ring - pole) * p.q, p.turn + 0.125 + grid.turnOffset));
		}
	for (int i = 0; i < m; ++i)
		for (int j = 0; j < m; ++j)
		{
			const auto at = [&](int di, int dj) { return index[size_t((i + di) * (m + 1) + j + dj)]; };
			std::array<uint32_t, 4> quad = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
			// The diagonal points at the middle, so that no corner triangle is flattened on the border.
			if ((2 * i < m) != (2 * j < m)) quad = {quad[1], quad[2], quad[3], quad[0]};
			if (!atEnd) std::swap(quad[1], quad[3]);
			mesh.triangles.push_back({quad[0], quad[1], quad[2]});
			mesh.triangles.push_back({quad[0], quad[2], quad[3]});
		}
}
}  // namespace

ModelMesh sweep(const SweepSurface& surface, const SweepGrid& grid)
{
	ModelMesh mesh;
	const int columns = grid.columns();
	for (const double s : grid.rings)
		for (int j = 0; j < columns; ++j) mesh.vertices.push_back(surface(s, double(j) / columns + grid.turnOffset));
	for (int i = 0; i + 1 < int(grid.rings.size()); ++i)
		for (int j = 0; j < columns; ++j)
		{
			if (grid.isHole && grid.isHole(i, j)) continue;
			const int next = (j + 1) % columns;
			addQuad(mesh, {uint32_t(i * columns + j), uint32_t(i * columns + next), uint32_t((i + 1) * columns + next),
						   uint32_t((i + 1) * columns + j)});
		}
	addCap(mesh, surface, grid, false);
	addCap(mesh, surface, grid, true);
	return mesh;
}

double integrate(const std::function<double(double)>& density, double from, double to)
{
	const double step = (to - from) / INTEGRATION_STEPS;
	double sum = 0;
	for (int i = 0; i < INTEGRATION_STEPS; ++i) sum += density(from + (i + 0.5) * step) * step;
	return sum;
}

std::vector<double> spread(const std::function<double(double)>& density, double from, double to, int strips)
{
	const double step = (to - from) / INTEGRATION_STEPS;
	std::vector<double> sums(1, 0.0);
	for (int i = 0; i < INTEGRATION_STEPS; ++i) sums.push_back(sums.back() + density(from + (i + 0.5) * step) * step);
	std::vector<double> values(1, from);
	size_t cell = 0;
	for (int k = 1; k < strips; ++k)
	{
		const double wanted = sums.back() * k / strips;
		while (sums[cell + 1] < wanted) ++cell;
		values.push_back(from + step * (double(cell) + (wanted - sums[cell]) / (sums[cell + 1] - sums[cell])));
	}
	values.push_back(to);
	return values;
}

void addQuad(ModelMesh& mesh, const std::array<uint32_t, 4>& quad)
{
	const auto& v = mesh.vertices;
	const double ac = lengthSquared(v[quad[2]] - v[quad[0]]), bd = lengthSquared(v[quad[3]] - v[quad[1]]);
	const size_t first = bd < ac * (1 - 1e-6) ? 1 : 0;
	const auto at = [&](size_t k) { return quad[(first + k) % 4]; };
	mesh.triangles.push_back({at(0), at(1), at(2)});
	mesh.triangles.push_back({at(0), at(2), at(3)});
}

double signedVolume(const ModelMesh& mesh)
{
	double sum = 0;
	for (const auto& t : mesh.triangles)
		sum += dot(mesh.vertices[t[0]], cross(mesh.vertices[t[1]], mesh.vertices[t[2]]));
	return sum / 6;
}

void orientOutward(ModelMesh& mesh)
{
	if (signedVolume(mesh) >= 0) return;
	for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

void dropUnusedVertices(ModelMesh& mesh)
{
	constexpr uint32_t UNUSED = UINT32_MAX;
	std::vector<uint32_t> newIndex(mesh.vertices.size(), UNUSED);
	for (const auto& t : mesh.triangles)
		for (const uint32_t v : t) newIndex[v] = 0;
	uint32_t count = 0;
	for (size_t v = 0; v < mesh.vertices.size(); ++v)
	{
		if (newIndex[v] == UNUSED) continue;
		mesh.vertices[count] = mesh.vertices[v];
		newIndex[v] = count++;
	}
	mesh.vertices.resize(count);
	for (auto& t : mesh.triangles)
		for (uint32_t& v : t) v = newIndex[v];
}

SweepSize sweepSize(size_t triangles, double ratio)
{
	const double target = double(triangles);
	// The aspect may leave the ideal by these factors; the first that has any candidate decides.
	for (const double allowed : {1.35, 2.0, 4.0})
	{
		SweepSize best;
		double bestError = 0, bestAspect = 0;
		for (int m = 2; 4.0 * m * m < target; ++m)
		{
			const int strips = int(std::lround((target - 4.0 * m * m) / (8.0 * m)));
			if (strips < 2) continue;
			const double aspect = std::fabs(std::log(strips / (m * ratio)));
			if (aspect > std::log(allowed)) continue;
			const double error = std::fabs(8.0 * m * strips + 4.0 * m * m - target);
			if (best.capCells == 0 || error < bestError || (error == bestError && aspect < bestAspect))
			{
				best = {m, strips};
				bestError = error;
				bestAspect = aspect;
			}
		}
		if (best.capCells > 0) return best;
	}
	return {};
}

RingSize ringSize(size_t triangles, double ratio)
{
	const double half = double(triangles) / 2;
	RingSize best;
	double bestError = 0, bestAspect = 0;
	for (int around = 3; 3.0 * around <= half; ++around)
	{
		const int along = int(std::lround(half / around));
		const double aspect = std::fabs(std::log(along / (ratio * around)));
		if (aspect > std::log(1.6)) continue;
		const double error = std::fabs(double(along) * around - half);
		if (best.along == 0 || error < bestError || (error == bestError && aspect < bestAspect))
		{
			best = {along, around};
			bestError = error;
			bestAspect = aspect;
		}
	}
	return best;
}

ModelMesh ringGrid(const RingSize& size, const std::function<Vec3(double section, double turn)>& surface)
{
	ModelMesh mesh;
	for (int i = 0; i < size.along; ++i)
		for (int j = 0; j < size.around; ++j)
			mesh.vertices.push_back(surface(double(j) / size.around, double(i) / size.along));
	for (int i = 0; i < size.along; ++i)
		for (int j = 0; j < size.around; ++j)
		{
			const auto at = [&](int di, int dj)
			{ return uint32_t((i + di) % size.along * size.around + (j + dj) % size.around); };
			addQuad(mesh, {at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
		}
	return mesh;
}
}  // namespace clod::demo
