// SPDX-License-Identifier: Zlib
// Level colours from viridis (Smith & van der Walt 2015) without its darkest quarter, in which no shading can be seen;
// and cameras.
#include <algorithm>
#include <cmath>

#include "demos/render/Renderer.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
// Nine even stops of viridis, and where the colours begin.
constexpr double kDarkest = 0.25;
constexpr float VIRIDIS[9][3] = {{0.267f, 0.005f, 0.329f}, {0.279f, 0.175f, 0.483f}, {0.230f, 0.322f, 0.546f},
								 {0.173f, 0.449f, 0.558f}, {0.128f, 0.567f, 0.551f}, {0.154f, 0.680f, 0.504f},
								 {0.361f, 0.786f, 0.388f}, {0.668f, 0.862f, 0.196f}, {0.993f, 0.906f, 0.144f}};
}  // namespace

Color levelColor(int level, int levelCount)
{
	const double share = levelCount > 1 ? std::clamp(double(level) / (levelCount - 1), 0.0, 1.0) : 0;
	const double t = kDarkest + (1 - kDarkest) * share;
	const int stop = std::min(7, int(8 * t));
	const float f = float(8 * t - stop);
	const auto mix = [&](int k) { return VIRIDIS[stop][k] + f * (VIRIDIS[stop + 1][k] - VIRIDIS[stop][k]); };
	return {mix(0), mix(1), mix(2), 1};
}

Color variedByIndex(const Color& color, size_t index)
{
	// Golden-ratio steps: near indices get different shades.
	const double step = double(index % 1024) * 0.6180339887498949;
	const float shade = float(0.24 * (step - std::floor(step)) - 0.12);
	const auto moved = [&](float v) { return shade > 0 ? v + shade * (1 - v) : v + shade * v; };
	return {moved(color.r), moved(color.g), moved(color.b), color.a};
}

double Camera::pixelsPerMetre(int height) const
{
	return height / (2 * std::tan(fovy * PI / 360) * length(target - eye));
}

Camera orbitCamera(const Vec3& target, double radius, double azimuth, double elevation, double fovy)
{
	const double distance = radius / std::sin(fovy * PI / 360), a = azimuth * PI / 180, e = elevation * PI / 180;
	return {target + distance * Vec3{std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)}, target, fovy};
}
}  // namespace clod::demo
