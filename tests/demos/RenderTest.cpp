// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer: places and colours that can be computed by hand, order of layers, same bytes, overlays, files.
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "demos/render/GlProgram.h"
#include "demos/render/MetricLength.h"
#include "demos/render/Overlay.h"
#include "tests/support/Files.h"

namespace clod::demo::test
{
using clod::test::readText;
using clod::test::TemporaryFolder;

namespace
{
constexpr int WIDTH = 320, HEIGHT = 240;
const Color RED = {1, 0, 0, 1}, GREEN = {0, 1, 0, 1}, BLUE = {0, 0, 1, 1};

// A square of side 2 h in the plane z = `z`, facing +z.
RenderMesh square(double h, double z)
{
	return {{{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}}, {{0, 1, 2}, {0, 2, 3}}, {}};
}

std::vector<ColoredTriangle> squarePatch(double h, double z, const Color& color)
{
	const RenderMesh mesh = square(h, z);
	std::vector<ColoredTriangle> triangles;
	for (const auto& t : mesh.triangles)
		triangles.push_back({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, color});
	return triangles;
}

class RenderTest : public ::testing::Test
{
protected:
	void SetUp() override
	{
		auto created = Renderer::create(WIDTH, HEIGHT);
		ASSERT_TRUE(created) << created.error();
		renderer = std::move(created.value());
		frame.camera = {{0, 0, 1}, {0, 0, 0}, 30};
		frame.ground.isDrawn = false;
	}

	Instance& add(const RenderMesh& mesh, const Color& color)
	{
		auto id = renderer->addMesh(mesh);
		EXPECT_TRUE(id) << id.error();
		frame.instances.push_back({id.value(), {}, color, false});
		return frame.instances.back();
	}

