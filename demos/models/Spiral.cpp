// SPDX-License-Identifier: Zlib
// The spiral peg: a round rod whose axis winds round the vertical like a corkscrew, standing on a round foot. A ring
// whose hole is wider than the rod but narrower than the winding can come down only by going round.
#include <algorithm>
#include <cmath>

#include "demos/models/Profile.h"
#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double WINDING_RADIUS = 0.006, PITCH = 0.060;
constexpr double FADE_LOW = 0.014, FADE_LOW_END = 0.050, FADE_HIGH = 0.200, FADE_HIGH_END = 0.234;
constexpr double FOOT_RADIUS = 0.026, FOOT_EDGE = 0.002, FOOT_FILLET = 0.008;

// Rises from 0 to 1 with two continuous derivatives.
double fade(double from, double to, double x)
{
	const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
	return t * t * t * (10 + t * (6 * t - 15));
}

double windingRadius(double height)
{
	return WINDING_RADIUS * fade(FADE_LOW, FADE_LOW_END, height) * (1 - fade(FADE_HIGH, FADE_HIGH_END, height));
}

// Radius of the section against height on the axis.
Profile pegProfile()
{
	const double footTop = 2 * FOOT_EDGE, filletMiddle = SPIRAL_ROD_RADIUS + FOOT_FILLET;
	Profile p;
	p.line({0, 0}, {FOOT_RADIUS - FOOT_EDGE, 0});
	p.arc({FOOT_RADIUS - FOOT_EDGE, FOOT_EDGE}, FOOT_EDGE, -PI / 2, PI / 2);
	p.line({FOOT_RADIUS - FOOT_EDGE, footTop}, {filletMiddle, footTop});
	p.arc({filletMiddle, footTop + FOOT_FILLET}, FOOT_FILLET, 1.5 * PI, PI);
	p.line({SPIRAL_ROD_RADIUS, footTop + FOOT_FILLET}, {SPIRAL_ROD_RADIUS, SPIRAL_HEIGHT - SPIRAL_ROD_RADIUS});
	p.arc({0, SPIRAL_HEIGHT - SPIRAL_ROD_RADIUS}, SPIRAL_ROD_RADIUS, 0, PI / 2);
	return p;
}

Vec3 pegSurface(const Profile& profile, double s, double turn)
{
	const ProfilePoint p = profile.at(s);
	const Vec3 tangent = spiralTangent(p.height);
	const Vec3 side = normalized(Vec3{1, 0, 0} - tangent.x * tangent), other = cross(tangent, side);
	const double angle = 2 * PI * turn;
	return spiralAxis(p.height) + p.radius * (std::cos(angle) * side + std::sin(angle) * other);
}
}  // namespace

Vec3 spiralAxis(double height)
{
	const double r = windingRadius(height), angle = 2 * PI * height / PITCH;
	return {r * std::cos(angle), height, r * std::sin(angle)};
}

Vec3 spiralTangent(double height)
{
	constexpr double STEP = 1e-6;
	return normalized(spiralAxis(height + STEP) - spiralAxis(height - STEP));
}

ModelMesh makeSpiral(size_t triangles)
{
	const SweepSize size = sweepSize(triangles, 329.0 / 12);
	if (size.capCells == 0) return {};
	const Profile profile = pegProfile();
	// Longer strips on the wide foot, shorter ones round the foot's edge.
	const auto density = [&](double s)
	{ return 1 / std::max(0.8 * SPIRAL_ROD_RADIUS, profile.at(s).radius) + 0.3 * profile.curvature(s); };
	SweepGrid grid;
	grid.capCells = size.capCells;
	grid.sEnd = profile.length();
	grid.rings = spread(density, 0.8 * FOOT_RADIUS, profile.length() - 0.65 * SPIRAL_ROD_RADIUS, size.strips);
	return sweep([&](double s, double turn) { return pegSurface(profile, s, turn); }, grid);
}
}  // namespace clod::demo
