// SPDX-License-Identifier: GPL-3.0-or-later
// A triangle against the inside of a convex hull, two triangles against each other, a point against a triangle.
// Sources: Sutherland & Hodgman 1974 (clipping); Ericson, Real-Time Collision Detection, 5.1.5 (closest point).
#pragma once
#include <array>
#include <vector>

#include "builder/patches/Orientation.h"

namespace clod::builder
{
using TrianglePoints = std::array<Vec3, 3>;

// Keeps the part of a convex polygon that lies deeper than depth below the plane.
void clipBelow(std::vector<Vec3>& polygon, const Plane& plane, double depth, std::vector<Vec3>& scratch);

// Whether some point of the triangle lies deeper than depth below every plane. A separating plane is looked for first.
bool entersHull(const TrianglePoints& triangle, const std::vector<Plane>& planes, double depth);

// Whether the two triangles cross or touch in more than the vertices they share (equal coordinates are shared
// vertices). Coplanar triangles count as apart.
bool trianglesCross(const TrianglePoints& a, const TrianglePoints& b);

double squaredDistance(const Vec3& p, const TrianglePoints& t);

struct Point2
{
	double x = 0, y = 0;
};
// Twice the area of a triangle; positive where c lies to the left of the line from a to b.
double cross2(const Point2& a, const Point2& b, const Point2& c);
// Counter-clockwise convex hull, without collinear points.
std::vector<Point2> convexHull(std::vector<Point2> points);
double areaOf(const std::vector<Point2>& polygon);
double perimeterOf(const std::vector<Point2>& polygon);
// Part of a polygon inside a counter-clockwise convex one.
std::vector<Point2> clipped(std::vector<Point2> polygon, const std::vector<Point2>& convex);
}  // namespace clod::builder
