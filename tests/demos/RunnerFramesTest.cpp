// SPDX-License-Identifier: GPL-3.0-or-later
// Frames and legend of bodies that answer at known levels: one picture a level, its pixels looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "demos/runner/Film.h"
#include "demos/runner/Frames.h"
#include "demos/runner/InputSurface.h"
#include "demos/runner/LevelPictures.h"
#include "demos/scenes/SceneDefinition.h"
#include "tests/demos/BuiltBody.h"

namespace
{
using namespace clod;
using namespace clod::demo;

constexpr double kAside = 0.026;  // A is left of the middle, B right

FrameSubject subjectOf(const HierarchyPointer& a, const HierarchyPointer& b)
{
	FrameSubject subject;
	subject.meshes = {inputSurface(*a), inputSurface(*b)};
	subject.bodies = {{0, a, false}, {1, b, false}};
	subject.overview = subject.overviewAtEnd = orbitCamera({}, 0.055, 0, 60);
	subject.closeUp.center = {9, 9, 9};  // of nothing: its legend is looked at
	subject.closeUp.radius = 0.01;
	subject.hasGround = false;
	return subject;
}

FrameMoment moment()
{
	FrameMoment moment;
	moment.poses.resize(2);
	moment.poses[0].position = {-kAside, 0, 0};
	moment.poses[1].position = {kAside, 0, 0};
	return moment;
}

std::uint32_t coarsestLevel(const Hierarchy& h)
{
	return h.coarsestClodLevel();
}

// Every node of a level of A and every node of a level of B.
FrameAnswer answerAt(const Hierarchy& a, std::uint32_t levelA, const Hierarchy& b, std::uint32_t levelB)
{
	const Level &ofA = a.levels()[levelA], &ofB = b.levels()[levelB];
	GapResult result;
	for (std::uint32_t i = 0; i < std::max(ofA.nodeCount, ofB.nodeCount); ++i)
		result.contacts.push_back(
			{ofA.firstNode + i % ofA.nodeCount, ofB.firstNode + i % ofB.nodeCount, 0, 0, {}, {}, {}});
	FrameAnswer answer;
	answer.pairs.push_back({{0, 1}, std::move(result)});
	return answer;
}

double unlikeness(const Color& l, const Color& r)
{
	// Shading darkens and brightens: only the ratios of channels tell a level.
	const auto chroma = [](const Color& c) { return normalized(Vec3{double(c.r), double(c.g), double(c.b)}); };
	return length(chroma(l) - chroma(r));
}

// Of the pixels that differ between two pictures in columns [from, to), the level whose colour most are nearest to, and
// what share of them.
struct Vote
{
	int level = -1;
	double share = 0;
	int pixels = 0;
};
Vote vote(const Image& image, const Image& bare, int from, int to, int levels)
{
	std::map<int, int> votes;
	Vote vote;
	for (int y = 0; y < image.height * 7 / 8; ++y)  // the text below tells what is coloured
		for (int x = from; x < to; ++x)
		{
			const Color color = image.at(x, y);
			if (unlikeness(color, bare.at(x, y)) < 0.05) continue;
			int nearest = 0;
			for (int level = 1; level < levels; ++level)
				if (unlikeness(color, levelColor(level, levels)) < unlikeness(color, levelColor(nearest, levels)))
					nearest = level;
			++votes[nearest];
			++vote.pixels;
		}
	for (const auto& [level, count] : votes)
		if (count > vote.share * vote.pixels) vote = {level, double(count) / vote.pixels, vote.pixels};
	return vote;
}

// Pixels of a legend's swatch: the colour itself, at the top right.
int swatchPixels(const Image& image, const Color& color)
{
	int count = 0;
	for (int y = 0; y < image.height / 3; ++y)
		for (int x = 3 * image.width / 4; x < image.width; ++x)
		{
			const Color c = image.at(x, y);
			count += std::max({std::fabs(c.r - color.r), std::fabs(c.g - color.g), std::fabs(c.b - color.b)}) < 0.008f;
		}
	return count;
}

// Steps of the scale that a level's patches have.
std::set<int> stepsOf(const ErrorScale& scale, const Hierarchy& h, std::uint32_t level)
{
	std::set<int> steps;
	for (std::uint32_t i = 0; i < h.levels()[level].nodeCount; ++i)
		steps.insert(scale.stepOf(double(h.node(h.levels()[level].firstNode + i).deviation)));
	return steps;
}

TEST(RunnerFrames, EveryErrorHasItsColourOnEitherBodyAndInTheLegend)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	const int levels = int(coarsestLevel(*torus)) + 1;
	ASSERT_GE(levels, 3);
	const FrameSubject subject = subjectOf(torus, torus);
	const ErrorScale scale(subject);
	ASSERT_GE(scale.steps(), 3);
	// Viridis from blue on: blue is exact, yellow the largest error.
	EXPECT_LT(unlikeness(scale.color(0), {0.230f, 0.322f, 0.546f, 1}), 0.01);
	EXPECT_LT(unlikeness(scale.color(scale.steps() - 1), {0.993f, 0.906f, 0.144f, 1}), 0.01);
	FramePainter painter(subject);
	const Image bare = painter.paint(moment(), {}, {});
	for (int level = 0; level < levels; ++level)
	{
		const int other = levels - 1 - level;
		const FrameAnswer answer = answerAt(*torus, std::uint32_t(level), *torus, std::uint32_t(other));
		const Image image = painter.paint(moment(), answer, {});
		ASSERT_EQ(image.width, bare.width);
		const int middle = image.width / 4;  // of the overview, which is the left half
		const std::set<int> ofA = stepsOf(scale, *torus, std::uint32_t(level)),
							ofB = stepsOf(scale, *torus, std::uint32_t(other));
		// The figures at the top left differ, too.
		const Vote a = vote(image, bare, 0, middle, scale.steps()),
				   b = vote(image, bare, middle, 2 * middle, scale.steps());
		EXPECT_GT(a.pixels, 2000);
		EXPECT_EQ(ofA.count(a.level), 1u) << "level " << level << " in the colour of step " << a.level;
		EXPECT_GT(a.share, 0.3);
		EXPECT_GT(b.pixels, 2000);
		EXPECT_EQ(ofB.count(b.level), 1u) << "level " << other << " in the colour of step " << b.level;
		EXPECT_GT(b.share, 0.3);
		for (int k = 0; k < scale.steps(); ++k)
			EXPECT_EQ(swatchPixels(image, scale.color(k)) > 40, ofA.count(k) + ofB.count(k) > 0)
				<< k << " of " << level;
	}
}

