// SPDX-License-Identifier: Zlib
// Closed grids over surfaces. Open ones S(s, turn): rings of 4 m vertices along s, each end closed by an m x m grid, so
// that there is no pole with a fan of slivers (8 m strips + 4 m m triangles). And rings, closed both ways.
// The square-to-disc map of the caps is Shirley & Chiu, "A low distortion map between disk and square" (1997).
#pragma once
#include <functional>
#include <vector>

#include "demos/models/Models.h"

namespace clod::demo
{
// s grows from one end of the surface to the other, turn goes once round in [0, 1) and may leave that range.
using SweepSurface = std::function<Vec3(double s, double turn)>;

struct SweepGrid
{
	int capCells = 4;                                   // m
	double sBegin = 0, sEnd = 1;                        // where the surface closes
	std::vector<double> rings;                          // s of each ring, increasing, inside (sBegin, sEnd)
	double turnOffset = 0;                              // turn of column 0
	std::function<bool(int strip, int column)> isHole;  // quads left out; empty: none
	int columns() const { return 4 * capCells; }
};

// Vertices of ring i, column j come first, at i * columns() + j.
ModelMesh sweep(const SweepSurface& surface, const SweepGrid& grid);

// A ring: `along` sections, each a closed curve of `around` points.
struct RingSize
{
	int along = 0, around = 0;
};
// The size whose count is closest to `triangles`, among those with along / around near `ratio`; 0: none.
RingSize ringSize(size_t triangles, double ratio);
// Closed grid over surface(section, turn), both in [0, 1) and periodic; 2 along x around triangles.
ModelMesh ringGrid(const RingSize& size, const std::function<Vec3(double section, double turn)>& surface);

// `strips` + 1 values from `from` to `to`, spaced inversely to a positive density.
std::vector<double> spread(const std::function<double(double)>& density, double from, double to, int strips);
double integrate(const std::function<double(double)>& density, double from, double to);

// The two triangles of quad a b c d, cut along its shorter diagonal (a-c unless b-d is clearly shorter).
void addQuad(ModelMesh& mesh, const std::array<uint32_t, 4>& quad);
double signedVolume(const ModelMesh& mesh);
void orientOutward(ModelMesh& mesh);
void dropUnusedVertices(ModelMesh& mesh);

struct SweepSize
{
	int capCells = 0, strips = 0;
};
// The size whose count is closest to `triangles`, among those with strips / capCells near `ratio`; 0 cells: none.
SweepSize sweepSize(size_t triangles, double ratio);
}  // namespace clod::demo
