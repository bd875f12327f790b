// SPDX-License-Identifier: GPL-3.0-or-later
// What pixels of a picture show: plain colours, and which of them there are.
#pragma once
#include <cstddef>
#include <cstring>

#include "demos/render/Image.h"

namespace clod::demo::test
{
inline const Color RED = {1, 0, 0, 1}, GREEN = {0, 1, 0, 1}, BLUE = {0, 0, 1, 1};

enum class Hue
{
	Red,
	Green,
	Blue,
	Other,
};

// The channel that stands out clearly.
inline Hue hue(const Color& c)
{
	if (c.r > 2 * c.g + 0.1 && c.r > 2 * c.b + 0.1) return Hue::Red;
	if (c.g > 2 * c.r + 0.1 && c.g > 2 * c.b + 0.1) return Hue::Green;
	if (c.b > 2 * c.r + 0.1 && c.b > 2 * c.g + 0.1) return Hue::Blue;
	return Hue::Other;
}

inline std::size_t countHue(const Image& image, Hue wanted)
{
	std::size_t count = 0;
	for (int y = 0; y < image.height; ++y)
		for (int x = 0; x < image.width; ++x) count += hue(image.at(x, y)) == wanted;
	return count;
}

inline std::size_t differingPixels(const Image& a, const Image& b)
{
	std::size_t count = 0;
	for (std::size_t i = 0; i < a.rgba.size(); i += 4) count += std::memcmp(&a.rgba[i], &b.rgba[i], 3) != 0;
	return count;
}
}  // namespace clod::demo::test