TEST(RunnerFrames, TheLegendNamesTheErrorsInThePictureOfBothBodies)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy, cup = test::builtBody("cup", 1200).hierarchy;
	for (const auto& [a, b] : {std::pair(torus, cup), std::pair(cup, torus)})
	{
		const FrameSubject subject = subjectOf(a, b);
		const ErrorScale scale(subject);
		for (std::uint32_t levelA = 0; levelA <= coarsestLevel(*a); ++levelA)
			for (std::uint32_t levelB = 0; levelB <= coarsestLevel(*b); ++levelB)
			{
				const auto legend = legendOf(subject, answerAt(*a, levelA, *b, levelB));
				// Every error of the picture is within the entry of its colour, and no entry is without one.
				std::set<std::size_t> used;
				for (const auto& [h, level] : {std::pair(a, levelA), std::pair(b, levelB)})
					for (std::uint32_t i = 0; i < h->levels()[level].nodeCount; ++i)
					{
						const double error = double(h->node(h->levels()[level].firstNode + i).deviation);
						std::size_t entry = 0;
						const auto says = [&](std::size_t k)
						{
							const std::string length = legend[k].label.substr(std::string("up to ").size());
							EXPECT_EQ(length.substr(length.find(' ')), " mm");
							return std::atof(length.c_str()) * 1e-3 * (1 + 1e-9);
						};
						while (entry < legend.size() && says(entry) < error) ++entry;
						ASSERT_LT(entry, legend.size()) << error;
						EXPECT_TRUE(entry == 0 || says(entry) < 3.4 * error) << error << legend[entry].label;
						used.insert(entry);
					}
				EXPECT_EQ(used.size(), legend.size());
			}
		EXPECT_TRUE(legendOf(subject, {}).empty());
		EXPECT_EQ(scale.stepOf(0), 0);
		for (int step = 0; step < scale.steps(); ++step)
		{
			EXPECT_EQ(scale.stepOf(0.99 * scale.largestOf(step)), step);
			EXPECT_EQ(scale.stepOf(1.2 * scale.largestOf(step)), std::min(step + 1, scale.steps() - 1));
		}
	}
}

