// SPDX-License-Identifier: Zlib
// A rack with teeth on both sides and an involute pinion that runs on it: full-depth teeth, flanks of 20 degrees.
#include <algorithm>
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/models/Prism.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double PRESSURE_ANGLE = 20 * PI / 180, WIDTH = 0.010;
constexpr double PITCH = PI * TOOTH_MODULE, TIP = TOOTH_MODULE, ROOT = -1.25 * TOOTH_MODULE;
constexpr double HALF_TOOTH = PITCH / 4 - BACKLASH / 4;  // on the pitch line
constexpr int FEWEST_FLANK_PIECES = 2;

double involute(double angle)
{
	return std::tan(angle) - angle;
}

// Half the angle that a tooth of the pinion covers at a radius; straight down from the base circle.
double halfAngle(double radius)
{
	const double base = PINION_PITCH_RADIUS * std::cos(PRESSURE_ANGLE);
	const double pressure = radius > base ? std::acos(base / radius) : 0;
	return HALF_TOOTH / PINION_PITCH_RADIUS + involute(PRESSURE_ANGLE) - involute(pressure);
}

Loop pinionLoop(double edge)
{
	const int flank = std::max(FEWEST_FLANK_PIECES, int(std::lround((TIP - ROOT) / edge)));
	const double inner = PINION_PITCH_RADIUS + ROOT, outer = PINION_PITCH_RADIUS + TIP;
	Loop loop;
	for (int tooth = 0; tooth < PINION_TEETH; ++tooth)
		for (const int side : {-1, 1})
			for (int i = 0; i <= flank; ++i)
			{
				const double radius = inner + (outer - inner) * (side < 0 ? i : flank - i) / flank;
				const double angle = 2 * PI * (tooth + 0.5) / PINION_TEETH + side * halfAngle(radius);
				loop.push_back({radius * std::cos(angle), radius * std::sin(angle)});
			}
	return loop;
}

Loop rackLoop(double edge)
{
	std::vector<PlanarPoint> right;
	const double end = PITCH * RACK_TEETH / 2;
	right.push_back({RACK_PITCH_LINE + ROOT, -end});
	for (int tooth = 0; tooth < RACK_TEETH; ++tooth)
		for (const auto& [out, side] : {std::make_pair(ROOT, -1), {TIP, -1}, {TIP, 1}, {ROOT, 1}})
			right.push_back({RACK_PITCH_LINE + out,
							 PITCH * (tooth - RACK_TEETH / 2) + side * (HALF_TOOTH - out * std::tan(PRESSURE_ANGLE))});
	right.push_back({RACK_PITCH_LINE + ROOT, end});
	std::vector<PlanarPoint> corners = right;
	for (auto p = right.rbegin(); p != right.rend(); ++p) corners.push_back({-p->x, p->y});
	return polygonLoop(corners, edge);
}

ModelMesh toothed(size_t triangles, Loop (*loop)(double edge))
{
	return makePrism(triangles, [loop](double edge) { return Prism{{loop(edge)}, {{{0}, WIDTH}}, -WIDTH / 2}; });
}
}  // namespace

ModelMesh makePinion(size_t triangles)
{
	return toothed(triangles, pinionLoop);
}

ModelMesh makeRack(size_t triangles)
{
	return toothed(triangles, rackLoop);
}
}  // namespace clod::demo
