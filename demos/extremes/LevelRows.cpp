// SPDX-License-Identifier: Zlib
// E16 to E20: levels of detail that switch under load, and thresholds at their ends.
#include <algorithm>
#include <cmath>
#include <utility>

#include "demos/extremes/RowParts.h"

namespace clod::demo
{
namespace
{
constexpr double kTorusReach = 0.7;  // its radius

// The torus, let go at a height of its centre.
std::size_t addTorusOnFloor(Stage& stage, double height)
{
	stage.setFriction(0.36);
	stage.add(boxSolid({4, 1, 4}), fixedAt({{0, -kHalfFloor, 0}}));
	return stage.add(torusSolid(0.5, 0.2, 3840), movingAt(1, {{0, height, 0}}));
}

// A torus at rest on a floor whose metric changes every so many steps between exact and its own. That its levels
// changed, too, the report says.
Readings switchedLevels(Workshop& workshop, const Setting& setting)
{
	if (!isOurs(setting.collider)) throw NotApplicable("has no levels");
	if (setting.collider == Collider::exact) throw NotApplicable("is at one level");
	Stage stage(workshop, setting);
	const std::size_t torus = addTorusOnFloor(stage, 0.21);
	stage.seconds(2);
	double fastest = 0;
	int count = 0, switches = 0;
	const int every = int(setting.parameter);
	std::uint32_t level = stage.state().coarsestLevel;
	stage.watch(setting.isQuick ? 1 : 3,
				[&]
				{
					const double speed = length(stage.velocity(torus)) + kTorusReach * length(stage.turning(torus));
					fastest = std::max(fastest, speed);
					switches += std::exchange(level, stage.state().coarsestLevel) != level ? 1 : 0;
					++count;
					stage.setMetric(metricOf((count / every) % 2 != 0 ? Collider::exact : setting.collider));
					return true;
				});
	return {amount(fastest / std::sqrt(kGravity * kTorusReach)), amount(std::max(0, (count - 1) / every - switches))};
}

// The paper's threshold dithered by a hundredth about values from 0.1 to 10 % of the radius.
Readings ditheredThreshold(Workshop& workshop, const Setting& setting)
{
	if (setting.collider != Collider::coarse) throw NotApplicable("has no threshold to dither");
	Stage stage(workshop, setting);
	const std::size_t torus = addTorusOnFloor(stage, 0.21);
	stage.seconds(2);
	double fastest = 0;
	for (int k = 0; k <= 20; ++k)
	{
		const double middle = 0.001 * std::pow(10, k / 10.0);
		stage.setMetric(ContactMetric::deviationShare(middle));
		stage.seconds(0.5);
		int count = 0;
		stage.watch(0.25,
					[&]
					{
						fastest = std::max(fastest, length(stage.velocity(torus)));
						stage.setMetric(ContactMetric::deviationShare(middle * (++count % 2 != 0 ? 0.99 : 1.01)));
						return true;
					});
	}
	return {amount(fastest / std::sqrt(kGravity * kTorusReach))};
}

// A spoon dropped into a cup twice, by two metrics that should say the same.
Readings zeroThreshold(Workshop& workshop, const Setting& setting)
{
	if (setting.collider != Collider::exact) throw NotApplicable("is not exact");
	const auto run = [&](const ContactMetric& metric)
	{
		Stage stage(workshop, setting, "spoon-cup", 0.03, {});
		stage.setMetric(metric);
		stage.seconds(1);
		return stage.pose(1);
	};
	const Transform one = run(ContactMetric::exactly()), other = run(ContactMetric::deviationShare(0));
	return {amount(length(one.translation - other.translation))};
}

// The coarsest valid levels still carry.
Readings endlessThreshold(Workshop& workshop, const Setting& setting)
{
	if (setting.collider != Collider::coarse) throw NotApplicable("has no threshold");
	Stage stage(workshop, setting);
	const std::size_t torus = addTorusOnFloor(stage, 0.25);
	stage.setMetric(ContactMetric::deviationShare(setting.parameter));
	stage.seconds(3);
	return {amount(std::fabs(stage.place(torus).y - 0.2) / kTorusReach), amount(length(stage.velocity(torus)))};
}
}  // namespace

std::vector<Row> levelRows()
{
	std::vector<Row> rows;
	rows.push_back({"E16",
					"a torus at rest, its level switched every N steps",
					"no speed is added; the report tells every switch",
					"",
					{{1, "every step"}, {2, "every 2"}, {7, "every 7"}},
					kRates,
					{{"speed", "sqrt(g R)", {1e-3}}, {"switches missed", "", {0}}},
					switchedLevels});
	rows.push_back({"E17",
					"a torus at rest, 21 thresholds dithered by 1 %",
					"no speed is added",
					"",
					{},
					kRates,
					{{"speed", "sqrt(g R)", {1e-3}}},
					ditheredThreshold});
	rows.push_back({"E18",
					"a spoon in a cup, s0 = 0 beside exact",
					"the same bits",
					"",
					{},
					kRates,
					{{"difference", "m", {0}}},
					zeroThreshold});
	rows.push_back({"E20",
					"a torus on a floor, s0 far beyond its size",
					"carried by the coarsest valid level",
					"",
					casesOf({0.1, 1e6}, " R"),
					kRates,
					{{"height", "R", {0.1}}, {"speed", "m/s", {0.01}}},
					endlessThreshold});
	return rows;
}
}  // namespace clod::demo
