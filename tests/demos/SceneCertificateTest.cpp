// SPDX-License-Identifier: GPL-3.0-or-later
// Every scene that clod-bench lists, stepped at a low resolution: what any selection answers at the recorded poses of
// its pairs, caches carried from row to row, keeps its certificate. CLOD_SCENE_... variables lengthen the tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "demos/runner/SceneModels.h"
#include "demos/runner/SceneRun.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/SceneDefinition.h"
#include "tests/demos/KeptHierarchies.h"
#include "tests/query/Questions.h"
#include "tests/query/TriangleGap.h"
#include "tests/support/NamedTests.h"

namespace
{
using namespace clod;
using demo::PoseRow;
using demo::SceneInfo;
using test::setting;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kPeriod = 40;  // steps, of which the first CLOD_SCENE_BLOCK are asked about

std::vector<demo::HierarchyPointer> modelsOf(const SceneInfo& scene)
{
	return demo::buildModels(scene, {0.01 * setting("CLOD_SCENE_PERCENT", 3), false}, test::keptHierarchies());
}

// How contacts are asked for, as users write it.
struct Asked
{
	std::string name;
	demo::ReplayOptions options;
};

std::vector<Asked> selectionsOf(const SceneInfo& scene)
{
	demo::ReplayOptions plain;
	plain.tolerance.value = scene.tolerance;
	plain.dt = scene.dt;
	std::vector<Asked> list;
	const auto add = [&](const char* name, const ContactMetric& metric)
	{
		list.push_back({name, plain});
		list.back().options.metric = metric;
	};
	add("exact", ContactMetric::exactly());
	add("certified 0.5 %", ContactMetric::errorShare(0.005));
	add("certified 5 %", ContactMetric::errorShare(0.05));
	add("s0 3.5 %", ContactMetric::deviationShare(0.035));
	add("s0 0.35 %", ContactMetric::deviationShare(0.0035));
	add("velocity 0.3", ContactMetric::velocityFactor(0.3));
	add("s0 0.35 %, 300 tests", ContactMetric::deviationShare(0.0035));
	list.back().options.budget.tests = 300;
	return list;
}

// The exact gap, at any separation and depth.
GapSettings referenceSettings()
{
	GapSettings settings;
	settings.metric.exact = true;
	settings.distance = true;
	return settings;
}

bool isNumber(const GapResult& result)
{
	bool holds = !std::isnan(result.minDistance) && !std::isnan(result.errorBound) && result.errorBound >= 0;
	for (const Contact& c : result.contacts)
		holds = holds && c.lower <= c.upper && isFinite(c.pointOnA) && isFinite(c.pointOnB) && isFinite(c.normal);
	return holds;
}

// What of its promises an answer breaks, or nothing.
std::string wrong(const GapResult& result, const GapSettings& settings, const test::GapInterval& truth)
{
	if (!isNumber(result)) return "not a number";
	const bool isExcused = result.deep || result.stats.depthsCutShort > 0 || settings.budget.isLimited();
	if (result.errorBound == kInfinity) return result.deep ? "" : "no bound, and not deep";
	if (!isExcused && result.errorBound > settings.metric.maxError) return "beyond the certified limit";
	return test::broken(result, truth, settings.tolerance);
}

test::GapInterval intervalOf(const GapResult& exact)
{
	return {exact.minDistance - exact.errorBound, exact.minDistance + exact.errorBound};
}

// Levels are chosen by a limit that is the same everywhere, without a budget.
bool isTightAimed(const GapSettings& settings)
{
	const Metric& metric = settings.metric;
	return !settings.budget.isLimited() && (metric.weightedDeviation < kOff || metric.maxError < kOff);
}

// One pair of bodies: a cache for each selection.
struct Pair
{
	std::vector<GapCache> caches;
	GapCache reference;
	std::optional<PoseRow> previous;
};

struct Tally
{
	std::size_t rows = 0, near = 0, moving = 0, resting = 0, overlapping = 0, deep = 0, truths = 0;
	std::vector<double> bounds, errors;  // at s0 3.5 %, of rows within the tolerance, shares of the radius
	// By selection, of those with contacts whose surfaces are apart.
	struct Tightness
	{
		std::vector<double> shares;  // bounds over the certified deviation of the nearest pair
		std::size_t exact = 0;       // rows whose gap the input surfaces gave: there is no bound to be tight
	};
	std::map<std::string, Tightness> tightness;
};

class SceneCertificates : public testing::TestWithParam<std::string>
{
protected:
	void ask(const SceneInfo& scene, const std::vector<demo::HierarchyPointer>& models,
			 const std::vector<PoseRow>& poses)
	{
		const demo::Bodies bodies = demo::bodiesOf(scene, models);
		const std::vector<Asked> selections = selectionsOf(scene);
		std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> pairs;
		for (const PoseRow& row : poses)
		{
			Pair& pair = pairs[{row.bodyA, row.bodyB}];
			if (pair.caches.empty()) pair.caches.resize(selections.size());
			if (row.step % kPeriod < setting("CLOD_SCENE_BLOCK", 8)) askAt(scene, selections, row, bodies, pair);
			pair.previous = row;
		}
	}