// Three errors under a limit were three greens hardly apart: the scale went on to what no picture shows.
TEST(RunnerFrames, ColoursEndWithTheLargestErrorThatIsShown)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	FrameSubject subject = subjectOf(torus, torus);
	const ErrorScale whole(subject);
	const FrameAnswer fine = answerAt(*torus, 1, *torus, 0);
	const std::set<int> used = stepsOf(whole, *torus, 1);
	ASSERT_LT(*used.rbegin(), whole.steps() - 1);
	subject.largestError = largestErrorShown(subject, fine);
	const ErrorScale scale(subject);
	EXPECT_EQ(scale.steps(), *used.rbegin() + 1);
	EXPECT_EQ(scale.stepOf(subject.largestError), scale.steps() - 1);
	EXPECT_EQ(legendOf(subject, fine).size(), legendOf(subjectOf(torus, torus), fine).size());
	subject.largestError = largestErrorShown(subject, answerAt(*torus, 0, *torus, coarsestLevel(*torus)));
	EXPECT_EQ(ErrorScale(subject).steps(), whole.steps()) << "of either body";
}

TEST(RunnerFrames, WordsUnderAPictureNameTheColoursThatAreInIt)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy, box = test::builtBody("box", 12).hierarchy;
	const FrameSubject subject = subjectOf(torus, box);
	const FrameAnswer coloured = answerAt(*torus, 0, *box, 0);
	const auto names = [&](const FrameAnswer& answer, std::size_t contacts, const char* what)
	{ return footnoteOf(subject, answer, contacts, "points").find(what) != std::string::npos; };
	EXPECT_EQ(footnoteOf(subject, {}, 0, "points"), "");
	for (const std::size_t contacts : {0, 1, 100, 101})
	{
		EXPECT_TRUE(names(coloured, contacts, "Coloured: "));
		EXPECT_FALSE(names({}, contacts, "Coloured: "));
		EXPECT_TRUE(names(coloured, contacts, "Hatched: "));
		EXPECT_FALSE(names({}, contacts, "Hatched: "));
		EXPECT_EQ(names(coloured, contacts, "Red: points"), contacts > 0) << contacts;
		EXPECT_EQ(names(coloured, contacts, "push of one body"), contacts > 0 && contacts <= 100) << contacts;  // arrows
	}
}

TEST(RunnerFrames, OfPatchesPulledApartBothSidesAreShownWhereAnyPairHasThem)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy, box = test::builtBody("box", 12).hierarchy;
	FrameSubject subject = subjectOf(torus, torus);
	subject.bodies.push_back({0, box, false});
	FrameAnswer answer = answerAt(*torus, 0, *box, 0);
	answer.pairs[0].bodies = {0, 2};
	answer.pairs.push_back(answerAt(*torus, coarsestLevel(*torus), *torus, coarsestLevel(*torus)).pairs[0]);
	ASSERT_GT(torus->levels()[0].nodeCount, 2 * torus->levels()[coarsestLevel(*torus)].nodeCount);
	EXPECT_EQ(pairThatShowsMost(subject, answer).bodies.b, 1u);
	answer.pairs.pop_back();
	EXPECT_EQ(pairThatShowsMost(subject, answer).bodies.b, 2u);
}

