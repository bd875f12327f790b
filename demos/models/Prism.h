// SPDX-License-Identifier: Zlib
// Solids cut from plates: layers along z, each the extrusion of a planar region between closed loops. Flat sides carry
// triangles that grow away from fine loops (points no nearer than the local size, then Delaunay, smoothed).
#pragma once
#include <functional>
#include <vector>

#include "demos/models/Models.h"

namespace clod::demo
{
struct PlanarPoint
{
	double x = 0, y = 0;
};
// Closed, the solid on its left: counter-clockwise outside, clockwise round a hole.
using Loop = std::vector<PlanarPoint>;

// Sides cut evenly into pieces of about `edge`.
Loop polygonLoop(const std::vector<PlanarPoint>& corners, double edge);
// A regular polygon in the circle.
Loop discLoop(const PlanarPoint& centre, double radius, double edge);
// One round the circle, so that what fits into the circle fits into the hole.
Loop holeLoop(const PlanarPoint& centre, double radius, double edge);
// Two half circles round `from` and `to` and their tangents. Half circles have pieces of `arcEdge`.
Loop stadiumLoop(const PlanarPoint& from, const PlanarPoint& to, double radius, double edge, double arcEdge);

struct PrismLayer
{
	std::vector<size_t> loops;  // in Prism::loops
	double height;
};

struct Prism
{
	std::vector<Loop> loops;
	// Upward from z = bottom. Of two neighbours one contains the other's region; a loop in both is one wall.
	std::vector<PrismLayer> layers;
	double bottom = 0;
};

// The prism whose triangle count comes closest to `triangles` among those that `atEdge` makes for lengths of triangles'
// edges; empty where it makes none that closes.
ModelMesh makePrism(size_t triangles, const std::function<Prism(double edge)>& atEdge);
}  // namespace clod::demo