	std::unique_ptr<Renderer> renderer;
	Frame frame;
};

enum class Hue
{
	Red,
	Green,
	Blue,
	Other,
};

// The channel that stands out clearly.
Hue hue(const Color& c)
{
	if (c.r > 2 * c.g + 0.1 && c.r > 2 * c.b + 0.1) return Hue::Red;
	if (c.g > 2 * c.r + 0.1 && c.g > 2 * c.b + 0.1) return Hue::Green;
	if (c.b > 2 * c.r + 0.1 && c.b > 2 * c.g + 0.1) return Hue::Blue;
	return Hue::Other;
}

size_t countHue(const Image& image, Hue wanted)
{
	size_t count = 0;
	for (int y = 0; y < image.height; ++y)
		for (int x = 0; x < image.width; ++x) count += hue(image.at(x, y)) == wanted;
	return count;
}

size_t differingPixels(const Image& a, const Image& b)
{
	size_t count = 0;
	for (size_t i = 0; i < a.rgba.size(); i += 4) count += std::memcmp(&a.rgba[i], &b.rgba[i], 3) != 0;
	return count;
}

Color middle(const Image& image)
{
	return image.at(image.width / 2, image.height / 2);
}
}  // namespace

TEST_F(RenderTest, SquareCoversThePixelsThatTheCameraSays)
{
	add(square(0.05, 0), RED);
	const Image image = renderer->render(frame);
	const double side = 0.1 * frame.camera.pixelsPerMetre(HEIGHT);
	EXPECT_NEAR(frame.camera.pixelsPerMetre(HEIGHT), HEIGHT / (2 * std::tan(15 * std::acos(-1.0) / 180)), 1e-9);
	EXPECT_NEAR(double(countHue(image, Hue::Red)), side * side, 2.5 * side);
	const int half = int(side / 2);
	EXPECT_EQ(hue(image.at(WIDTH / 2 - half + 1, HEIGHT / 2 - half + 1)), Hue::Red);
	EXPECT_EQ(hue(image.at(WIDTH / 2 - half - 2, HEIGHT / 2)), Hue::Other);
	EXPECT_EQ(hue(image.at(WIDTH / 2, HEIGHT / 2 + half + 2)), Hue::Other);
}

TEST_F(RenderTest, UpIsUpAndRightIsRight)
{
	Instance& instance = add(square(0.02, 0), RED);
	instance.worldFromMesh.translation = {0.1, 0.08, 0};
	const Image image = renderer->render(frame);
	const double scale = frame.camera.pixelsPerMetre(HEIGHT);
	EXPECT_EQ(hue(image.at(int(WIDTH / 2 + 0.1 * scale), int(HEIGHT / 2 - 0.08 * scale))), Hue::Red);
	EXPECT_EQ(hue(middle(image)), Hue::Other);
}

TEST_F(RenderTest, NearHidesFar)
{
	add(square(0.05, 0.1), RED);
	add(square(0.05, 0.0), GREEN);
	EXPECT_EQ(hue(middle(renderer->render(frame))), Hue::Red);
	std::swap(frame.instances[0].color, frame.instances[1].color);
	EXPECT_EQ(hue(middle(renderer->render(frame))), Hue::Green);
}

TEST_F(RenderTest, TriangleColorsReplaceTheBodys)
{
	RenderMesh mesh = square(0.05, 0);
	mesh.triangleColors = {GREEN, BLUE};
	add(mesh, RED);
	const Image image = renderer->render(frame);
	EXPECT_EQ(countHue(image, Hue::Red), 0u);
	EXPECT_NEAR(double(countHue(image, Hue::Green)), double(countHue(image, Hue::Blue)), 60);
	EXPECT_GT(countHue(image, Hue::Green), 800u);
}

TEST_F(RenderTest, PatchesLieOverTheirSurfaceWithoutFlicker)
{
	add(square(0.1, 0), RED);
	frame.patches.push_back({{}, squarePatch(0.05, 0, BLUE), true});
	for (const double x : {0.0, 0.9, 2.2, 5.0})  // flatter and flatter views
	{
		frame.camera.eye = normalized(Vec3{x, 0.2, 1});
		const Image image = renderer->render(frame);
		const size_t blue = countHue(image, Hue::Blue), red = countHue(image, Hue::Red);
		EXPECT_NEAR(double(blue) / double(blue + red), 0.25, 0.04) << x;
		EXPECT_EQ(hue(middle(image)), Hue::Blue) << x;
	}
}

TEST_F(RenderTest, HiddenPatchesShowFaintlyUnlessToldNotTo)
{
	add(square(0.1, 0.1), {1, 1, 1, 1});
	const Image without = renderer->render(frame);
	frame.patches.push_back({{}, squarePatch(0.03, 0, BLUE), true});
	const Image faint = renderer->render(frame);
	EXPECT_GT(middle(faint).b, middle(faint).r + 0.15f);
	EXPECT_NE(hue(middle(faint)), Hue::Blue);
	frame.patches[0].isSeenThrough = false;
	EXPECT_EQ(differingPixels(renderer->render(frame), without), 0u);
}

TEST_F(RenderTest, TransparentBodiesShowWhatIsBehind)
{
	add(square(0.05, 0), RED);
	add(square(0.1, 0.1), {0.5f, 0.5f, 0.6f, 0.2f}).isTransparent = true;
	const Color seen = middle(renderer->render(frame));
	EXPECT_GT(seen.r, 1.5f * seen.b);
	frame.instances[1].isTransparent = false;
	const Color hidden = middle(renderer->render(frame));
	EXPECT_LE(hidden.r, hidden.b);
}

TEST_F(RenderTest, PatchesOfGlassShowWhatIsBehind)
{
	add(square(0.05, 0), RED);
	frame.patches.push_back({{}, squarePatch(0.05, 0.1, BLUE), true});
	const Color opaque = middle(renderer->render(frame));
	EXPECT_LT(opaque.r, 0.5f * opaque.b);
	frame.patches[0].isGlass = true;
	const Color glass = middle(renderer->render(frame));
	EXPECT_GT(glass.r, opaque.r + 0.2f);
	EXPECT_GT(glass.b, glass.r);
}

TEST_F(RenderTest, NearGlassLiesOverFarGlassInAnyOrder)
{
	for (const bool isNearFirst : {true, false})
	{
		frame.instances.clear();
		for (const bool isNear : {isNearFirst, !isNearFirst})
		{
			Instance& glass = add(square(0.1, 0), isNear ? Color{1, 0, 0, 0.6f} : Color{0, 0, 1, 0.6f});
			glass.isTransparent = true;
			glass.worldFromMesh.translation = {0, 0, isNear ? 0.1 : 0};
		}
		const Color seen = middle(renderer->render(frame));
		EXPECT_GT(seen.r, 1.3f * seen.b) << isNearFirst;
	}
}

TEST_F(RenderTest, MarkersAndArrowsStandWhereTheyAreAskedFor)
{
	const double scale = frame.camera.pixelsPerMetre(HEIGHT);
	frame.markers.push_back({{0, 0, 0}, 0.02, GREEN});
	frame.arrows.push_back({{0.05, 0, 0}, {0.05, 0.1, 0}, 0.005, BLUE});
	const Image image = renderer->render(frame);
	EXPECT_NEAR(double(countHue(image, Hue::Green)), std::acos(-1.0) * std::pow(0.02 * scale, 2), 60);
	EXPECT_EQ(hue(image.at(int(WIDTH / 2 + 0.05 * scale), int(HEIGHT / 2 - 0.05 * scale))), Hue::Blue);
	EXPECT_EQ(hue(image.at(int(WIDTH / 2 + 0.05 * scale), int(HEIGHT / 2 - 0.13 * scale))), Hue::Other);
	EXPECT_EQ(hue(image.at(int(WIDTH / 2 + 0.09 * scale), int(HEIGHT / 2 - 0.05 * scale))), Hue::Other);
	// An arrow without length is nothing.
	frame.arrows[0].to = frame.arrows[0].from;
	EXPECT_EQ(countHue(renderer->render(frame), Hue::Blue), 0u);
}

TEST_F(RenderTest, GroundHasLinesAndShadows)
{
	frame.camera = orbitCamera({0, 0, 0}, 0.1, 30, 40);
	const Image bare = renderer->render(frame);
	frame.ground.isDrawn = true;
	const Image grid = renderer->render(frame);
	EXPECT_GT(differingPixels(bare, grid), size_t(WIDTH * HEIGHT / 4));
	RenderMesh lid = {{{-0.02, 0.02, -0.02}, {0.02, 0.02, -0.02}, {0, 0.02, 0.02}}, {{0, 2, 1}}, {}};
	add(lid, RED);
	frame.ground.hasShadows = false;
	const Image unshadowed = renderer->render(frame);
	frame.ground.hasShadows = true;
	const Image shadowed = renderer->render(frame);
	size_t darker = 0;
	for (int y = 0; y < HEIGHT; ++y)
		for (int x = 0; x < WIDTH; ++x) darker += shadowed.at(x, y).g < unshadowed.at(x, y).g - 0.05f;
	EXPECT_GT(darker, 200u);
	// The body itself is not darkened; only its outline's pixels mix with the ground.
	EXPECT_NEAR(double(countHue(shadowed, Hue::Red)), double(countHue(unshadowed, Hue::Red)), 15);
}

// Lines fade with the distance from what is looked at, wherever that is.
TEST_F(RenderTest, GroundIsAlikeRoundAnyPlaceOfItsGrid)
{
	frame.ground.isDrawn = true;
	frame.camera = orbitCamera({0, 0, 0}, 0.1, 30, 40);
	const Image here = renderer->render(frame);
	const double far = 40 * frame.ground.spacing;
	frame.camera = orbitCamera({far, 0, -far}, 0.1, 30, 40);
	EXPECT_LT(differingPixels(renderer->render(frame), here), size_t(WIDTH * HEIGHT / 100));
}

// So that patches can be found in the legend, whatever the light.
TEST_F(RenderTest, APatchIsNearerToItsColourThanABody)
{
	const Color color{0.3f, 0.6f, 0.5f, 1};
	const auto difference = [&]
	{
		const Color seen = renderer->render(frame).at(WIDTH / 2, HEIGHT / 2);
		return std::fabs(seen.r - color.r) + std::fabs(seen.g - color.g) + std::fabs(seen.b - color.b);
	};
	add(square(0.1, 0), color);
	const float ofBody = difference();
	EXPECT_GT(ofBody, 0.05f);
	frame.patches.push_back({{}, squarePatch(0.1, 0, color), true});
	EXPECT_LT(difference(), 0.6f * ofBody);
}

// A ridge of 20 degrees along x: smooth shading goes on over it, flat shading does not; a crease stays one.
TEST_F(RenderTest, SmoothShadingGoesOnOverAShallowRidge)
{
	const auto changeOverAFace = [&](double fall, Shading shading)
	{
		const RenderMesh ridge = {{{-0.2, 0, 0}, {0.2, 0, 0}, {0.2, 0.2, -fall}, {-0.2, 0.2, -fall}, {-0.2, -0.2, -fall}, {0.2, -0.2, -fall}},
								  {{0, 1, 2}, {0, 2, 3}, {4, 5, 1}, {4, 1, 0}},
								  {}};
		const auto id = renderer->addMesh(ridge, shading);
		EXPECT_TRUE(id) << id.error();
		frame.instances = {{id.value(), {}, {0.5f, 0.5f, 0.5f, 1}, false}};
		const Image image = renderer->render(frame);
		return std::fabs(image.at(WIDTH / 2, HEIGHT / 2 + 4).g - image.at(WIDTH / 2, HEIGHT / 2 + 60).g);
	};
	EXPECT_LT(changeOverAFace(0.035, Shading::Flat), 0.008f);
	EXPECT_GT(changeOverAFace(0.035, Shading::Smooth), 0.02f);
	EXPECT_LT(changeOverAFace(0.2, Shading::Smooth), 0.02f);
}

TEST_F(RenderTest, SameFrameSameBytes)
{
	frame.camera = orbitCamera({0, 0.02, 0}, 0.12, 30, 25);
	frame.ground.isDrawn = true;
	add(square(0.05, 0), {0.6f, 0.6f, 0.7f, 1});
	add(square(0.06, 0.02), {0.4f, 0.5f, 0.7f, 0.2f}).isTransparent = true;
	frame.patches.push_back({{}, squarePatch(0.03, 0, levelColor(2, 6)), true});
	frame.markers.push_back({{0, 0, 0.03}, 0.004});
	const Image first = renderer->render(frame);
	EXPECT_EQ(first.rgba, renderer->render(frame).rgba);
	auto other = Renderer::create(WIDTH, HEIGHT);  // another renderer in the same process
	ASSERT_TRUE(other);
	for (const RenderMesh& mesh : {square(0.05, 0), square(0.06, 0.02)}) ASSERT_TRUE(other.value()->addMesh(mesh));
	EXPECT_EQ(first.rgba, other.value()->render(frame).rgba);
	EXPECT_EQ(first.rgba, renderer->render(frame).rgba);  // and the first one again
	frame.markers[0].centre.x = 0.005;
	EXPECT_NE(first.rgba, renderer->render(frame).rgba);
}

TEST_F(RenderTest, BadInputIsRefused)
{
	RenderMesh mesh = square(1, 0);
	mesh.triangles[1][2] = 9;
	EXPECT_NE(renderer->addMesh(mesh).error().find("Triangle 1 names vertex 9 of 4"), std::string::npos);
	mesh = square(1, 0);
	mesh.triangleColors = {RED};
	EXPECT_NE(renderer->addMesh(mesh).error().find("1 triangle colours for 2"), std::string::npos);
	EXPECT_FALSE(Renderer::create(0, 100));
	EXPECT_FALSE(Renderer::create(100, 100000));
	EXPECT_FALSE(Renderer::create(100, 100, 9));
	const auto shader = GlProgram::create("#version 120\nvoid main() { gl_Position = nobody; }", "void main() {}");
	EXPECT_NE(shader.error().find("nobody"), std::string::npos) << shader.error();
}

TEST(RenderColors, LevelsGrowBrighterAndDiffer)
{
	for (const int count : {2, 7, 14})
	{
		double last = -1;
		for (int level = 0; level < count; ++level)
		{
			const Color c = levelColor(level, count);
			const double brightness = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
			EXPECT_GT(brightness, last + 0.02) << level << " of " << count;
			last = brightness;
		}
	}
	const Color only = levelColor(0, 1);
	EXPECT_FLOAT_EQ(only.r, levelColor(0, 5).r);
	EXPECT_NE(variedByIndex(only, 1).r, variedByIndex(only, 2).r);
	// Shades of a colour: neither black nor white, and never far from it.
	for (const float channel : {0.0f, 0.5f, 1.0f})
		for (std::size_t index = 0; index < 200; ++index)
		{
			const float shade = variedByIndex({channel, channel, channel, 1}, index).r;
			EXPECT_NEAR(shade, channel, 0.1201f) << index;
			EXPECT_TRUE(shade >= 0 && shade <= 1) << index << " of " << channel << ": " << shade;
		}
}

TEST(RenderImages, ReducedAndResizedKeepTheMean)
{
	Image image(4, 2, {0, 0, 0, 1});
	for (size_t i = 0; i < 4; ++i) image.rgba[i * 4] = 200;  // the upper row's red
	const Image half = reduced(image, 2);
	ASSERT_EQ(half.width, 2);
	EXPECT_EQ(half.rgba[0], 100);
	EXPECT_EQ(half.rgba[1], 0);
	const Image stretched = resized(image, 2, 1);
	EXPECT_EQ(stretched.rgba[0], 100);
	EXPECT_EQ(resized(image, 8, 4).rgba[0], 200);
	EXPECT_EQ(resized(image, 4, 2).rgba, image.rgba);
}

namespace
{
// The picture back from a file, by libpng's simplified reader.
Image readPng(const std::string& path)
{
	png_image png = {};
	png.version = PNG_IMAGE_VERSION;
	Image image;
	if (!png_image_begin_read_from_file(&png, path.c_str())) return image;
	png.format = PNG_FORMAT_RGBA;
	image = Image(int(png.width), int(png.height));
	png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr);
	return image;
}
}  // namespace

