// SPDX-License-Identifier: Zlib
// Pictures in memory and as PNG files (libpng).
#pragma once
#include <clod/hierarchy/Result.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace clod::demo
{
struct Color
{
	float r = 0, g = 0, b = 0, a = 1;  // 0 .. 1, sRGB as a screen shows it, alpha not multiplied in
};

struct Image
{
	int width = 0, height = 0;
	std::vector<uint8_t> rgba;  // rows from the top

	Image() = default;
	Image(int imageWidth, int imageHeight, Color fill = {1, 1, 1, 1});
	Color at(int x, int y) const;
};

// Every `factor` x `factor` pixels become their mean.
Image reduced(const Image& image, int factor);
Image resized(const Image& image, int width, int height);  // area-weighted

// Key and value stored in the file, e.g. {"Title", "spoon-cup, step 480"}.
using PngText = std::vector<std::pair<std::string, std::string>>;
// Written beside `path`, then renamed over it; no time stamp inside: the same picture is the same bytes.
Result<size_t> writePng(const std::string& path, const Image& image, const PngText& text = {});
}  // namespace clod::demo
