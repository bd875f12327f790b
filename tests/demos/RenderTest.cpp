// SPDX-License-Identifier: GPL-3.0-or-later
// The renderer: places and colours that can be computed by hand, order of layers, same bytes, files.
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "demos/render/GlProgram.h"
#include "tests/demos/Pixels.h"
#include "tests/support/Files.h"

namespace clod::demo::test
{
using clod::test::readText;
using clod::test::TemporaryFolder;

namespace
{
constexpr int WIDTH = 320, HEIGHT = 240;

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

// A coarse patch dipped beneath its body's surface and came out again, and looked mottled; where a body answered one
// neighbour coarsely and another finely, both flickered.
TEST_F(RenderTest, PatchesWithinTheirDeviationAreSeenWholeTheCoarserOverTheFiner)
{
	add(square(0.1, 0), RED);
	frame.patches.push_back({{}, squarePatch(0.05, -0.009, BLUE), true});
	frame.patches.push_back({{}, squarePatch(0.05, -0.009, GREEN), true});
	for (const double x : {0.0, 0.5, 0.9})
		for (const bool isCoarserFirst : {false, true})
		{
			frame.camera.eye = normalized(Vec3{x, 0.2, 1});
			for (std::size_t i : {0, 1}) frame.patches[i].deviation = (i == 0) == isCoarserFirst ? 0.01 : 0;
			const Image image = renderer->render(frame);
			const size_t coarser = countHue(image, isCoarserFirst ? Hue::Blue : Hue::Green);
			EXPECT_NEAR(double(coarser) / double(coarser + countHue(image, Hue::Red)), 0.25, 0.04) << x;
			EXPECT_EQ(countHue(image, isCoarserFirst ? Hue::Green : Hue::Blue), 0u) << x;
		}
}

// Tinted all over, what was behind a peg's end seemed to come through it.
TEST_F(RenderTest, HiddenPatchesAreHatchedUnlessToldNotTo)
{
	add(square(0.1, 0.1), {1, 1, 1, 1});
	const Image without = renderer->render(frame);
	frame.patches.push_back({{}, squarePatch(0.03, 0, BLUE), true});
	const Image hatched = renderer->render(frame);
	int strong = 0, pale = 0, changes = 0;
	bool wasStrong = false;
	constexpr int kAround = 12;  // pixels, of a patch of 13
	for (int x = WIDTH / 2 - kAround; x < WIDTH / 2 + kAround; ++x)
	{
		const Color color = hatched.at(x, HEIGHT / 2);
		EXPECT_GT(color.b, color.r + 0.06f) << "all of it is tinted";
		const bool isStrong = color.b > color.r + 0.35f;
		(isStrong ? strong : pale) += 1;
		changes += isStrong != wasStrong ? 1 : 0;
		wasStrong = isStrong;
	}
	EXPECT_GT(strong, kAround / 2);
	EXPECT_GT(pale, kAround / 2);
	EXPECT_GE(changes, 4);
	frame.patches[0].isSeenThrough = false;
	EXPECT_EQ(differingPixels(renderer->render(frame), without), 0u);
}

// A torus in contact all over was coloured all over, and the points under it were nowhere to be seen.
TEST_F(RenderTest, MarkersShowFaintlyThroughPatchesAndGlass)
{
	add(square(0.1, 0.1), {1, 1, 1, 1});
	frame.patches.push_back({{}, squarePatch(0.1, 0.1, BLUE), true});
	for (const bool isBehindGlass : {false, true})
	{
		if (isBehindGlass) add(square(0.15, 0.2), {0.5f, 0.5f, 0.6f, 0.2f}).isTransparent = true;
		const Color without = middle(renderer->render(frame));
		frame.markers = {{{0, 0, 0}, 0.02, RED}};
		const Color faint = middle(renderer->render(frame));
		EXPECT_GT(faint.r, without.r + 0.15f) << isBehindGlass;
		EXPECT_NE(hue(faint), Hue::Red) << isBehindGlass;
		frame.markers[0].centre.z = 0.13;
		const Color plain = middle(renderer->render(frame));
		EXPECT_GT(plain.r, faint.r + 0.1f) << isBehindGlass;
		EXPECT_EQ(hue(plain), Hue::Red) << isBehindGlass;
		frame.markers.clear();
	}
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
}  // namespace clod::demo::test
