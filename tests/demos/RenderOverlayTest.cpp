// SPDX-License-Identifier: GPL-3.0-or-later
// Words, legends and scale bars over pictures, and pictures side by side.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "demos/render/MetricLength.h"
#include "demos/render/Overlay.h"
#include "tests/demos/Pixels.h"

namespace clod::demo::test
{
TEST(RenderOverlay, LengthsAreInMillimetresWithoutExponents)
{
	for (const auto& [metres, words] :
		 {std::pair(0.0, "0 mm"), std::pair(1e-12, "0 mm"), std::pair(3e-7, "0.0003 mm"), std::pair(1e-9, "0.000001 mm"),
		  std::pair(3e-4, "0.3 mm"), std::pair(-2.5e-3, "-2.5 mm"), std::pair(0.03, "30 mm"), std::pair(-0.5, "-500 mm"),
		  std::pair(20.0, "20000 mm"), std::pair(0.0123456, "12.35 mm"), std::pair(0.00099999, "1 mm")})
		EXPECT_EQ(metricLength(metres), words);
	EXPECT_EQ(metricLength(1.2345e-3, 2), "1.2 mm");
	EXPECT_EQ(metricLength(123.45, 2), "120000 mm");
}

TEST(RenderOverlay, ALongTitleKeepsClearOfTheLegend)
{
	OverlayText text;
	text.legendTitle = "Certified error of the patches";
	text.legend = {{RED, "exact"}, {GREEN, "up to 1 mm"}};
	const Image plain(720, 720, {0.5f, 0.5f, 0.5f, 1});
	Image without = plain, with = plain;
	drawOverlay(without, text);
	text.title = "close-up of the near spoon from below, through the wall of its cup";
	drawOverlay(with, text);
	std::size_t ofLegend = 0, changed = 0;
	for (std::size_t i = 0; i < plain.rgba.size(); ++i)
		if (without.rgba[i] != plain.rgba[i])
		{
			++ofLegend;
			changed += with.rgba[i] != without.rgba[i] ? 1 : 0;
		}
	EXPECT_GT(ofLegend, 10000u);
	EXPECT_EQ(changed, 0u);
}

TEST(RenderOverlay, LegendScaleBarAndTextStandInTheirCorners)
{
	const Image plain(960, 720, {0.5f, 0.5f, 0.5f, 1});
	Image image = plain;
	OverlayText text;
	text.title = "A spoon slides in a cup";
	text.legendTitle = "Level";
	text.legend = {{RED, "exact"}, {GREEN, "up to 1 mm"}};
	text.footer = "step 480 of 1200";
	text.pixelsPerMetre = 3000;
	drawOverlay(image, text);
	size_t touched[2][2] = {{0, 0}, {0, 0}};
	size_t middleTouched = 0;
	for (int y = 0; y < image.height; ++y)
		for (int x = 0; x < image.width; ++x)
		{
			const size_t i = 4 * (size_t(y) * size_t(image.width) + size_t(x));
			if (std::memcmp(&image.rgba[i], &plain.rgba[i], 3) == 0) continue;
			++touched[y > 360][x > 480];
			middleTouched += y > 200 && y < 600;
		}
	for (const auto& row : touched)
		for (const size_t corner : row) EXPECT_GT(corner, 500u);
	EXPECT_EQ(middleTouched, 0u);
	// Words can be read on any picture: they stand on light panels.
	std::size_t light = 0;
	for (int y = 0; y < 100; ++y)
		for (int x = 0; x < 480; ++x) light += image.at(x, y).r > 0.75f;
	EXPECT_GT(light, 5000u);
	EXPECT_GT(countHue(image, Hue::Red), 100u);
	EXPECT_GT(countHue(image, Hue::Green), 100u);
	// The scale bar: the longest dark run of a row. 5 cm would be 150 pixels at this scale; a fifth of the width is
	// 192.
	int longest = 0;
	for (int y = 600; y < 720; ++y)
		for (int x = 480, run = 0; x < 960; ++x)
		{
			run = image.at(x, y).r < 0.25f ? run + 1 : 0;
			longest = std::max(longest, run);
		}
	EXPECT_NEAR(longest, 150, 3);
	Image again = plain;
	drawOverlay(again, text);
	EXPECT_EQ(again.rgba, image.rgba);
	Image untouched = plain;
	drawOverlay(untouched, {});
	EXPECT_EQ(differingPixels(untouched, plain), 0u);
}

TEST(RenderOverlay, SheetsHoldEveryPicture)
{
	std::vector<CaptionedImage> cells;
	for (const Color& color : {RED, GREEN, BLUE}) cells.push_back({Image(80, 60, color), "caption"});
	const Image sheet = contactSheet(cells, 2, 40, "Title");
	for (const Hue wanted : {Hue::Red, Hue::Green, Hue::Blue}) EXPECT_EQ(countHue(sheet, wanted), 40u * 30u);
	EXPECT_LT(sheet.width, 130);
	EXPECT_GT(sheet.height, 2 * 30);
	const Image pair = sideBySide({cells[0], cells[2]}, "Title");
	EXPECT_EQ(countHue(pair, Hue::Red), 80u * 60u);
	EXPECT_EQ(countHue(pair, Hue::Blue), 80u * 60u);
	EXPECT_GT(pair.width, 160);
	EXPECT_GT(contactSheet({}, 3, 40, "Nothing").height, 0);
}
}  // namespace clod::demo::test