	void askAt(const SceneInfo& scene, const std::vector<Asked>& selections, const PoseRow& row,
			   const demo::Bodies& bodies, Pair& pair)
	{
		const Hierarchy &a = *bodies[row.bodyA], &b = *bodies[row.bodyB];
		const double radius = demo::smallerRadius(a, b);
		const Transform pose = demo::relativePose(row, demo::meshFromBody(a), demo::meshFromBody(b));
		RelativeMotion motion;
		double speed = 0;
		if (pair.previous)
		{
			const double seconds = double(row.step - pair.previous->step) * scene.dt;
			motion = demo::relativeMotion(a, b, *pair.previous, row, seconds);
			speed = demo::relativeSpeed(a, b, *pair.previous, row, seconds);
		}
		motion.timeStep = scene.dt;
		GapResult truth, result;
		signedGap(a, b, pose, referenceSettings(), pair.reference, truth);
		ASSERT_TRUE(isNumber(truth) && std::isfinite(truth.errorBound));
		const bool isNear = truth.minDistance <= scene.tolerance;
		++m_tally.rows;
		m_tally.near += isNear;
		m_tally.overlapping += truth.minDistance < 0;
		m_tally.moving += isNear && demo::classify(speed) == demo::Motion::moving;
		m_tally.resting += isNear && pair.previous && demo::classify(speed) == demo::Motion::rest;
		for (std::size_t i = 0; i < selections.size(); ++i)
		{
			const GapSettings settings = demo::settingsOf(selections[i].options, a, b, row, motion);
			signedGap(a, b, pose, settings, pair.caches[i], result);
			EXPECT_EQ(wrong(result, settings, intervalOf(truth)), "")
				<< scene.name << " step " << row.step << ", bodies " << row.bodyA << " and " << row.bodyB << ", "
				<< selections[i].name << ": " << result.minDistance << " +- " << result.errorBound << ", truth "
				<< truth.minDistance << " +- " << truth.errorBound << ", tolerance " << scene.tolerance;
			m_tally.deep += result.deep;
			if (!isNear) continue;
			if (isTightAimed(settings) && truth.minDistance > 0 && !result.contacts.empty())
			{
				Tally::Tightness& tightness = m_tally.tightness[selections[i].name];
				const double deviation = test::deviationOfNearest(a, b, result);
				// Of nodes that are all but exact the nearest pair says nothing of the bound.
				if (result.errorBound > 1e-6 * radius && deviation > 1e-4 * radius)
					tightness.shares.push_back(result.errorBound / deviation);
				else
					++tightness.exact;
			}
			if (selections[i].name != "s0 3.5 %") continue;
			m_tally.bounds.push_back(result.errorBound / radius);
			const double gap = std::min(result.minDistance, scene.tolerance);
			m_tally.errors.push_back(std::abs(gap - truth.minDistance) / radius);
		}
		if (isNear) m_near.push_back(row);
	}