TEST(RenderImages, PngFilesHoldThePictureAndItsText)
{
	Image image(7, 5, {0.2f, 0.4f, 0.6f, 1});
	image.rgba[8] = 17;
	const TemporaryFolder folder;
	const std::string path = folder.file("render-test.png");
	const PngText text = {{"Title", "spoon-cup, step 480"}};
	const auto bytes = writePng(path, image, text);
	ASSERT_TRUE(bytes) << bytes.error();
	EXPECT_EQ(bytes.value(), std::filesystem::file_size(path));
	EXPECT_EQ(readPng(path).rgba, image.rgba);
	const std::string first = readText(path);
	EXPECT_NE(first.find("spoon-cup, step 480"), std::string::npos);
	ASSERT_TRUE(writePng(path, image, text));
	EXPECT_EQ(readText(path), first);
	EXPECT_FALSE(std::filesystem::exists(path + ".part"));
	std::filesystem::remove(path);
	EXPECT_NE(writePng("/nonexistent-folder/a.png", image).error().find("/nonexistent-folder/a.png"),
			  std::string::npos);
	image.rgba.pop_back();
	EXPECT_FALSE(writePng(path, image));
	EXPECT_FALSE(writePng(path, Image()));
	EXPECT_FALSE(std::filesystem::exists(path));
}

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
