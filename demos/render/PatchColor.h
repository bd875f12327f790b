// SPDX-License-Identifier: Zlib
// One colour for each patch of a level: in pictures and in exported meshes the same.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace clod::demo
{
// Hues a golden angle apart, so that patches with neighbouring numbers differ most; lightness in three steps. sRGB.
inline std::array<std::uint8_t, 3> patchColor(std::size_t patch)
{
	const double hue = std::fmod(double(patch) * 0.6180339887498949, 1.0);
	const double light = 0.45 + 0.15 * double(patch % 3), saturation = 0.65;
	std::array<std::uint8_t, 3> color = {};
	for (int i = 0; i < 3; ++i)
	{
		const double k = std::fmod(12 * hue + 4.0 * (3 - i), 12.0);
		const double amplitude = saturation * std::min(light, 1 - light);
		const double value = light - amplitude * std::max(-1.0, std::min({k - 3, 9 - k, 1.0}));
		color[std::size_t(i)] = std::uint8_t(std::lround(255 * value));
	}
	return color;
}
}  // namespace clod::demo