	// The reference itself against every triangle with every other, at rows spread over those within the tolerance.
	void checkReference(const SceneInfo& scene, const std::vector<demo::HierarchyPointer>& models)
	{
		const demo::Bodies bodies = demo::bodiesOf(scene, models);
		const std::size_t count = std::min(m_near.size(), std::size_t(setting("CLOD_SCENE_TRUTHS", 3)));
		for (std::size_t i = 0; i < count; ++i)
		{
			const PoseRow& row = m_near[(2 * i + 1) * m_near.size() / (2 * count)];
			const Hierarchy &a = *bodies[row.bodyA], &b = *bodies[row.bodyB];
			const Transform pose = demo::relativePose(row, demo::meshFromBody(a), demo::meshFromBody(b));
			const double radius = demo::smallerRadius(a, b);
			const test::GapInterval truth =
				test::triangleGap(test::inputTriangles(a), test::inputTriangles(b), pose, 1e-3 * radius);
			GapCache cache;
			GapResult exact;
			signedGap(a, b, pose, referenceSettings(), cache, exact);
			EXPECT_EQ(wrong(exact, referenceSettings(), truth), "") << scene.name << " step " << row.step;
			++m_tally.truths;
		}
	}

	Tally m_tally;
	std::vector<PoseRow> m_near;
};

demo::SceneRunOptions runOf(const SceneInfo& scene)
{
	demo::SceneRunOptions run;
	run.info = scene;
	run.scene.models = modelsOf(scene);
	run.scene.metric = ContactMetric::errorShare(demo::kDefaultMaxError);
	run.scene.dt = scene.dt;
	run.scene.printsWarnings = false;
	run.steps = std::min(scene.steps, setting("CLOD_SCENE_BODY_STEPS", 16000) / int(scene.bodies.size()));
	return run;
}

// Nothing drives its bodies on and something brakes them: to the end, it comes to rest.
bool comesToRest(const SceneInfo& scene, int steps)
{
	bool isFree = steps == scene.steps;
	for (const demo::SceneDefinition& definition : demo::sceneDefinitions())
		if (definition.info.name == scene.name)
		{
			isFree = isFree && !definition.prepare && definition.world.angularDamping > 0;
			for (const demo::BodyDefinition& body : definition.bodies) isFree = isFree && !body.course;
		}
	return isFree;
}

TEST_P(SceneCertificates, HoldAtEveryRow)
{
	const SceneInfo& scene = *demo::findScene(GetParam());
	const demo::SceneRunOptions run = runOf(scene);
	ask(scene, run.scene.models, demo::simulatePoses(run, [](double) {}));
	checkReference(scene, run.scene.models);
	const double bound = demo::quantile(m_tally.bounds, 0.95), error = demo::quantile(m_tally.errors, 0.95);
	std::printf(
		"%s: %d steps, %zu rows asked, %zu within the tolerance (%zu moving, %zu at rest, %zu overlapping), "
		"%zu answers deep, %zu rows against triangles; s0 3.5 %%: 95 %% of bounds within %.2f, of errors within %.2f "
		"%% of the radius\n",
		scene.name.c_str(), run.steps, m_tally.rows, m_tally.near, m_tally.moving, m_tally.resting, m_tally.overlapping,
		m_tally.deep, m_tally.truths, 100 * bound, 100 * error);
	EXPECT_GT(m_tally.near, 20u);
	EXPECT_GT(m_tally.moving, 10u);
	EXPECT_GT(m_tally.truths, 0u);
	EXPECT_LE(error, 0.03);
	EXPECT_LE(bound, 0.03);
	for (const auto& [name, tightness] : m_tally.tightness)
	{
		std::printf("  %s: %zu rows exact by the input surfaces", name.c_str(), tightness.exact);
		if (!tightness.shares.empty())
		{
			const double median = demo::quantile(tightness.shares, 0.5);
			std::printf("; median bound %.2f deviations of the nearest pair (%zu other rows)", median,
						tightness.shares.size());
			EXPECT_LE(median, 2.5) << name << ", " << tightness.shares.size() << " rows";
		}
		std::printf("\n");
	}
	EXPECT_TRUE(m_tally.resting > 0 || !comesToRest(scene, run.steps));
}

// The paper's scenes and those for its metrics; CLOD_SCENE_MECHANISMS adds the mechanisms, piles and rocking bodies, whose
// certificates take minutes.
std::vector<std::string> sceneNames()
{
	std::vector<std::string> names = {"spoon-cup",   "torus-spiral", "numbers-bowl", "spoons-nested",
									  "bolt-nut",    "mixed-needs",  "contact-area", "drop"};
	if (test::setting("CLOD_SCENE_MECHANISMS", 0) == 0) return names;
	for (const SceneInfo& scene : demo::scenes())
		if (std::find(names.begin(), names.end(), scene.name) == names.end()) names.push_back(scene.name);
	return names;
}
INSTANTIATE_TEST_SUITE_P(Scenes, SceneCertificates, testing::ValuesIn(sceneNames()), clod::test::nameOfTest);

TEST(SceneCertificate, TheCheckSeesPlantedFaults)
{
	GapSettings settings;
	settings.tolerance = 0.5;
	settings.metric.maxError = 0.2;
	const test::GapInterval truth{0.3, 0.3};
	GapResult result;
	result.minDistance = 0.2;
	result.errorBound = 0.1;
	EXPECT_EQ(wrong(result, settings, truth), "");
	const auto with = [&](auto change)
	{
		GapResult fault = result;
		change(fault);
		return wrong(fault, settings, truth);
	};
	EXPECT_NE(with([](GapResult& r) { r.minDistance = 0.199; }), "");
	EXPECT_NE(with([](GapResult& r) { r.minDistance = 0.401; }), "");
	EXPECT_NE(with([](GapResult& r) { r.minDistance = std::nan(""); }), "");
	EXPECT_NE(with([](GapResult& r) { r.errorBound = std::nan(""); }), "");
	EXPECT_NE(with([](GapResult& r) { r.errorBound = 0.21; }), "");
	EXPECT_NE(with([](GapResult& r) { r.errorBound = kInfinity; }), "");
	EXPECT_NE(with([](GapResult& r) { r.minDistance = kInfinity; }), "");
	EXPECT_NE(with([](GapResult& r) { r.contacts.push_back({0, 0, 0, std::nan(""), {}, {}, {}}); }), "");
}

// 0.1, 0.5 and 1 % of the radius: found for the models as they are, to 2 % every fifth step, between them evenly.
TEST(SceneCertificate, TheNestedSpoonsAreHeldAtThreeGaps)
{
	const demo::SceneRunOptions run = runOf(*demo::findScene("spoons-nested"));
	const auto scene = demo::makeScene(run.info.name, run.scene);
	std::map<std::string, double> constants;
	for (const demo::SceneConstant& constant : scene->constants()) constants[constant.name] = constant.value;
	const Hierarchy& spoon = *run.scene.models[0];
	const double radius = spoon.asset().radius;
	const double hold = constants.at("hold_time"), period = hold + constants.at("change_time");
	std::vector<double> held[3];
	GapCache cache;
	GapResult result;
	for (const PoseRow& row : demo::simulatePoses(run, [](double) {}))
	{
		const double time = double(row.step) * run.info.dt;
		const auto which = std::size_t(time / period);
		if (which > 2 || time - double(which) * period > hold) continue;
		const Transform pose = demo::relativePose(row, demo::meshFromBody(spoon), demo::meshFromBody(spoon));
		signedGap(spoon, spoon, pose, referenceSettings(), cache, result);
		held[which].push_back(result.minDistance / radius);
	}
	const double shares[] = {0.001, 0.005, 0.01};
	for (std::size_t i = 0; i < 3; ++i)
	{
		ASSERT_GT(held[i].size(), 60u);
		const std::vector<double>& gaps = held[i];
		const double least = demo::quantile(gaps, 0), median = demo::quantile(gaps, 0.5);
		std::printf("held at %.3f to %.3f %% of the radius, median %.3f\n", 100 * least, 100 * demo::quantile(gaps, 1),
					100 * median);
		EXPECT_NEAR(median, shares[i], 0.03 * shares[i]);
		EXPECT_NEAR(constants.at("held_gap_" + std::to_string(i + 1)), shares[i] * radius, 0.01 * shares[i] * radius);
	}
}
}  // namespace
