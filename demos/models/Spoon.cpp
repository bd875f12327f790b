// SPDX-License-Identifier: Zlib
// A teaspoon along x, bowl first: a middle surface (a dished bowl running out into a rising handle) thickened along its
// normal, with rounded edges all round. Sections across x are stadium curves, closed by caps at both ends.
#include <algorithm>
#include <cmath>

#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double BOWL_MIDDLE = 0.023, BOWL_FRONT = 0.023, BOWL_BACK = 0.031;  // along x; half lengths before and behind
constexpr double BOWL_HALF_WIDTH = 0.0145, BOWL_DEPTH = 0.0075;
constexpr double NECK_HALF_WIDTH = 0.0022, END_HALF_WIDTH = 0.005;
constexpr double NECK_HALF_THICKNESS = 0.0014, END_HALF_THICKNESS = 0.0010;
constexpr double HANDLE_RISE = 0.014;
constexpr double SOFTNESS = 0.15;  // of the bowl's depth, over which its edge is rounded into the handle

double smoothStep(double from, double to, double x)
{
	const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
	return t * t * (3 - 2 * t);
}

double smoothStepSlope(double from, double to, double x)
{
	const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
	return 6 * t * (1 - t) / (to - from);
}

double bowlCoordinate(double x)
{
	return (x - BOWL_MIDDLE) / (x < BOWL_MIDDLE ? BOWL_FRONT : BOWL_BACK);
}

// Square of the outline's half width over BOWL_HALF_WIDTH, and its slope: an ellipse in front, drawn out towards the
// handle behind; it goes on below zero beyond the bowl.
struct Outline
{
	double square, slope;
};

Outline bowlOutline(double x)
{
	const double xi = bowlCoordinate(x), ellipse = 1 - xi * xi;
	if (xi < 0) return {ellipse, -2 * xi / BOWL_FRONT};
	const double root = std::sqrt(std::fabs(ellipse));
	return {ellipse * root, -3 * xi * root / BOWL_BACK};
}

double halfWidth(double x)
{
	const double bowl = BOWL_HALF_WIDTH * std::sqrt(std::max(0.0, bowlOutline(x).square));
	const double grown = NECK_HALF_WIDTH + (END_HALF_WIDTH - NECK_HALF_WIDTH) * smoothStep(0.055, 0.125, x);
	const double end = std::max(0.0, x - (SPOON_LENGTH - END_HALF_WIDTH)) / END_HALF_WIDTH;
	const double handle = grown * smoothStep(0.020, 0.045, x) * std::sqrt(std::max(0.0, 1 - end * end));
	// Smooth maximum: a fillet where the bowl's outline meets the handle's.
	const double blend = 0.008 * smoothStep(0.020, 0.036, x) * (1 - smoothStep(0.058, 0.080, x));
	const double overlap = blend > 0 ? std::max(0.0, 1 - std::fabs(bowl - handle) / blend) : 0;
	return std::max(bowl, handle) + 0.25 * blend * overlap * overlap;
}

double halfThickness(double x)
{
	const double bowl = SPOON_BOWL_THICKNESS / 2;
	const double t = bowl + (NECK_HALF_THICKNESS - bowl) * smoothStep(0.036, 0.060, x) +
					 (END_HALF_THICKNESS - NECK_HALF_THICKNESS) * smoothStep(0.065, 0.125, x);
	const double end = std::max(0.0, 1 - std::min(x, SPOON_LENGTH - x) / t);
	return t * std::sqrt(std::max(0.0, 1 - end * end));
}

struct MiddlePoint
{
	Vec3 point, normal;
};

MiddlePoint middleSurface(double x, double z)
{
	const Outline outline = bowlOutline(x);
	const double zeta = z / BOWL_HALF_WIDTH, q = outline.square - zeta * zeta;
	const double root = std::sqrt(q * q + SOFTNESS * SOFTNESS);
	const double depth = BOWL_DEPTH * 0.5 * (q + root), slope = BOWL_DEPTH * 0.5 * (1 + q / root);
	const double y = HANDLE_RISE * smoothStep(0.030, SPOON_LENGTH, x) - depth;
	const double yx = HANDLE_RISE * smoothStepSlope(0.030, SPOON_LENGTH, x) - slope * outline.slope;
	const double yz = slope * 2 * zeta / BOWL_HALF_WIDTH;
	return {{x, y, z}, normalized({-yx, 1, -yz})};
}

// x grows with the square of the distance from either end, so that sections there grow linearly.
double xAt(double s)
{
	return 0.5 * SPOON_LENGTH * (1 + std::sin(0.5 * PI * s));
}
double sAt(double x)
{
	return std::asin(2 * x / SPOON_LENGTH - 1) * 2 / PI;
}

// The stadium section; its round ends take twice the share of their length.
Vec3 spoonSurface(double s, double turn)
{
	const double x = xAt(s), thickness = halfThickness(x);
	const double flat = std::max(0.0, halfWidth(x) - thickness);
	const double round = 2 * PI * thickness, total = 2 * (2 * flat + round);
	double u = (turn - std::floor(turn)) * total;
	double side = 1;
	if (u >= total / 2)
	{
		u -= total / 2;
		side = -1;
	}
	// Half a section: the upper half of the edge at +z, the flat to -z, the lower half of the edge at -z; then again.
	double across = 0, up = 0;
	const double halfRound = round / 2;
	if (u < halfRound || u > halfRound + 2 * flat)
	{
		const bool first = u < halfRound;
		const double angle = first ? (halfRound > 0 ? u / halfRound : 0) * PI / 2
								   : PI / 2 * (1 + (u - halfRound - 2 * flat) / halfRound);
		across = (first ? flat : -flat) + thickness * std::cos(angle);
		up = thickness * std::sin(angle);
	}
	else
	{
		across = flat - (u - halfRound);
		up = thickness;
	}
	const MiddlePoint middle = middleSurface(x, side * across);
	return middle.point + side * up * middle.normal;
}

double perimeter(double x)
{
	return 4 * halfWidth(x) + 2 * PI * halfThickness(x);
}

// Strips as long as the square root of the section's perimeter: between square cells and even strips.
double stripDensity(double s)
{
	constexpr int LINES = 8;
	constexpr double STEP = 1e-4;
	double sum = 0;
	for (int i = 0; i < LINES; ++i)
		sum += length(spoonSurface(s + STEP, double(i) / LINES) - spoonSurface(s - STEP, double(i) / LINES));
	return sum / std::sqrt(perimeter(xAt(s)));
}
}  // namespace

ModelMesh makeSpoon(size_t triangles)
{
	const SweepSize size = sweepSize(triangles, 370.0 / 28);
	if (size.capCells == 0) return {};
	SweepGrid grid;
	grid.capCells = size.capCells;
	grid.sBegin = -1;
	grid.sEnd = 1;
	grid.turnOffset = -0.125;
	grid.rings = spread(stripDensity, sAt(0.0006), sAt(SPOON_LENGTH - 0.0009), size.strips);
	return sweep(spoonSurface, grid);
}
}  // namespace clod::demo