// A plate on a floor was blue on blue.
TEST(RunnerFrames, ABodyOfOneConvexPatchIsNotColoured)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy, box = test::builtBody("box", 12).hierarchy;
	ASSERT_EQ(box->levels()[0].nodeCount, 1u);
	const FrameSubject boxes = subjectOf(box, box), mixed = subjectOf(torus, box);
	EXPECT_TRUE(legendOf(boxes, answerAt(*box, 0, *box, 0)).empty());
	EXPECT_EQ(legendOf(mixed, answerAt(*torus, 0, *box, 0)).size(), 1u);
	// Nor is there a picture of patches pulled apart where none is coloured (SceneFrames.cpp).
	EXPECT_EQ(patchesShown(boxes, answerAt(*box, 0, *box, 0)), 0u);
	EXPECT_EQ(patchesShown(mixed, answerAt(*torus, 0, *box, 0)), torus->levels()[0].nodeCount);
	FramePainter painter(mixed);
	const Image bare = painter.paint(moment(), {}, {}), image = painter.paint(moment(), answerAt(*torus, 0, *box, 0), {});
	const int middle = image.width / 4;
	EXPECT_GT(vote(image, bare, 0, middle, 2).pixels, 2000) << "the torus is";
	EXPECT_EQ(vote(image, bare, middle + 20, 2 * middle, 2).pixels, 0);
}

TEST(RunnerFrames, FilmsHaveFramesEnough)
{
	EXPECT_EQ(frameEvery(1200, 1.0 / 240), 8);  // 30 a second
	EXPECT_EQ(frameEvery(1440, 1.0 / 960), 9);  // 1.5 s: 160 frames
	EXPECT_EQ(frameEvery(100, 1.0 / 240), 1);   // no more than there are
	EXPECT_EQ(frameEvery(9600, 1.0 / 1920), 64);
	for (const SceneDefinition& scene : sceneDefinitions())
		EXPECT_GE(scene.info.steps / frameEvery(scene.info.steps, scene.info.dt), 150) << scene.info.name;
}

// At the last step a camera that moves is where it ends, at the first where it begins, halfway at neither.
TEST(RunnerFrames, ACameraThatMovesEndsWithTheLensOfItsEnd)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	FrameSubject begin = subjectOf(torus, torus);
	begin.steps = 10;
	FrameSubject end = begin, moves = begin;
	end.overview = end.overviewAtEnd = moves.overviewAtEnd = orbitCamera({0, 0.01, 0}, 0.08, 20, 50, 20);
	const auto at = [](const FrameSubject& subject, std::int64_t step)
	{
		FrameMoment now = moment();
		now.step = step;
		return FramePainter(subject).paint(now, {}, {}).rgba;
	};
	EXPECT_EQ(at(moves, 0), at(begin, 0));
	EXPECT_EQ(at(moves, 10), at(end, 10));
	EXPECT_NE(at(moves, 5), at(begin, 5));
	EXPECT_NE(at(moves, 5), at(end, 5));
}

// Two arms on a pin were one blue thing: patches of the same error are of one hue and, body by body, of another lightness.
TEST(RunnerFrames, PatchesOfTwoBodiesCanBeToldApart)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	const FrameSubject subject = subjectOf(torus, torus);
	FramePainter painter(subject);
	const Image bare = painter.paint(moment(), {}, {}), image = painter.paint(moment(), answerAt(*torus, 0, *torus, 0), {});
	const auto meanLightness = [&](int from, int to)
	{
		double sum = 0;
		int pixels = 0;
		for (int y = 0; y < image.height * 7 / 8; ++y)
			for (int x = from; x < to; ++x)
				if (const Color color = image.at(x, y); unlikeness(color, bare.at(x, y)) > 0.1)
					sum += double(color.r + color.g + color.b) / 3, ++pixels;
		return sum / pixels;
	};
	const int middle = image.width / 4;
	EXPECT_GT(meanLightness(middle + 20, 2 * middle), 1.15 * meanLightness(0, middle - 20));
}
// A lies left of B: pulled along contact normals that point to it, its left end is farther left than pulled the other
// way.
TEST(RunnerFrames, PatchesInContactArePulledApartAlongTheirNormals)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	FramePainter painter(subjectOf(torus, torus));
	const auto leftEnd = [&](double side)
	{
		FrameAnswer answer = answerAt(*torus, 0, *torus, 0);
		for (Contact& contact : answer.pairs[0].result.contacts) contact.normal = {side, 0, 0};
		const Image image = painter.paintExploded(moment(), answer);
		const Color exact = levelColor(0, 2);
		for (int x = 0; x < image.width; ++x)
			for (int y = image.height / 3; y < 2 * image.height / 3; ++y)
				if (unlikeness(image.at(x, y), exact) < 0.2) return x;
		return image.width;
	};
	EXPECT_LT(leftEnd(-1) + 20, leftEnd(1));
}

