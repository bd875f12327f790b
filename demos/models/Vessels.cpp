// SPDX-License-Identifier: Zlib
// A tumbler whose wall is a cone, so that others stand in it, and a dish that is part of a hollow ball.
#include <algorithm>
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/models/Profile.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double TUMBLER_EDGE = 0.003;  // rounding of the foot, outside
constexpr double DISH_REACH = 55 * PI / 180;
constexpr double CAP_SHARE = 0.7;  // of the flat middle that a cap covers
constexpr double DISH_CAP = 0.2;   // way along the profile that a cap covers, over the radius
constexpr double STRIPS = 7;       // for each cell of a cap

double slope()
{
	return std::atan2(TUMBLER_TOP - TUMBLER_FOOT, TUMBLER_HEIGHT);  // of the wall against the vertical
}

ModelMesh turnedSolid(const Profile& profile, double capEnd, const SweepSize& size)
{
	if (size.capCells == 0) return {};
	SweepGrid grid;
	grid.capCells = size.capCells;
	grid.sEnd = profile.length();
	const auto density = [&](double s) { return 1 + 0.003 * profile.curvature(s); };
	grid.rings = spread(density, capEnd, profile.length() - capEnd, size.strips);
	return sweep(
		[&](double s, double turn) -> Vec3
		{
			const ProfilePoint p = profile.at(s);
			return {p.radius * std::cos(2 * PI * turn), p.height, p.radius * std::sin(2 * PI * turn)};
		},
		grid);
}

// A flat bottom, a rounded edge, the cone, a round rim, and the same inside at the wall's thickness.
Profile tumblerProfile()
{
	const double lean = slope(), half = TUMBLER_WALL / 2;
	const ProfilePoint out = {std::cos(lean), -std::sin(lean)}, up = {std::sin(lean), std::cos(lean)};
	// The rounding touches the ground and the cone through (TUMBLER_FOOT, 0).
	const ProfilePoint edge = {TUMBLER_FOOT - TUMBLER_EDGE * (1 + out.height) / out.radius, TUMBLER_EDGE};
	const double rise = (TUMBLER_HEIGHT - half - edge.height) / up.height;  // to the rim's middle
	const auto onWall = [&](double radius, double along) -> ProfilePoint
	{
		return {edge.radius + radius * out.radius + along * up.radius,
				edge.height + radius * out.height + along * up.height};
	};
	const double inner = TUMBLER_EDGE - TUMBLER_WALL;
	Profile p;
	p.line({0, 0}, {edge.radius, 0});
	p.arc(edge, TUMBLER_EDGE, -PI / 2, -lean);
	p.line(onWall(TUMBLER_EDGE, 0), onWall(TUMBLER_EDGE, rise));
	p.arc(onWall(TUMBLER_EDGE - half, rise), half, -lean, PI - lean);
	p.line(onWall(inner, rise), onWall(inner, 0));
	p.arc(edge, inner, -lean, -PI / 2);
	p.line({edge.radius, TUMBLER_WALL}, {0, TUMBLER_WALL});
	return p;
}

// With the vertices of the inside so far out that its triangles keep clear of the ball.
Profile dishProfile(const SweepSize& size)
{
	const double columns = 4.0 * size.capCells, strip = 2 * DISH_REACH / std::max(1, size.strips);
	const double inside = DISH_RADIUS / std::cos(PI / columns) / std::cos(strip / 2);
	const double outside = inside + DISH_WALL, angle = DISH_REACH - PI / 2, middle = inside + DISH_WALL / 2;
	Profile p;
	p.arc({}, outside, -PI / 2, angle);
	p.arc({middle * std::cos(angle), middle * std::sin(angle)}, DISH_WALL / 2, angle, angle + PI);
	p.arc({}, inside, angle, -PI / 2);
	return p;
}
}  // namespace

const double TUMBLER_PITCH = TUMBLER_WALL / std::sin(slope());

ModelMesh makeTumbler(size_t triangles)
{
	return turnedSolid(tumblerProfile(), CAP_SHARE * (TUMBLER_FOOT - TUMBLER_EDGE), sweepSize(triangles, STRIPS));
}

ModelMesh makeDish(size_t triangles)
{
	const SweepSize size = sweepSize(triangles, STRIPS);
	return turnedSolid(dishProfile(size), DISH_CAP * DISH_RADIUS, size);
}
}  // namespace clod::demo
