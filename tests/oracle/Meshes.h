// SPDX-License-Identifier: GPL-3.0-or-later
// A small box of meshes for the oracle's poses: closed, oriented, made from a few numbers.
#pragma once
#include <functional>
#include <utility>

#include "tests/oracle/Subject.h"

namespace clod::oracle
{
using Point2 = std::pair<double, double>;

TriangleMesh box(const Vec3& half);
// The profile (radius, height) turned about y; closed on itself. Counter-clockwise with the radius to the right and the
// height up. A point of radius 0 is one vertex.
TriangleMesh turned(const std::vector<Point2>& profile, int segments);
TriangleMesh torus(double ring, double tube, int segments, int sides);  // axis y
// What lies between the heights y(x), given left to right, and the base; along z from -half to half.
TriangleMesh ridges(const std::vector<Point2>& heights, double base, double half);
// A wedge whose edge lies along z at the origin, pointing up; the full angle at the edge in radians.
TriangleMesh wedge(double angle, double height, double half);
// A prism over a star-shaped polygon: r(turn), turn from 0 to 2 pi; along z.
TriangleMesh prism(const std::vector<double>& radii, double half);
// A pyramid over a regular polygon, apex up at the origin, and a prism whose upper side is such a pit, its deepest
// point at the origin; both `height` deep and `radius` wide.
TriangleMesh spike(int sides, double radius, double height);
TriangleMesh pit(int sides, double radius, double height, double below);

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b, const Vec3& offsetOfB);
TriangleMesh moved(TriangleMesh mesh, const Transform& by);
TriangleMesh scaled(TriangleMesh mesh, double by);
}  // namespace clod::oracle