// Words lay over the tops of falling columns.
TEST(RunnerFrames, WordsAreOutsideOfThePicture)
{
	const HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	FrameSubject worded = subjectOf(torus, torus), bare = worded;
	worded.title = "a title";
	worded.summary = "what it is about, which is so much that it is told in two lines of words and not in a single one";
	const FrameAnswer answer = answerAt(*torus, 0, *torus, 0);
	FrameAnswer told = answer;
	told.selection = "a limit that is described in so many words that it, too, takes more than one line under the title";
	std::vector<FrameContact> contacts(3);
	const Image without = FramePainter(bare).paint(moment(), answer, contacts),
				with = FramePainter(worded).paint(moment(), told, contacts);
	ASSERT_EQ(with.height, without.height);
	int first = with.height, last = 0;  // row of the picture: between them the background is not white
	for (int y = 0; y < with.height; ++y)
		if (without.at(without.width / 4, y).r < 0.97f) first = std::min(first, y), last = y;
	EXPECT_NEAR(last + 1 - first, with.width / 2, 20) << "the picture is square";
	int changed = 0, changedWithin = 0;
	for (int y = 0; y < with.height; ++y)
		for (int x = 0; x < with.width / 2; ++x)
			if (unlikeness(with.at(x, y), without.at(x, y)) > 0 || with.at(x, y).r != without.at(x, y).r)
				++changed, changedWithin += y >= first && y <= last ? 1 : 0;
	EXPECT_GT(changed, 1000);
	EXPECT_EQ(changedWithin, 0);
}

// A nut began above its picture, and a pile's digits fell in from there.
TEST(RunnerFrames, BodiesBeginInThePicture)
{
	for (const SceneDefinition& scene : sceneDefinitions())
	{
		if (scene.prepare) continue;  // its places only built models know
		const Camera camera = overviewCamera(scene.info.overview);
		const Vec3 ahead = normalized(camera.target - camera.eye), right = normalized(cross(ahead, {0, 1, 0})),
				   up = cross(right, ahead);
		const double half = std::tan(camera.fovy * kPi / 360);
		std::vector<ModelMesh> models;
		for (const SceneModel& model : scene.info.models) models.push_back(makeModel(model.name).value());
		for (std::size_t i = 0; i < scene.bodies.size(); ++i)
			for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0})
			{
				const BodyDefinition& body = scene.bodies[i];
				if (part > 0 && !body.course) break;  // only a run tells
				const double time = part * scene.info.steps * scene.info.dt;
				const Transform place = toTransform(body.course ? body.course(time) : body.start);
				if (scene.info.models[scene.info.bodies[i].model].name == "floor") continue;
				double top = 1, bottom = 0, aside = 0;
				for (const Vec3& vertex : models[scene.info.bodies[i].model].vertices)
				{
					const Vec3 at = place * vertex - camera.eye;
					const double depth = half * dot(at, ahead), down = 0.5 - 0.5 * dot(at, up) / depth;
					top = std::min(top, down);
					bottom = std::max(bottom, down);
					aside = std::max(aside, std::fabs(dot(at, right) / depth));
				}
				EXPECT_TRUE(top > 0 && bottom < 1 && aside < 1)
					<< scene.info.bodies[i].name << " of " << scene.info.name << " at " << time << " s: " << top << " to "
					<< bottom << " of the height, " << aside << " aside";
			}
	}
}

TEST(LevelPictures, HeatIsByHalfDecades)
{
	for (const auto& [share, step] :
		 {std::pair(0.0, 0), {1e-4, 0}, {1.01e-4, 1}, {3.01e-4, 2}, {0.02, 5}, {0.1, 6}, {0.2, 7}})
		EXPECT_EQ(heatStep(share), step) << share;
}
}  // namespace
