// SPDX-License-Identifier: Zlib
// A bolt that stands on its head and a nut that runs on it: a four-start thread on both, with play between them. Fine
// detail all over a simple body, which uniform decimation destroys before it saves much.
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
constexpr double PITCH = THREAD_LEAD / THREAD_STARTS;
constexpr double MEAN_RADIUS = 0.0055, HALF_DEPTH = 0.00055;  // of the bolt's thread
constexpr double HEAD_RADIUS = 0.009;                         // half the width across flats; of the nut too
constexpr double EDGE = 0.0005, FILLET = 0.001;               // rounding of the head's edges and of its neck
constexpr double FADE = 0.0012;                               // height over which a thread begins

double smoothStep(double from, double to, double x)
{
	const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
	return t * t * (3 - 2 * t);
}

// The thread's profile, between -1 (root of the bolt) and 1: a rounded trapezoid.
double threadProfile(double height, double turn)
{
	const double phase = 2 * PI * (THREAD_STARTS * turn - height / PITCH);
	return std::tanh(1.2 * std::cos(phase)) / std::tanh(1.2);
}

// A hexagon with rounded corners: distance from its middle, 1 at the middle of each side.
double hexagon(double turn)
{
	double sum = 0;
	for (int side = 0; side < 3; ++side) sum += std::pow(std::fabs(std::cos(2 * PI * turn + side * PI / 3)), 16);
	return std::pow(sum, -1.0 / 16);
}

Vec3 placed(double radius, double height, double turn)
{
	return {radius * std::cos(2 * PI * turn), height, radius * std::sin(2 * PI * turn)};
}

// Head below, shank above; the shank's radius is that of the thread's roots.
Profile boltProfile()
{
	const double root = MEAN_RADIUS - HALF_DEPTH, neck = root + FILLET;
	Profile p;
	p.line({0, 0}, {HEAD_RADIUS - EDGE, 0});
	p.arc({HEAD_RADIUS - EDGE, EDGE}, EDGE, -PI / 2, 0);
	p.line({HEAD_RADIUS, EDGE}, {HEAD_RADIUS, BOLT_HEAD_HEIGHT - EDGE});
	p.arc({HEAD_RADIUS - EDGE, BOLT_HEAD_HEIGHT - EDGE}, EDGE, 0, PI / 2);
	p.line({HEAD_RADIUS - EDGE, BOLT_HEAD_HEIGHT}, {neck, BOLT_HEAD_HEIGHT});
	p.arc({neck, BOLT_HEAD_HEIGHT + FILLET}, FILLET, 1.5 * PI, PI);
	p.line({root, BOLT_HEAD_HEIGHT + FILLET}, {root, BOLT_HEIGHT - FILLET});
	p.arc({root - FILLET, BOLT_HEIGHT - FILLET}, FILLET, 0, PI / 2);
	p.line({root - FILLET, BOLT_HEIGHT}, {0, BOLT_HEIGHT});
	return p;
}

Vec3 boltSurface(const Profile& profile, double s, double turn)
{
	const ProfilePoint p = profile.at(s);
	const double low = BOLT_HEAD_HEIGHT + FILLET, high = BOLT_HEIGHT - FILLET;
	const bool isShank = p.height > BOLT_HEAD_HEIGHT + 1e-9 && p.radius < MEAN_RADIUS;
	const double thread =
		isShank ? smoothStep(low, low + FADE, p.height) * (1 - smoothStep(high - FADE, high, p.height)) : 0;
	const double head = smoothStep(MEAN_RADIUS + FILLET, HEAD_RADIUS - EDGE, p.radius);
	const double inHead = p.height < BOLT_HEAD_HEIGHT + 1e-9 ? head : 0;
	const double radius = p.radius * (1 + inHead * (hexagon(turn) - 1));
	return placed(radius + thread * HALF_DEPTH * (1 + threadProfile(p.height, turn)), p.height, turn);
}

// Corners of the nut's section, from the inner side's foot; the shares of the grid's points on each side.
constexpr double INNER_SHARE = 0.60, FLAT_SHARE = 0.09;

Vec3 nutSurface(double along, double turn)
{
	const double root = MEAN_RADIUS + THREAD_PLAY + HALF_DEPTH, half = NUT_HEIGHT / 2;
	const double outer = HEAD_RADIUS * hexagon(turn);
	if (along < INNER_SHARE)
	{
		const double height = half - NUT_HEIGHT * along / INNER_SHARE;
		const double thread = smoothStep(half, half - FADE, std::fabs(height));
		return placed(root - thread * HALF_DEPTH * (1 - threadProfile(height, turn)), height, turn);
	}
	const double below = (along - INNER_SHARE) / FLAT_SHARE, above = (1 - along) / FLAT_SHARE;
	if (below < 1) return placed(root + below * (outer - root), -half, turn);
	if (above < 1) return placed(root + above * (outer - root), half, turn);
	const double side = (along - INNER_SHARE - FLAT_SHARE) / (1 - INNER_SHARE - 2 * FLAT_SHARE);
	return placed(outer, half * (2 * side - 1), turn);
}
}  // namespace

ModelMesh makeBolt(size_t triangles)
{
	const SweepSize size = sweepSize(triangles, 16);
	if (size.capCells == 0) return {};
	const Profile profile = boltProfile();
	// Three times as many strips on the thread.
	const auto density = [&](double s) { return profile.at(s).radius < MEAN_RADIUS ? 3.0 : 1.0; };
	SweepGrid grid;
	grid.capCells = size.capCells;
	grid.sEnd = profile.length();
	grid.rings = spread(density, 0.75 * HEAD_RADIUS, profile.length() - 0.6 * MEAN_RADIUS, size.strips);
	return sweep([&](double s, double turn) { return boltSurface(profile, s, turn); }, grid);
}

ModelMesh makeNut(size_t triangles)
{
	const RingSize size = ringSize(triangles, 1.25);
	return ringGrid(size, nutSurface);
}
}  // namespace clod::demo
