// SPDX-License-Identifier: GPL-3.0-or-later
// Closed test meshes of a few hundred to a few thousand triangles, coordinates rounded to float.
#pragma once
#include <functional>

#include "builder/Lod.h"

namespace clod::builder::test
{
Mesh icosphere(int subdivisions);
// A box [0, size] with steps x steps squares on every side, cut into two triangles each.
Mesh gridBox(const Vec3& size, int steps);
// An L of unit squares (three of a 2 x 2 block), extruded by height, every square refined into steps x steps.
Mesh lPlate(double height, int steps);
// A unit square with a notch of the given width and depth in the middle of one side, extruded by height.
Mesh notchedPlate(double height, double width, double depth);
// A grid over two periodic directions; point(i, j) in [0,1) each.
Mesh periodicGrid(int columns, int rows, const std::function<Vec3(double, double)>& point);
Mesh wrinkledTorus(int columns, int rows, double amplitude, int waves);
// A closed profile revolved about y: a cup of outer radius 1 with walls and bottom of the given thickness.
Mesh thickCup(int columns, int perSide, double wall);
}  // namespace clod::builder::test
