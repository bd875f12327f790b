// SPDX-License-Identifier: GPL-3.0-or-later
// A user's metric, in shares and world lengths: as the pair's own, the stricter of two, and refusals.
#include "clod/query/ContactMetric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "clod/query/StopRule.h"
#include "tests/query/Questions.h"

namespace
{
using namespace clod;
using namespace clod::test;

TEST(ContactMetric, ResolvesForAScaledPairSeenFromTheWorld)
{
	ViewCamera camera;
	camera.eye = {0, 0, 50};
	camera.fieldOfView = 2 * std::atan(1.0);  // 90 degrees: the image covers 2 at distance 1
	camera.imageHeight = 100;
	camera.nearDistance = 1;
	MetricFrame frame;
	frame.radius = 0.2;
	frame.scale = 10;
	frame.worldFromA.translation = {0, 0, 20};
	frame.motion.linear = {3, 0, 0};
	frame.motion.timeStep = 0.01;
	frame.camera = &camera;
	ContactMetric metric = ContactMetric::velocityFactor(0.5);
	metric.viewPixels = 2;
	metric.weightedDeviationShare = 0.1;
	ASSERT_EQ(contactMetricError(metric, &camera), "");
	const Metric used = resolve(metric, frame);
	EXPECT_EQ(metricError(used), "");
	EXPECT_DOUBLE_EQ(used.weightedDeviation, 0.02);
	EXPECT_DOUBLE_EQ(used.velocity.time, 0.005);
	EXPECT_DOUBLE_EQ(used.velocity.floor, 0.001 * 0.2);
	EXPECT_DOUBLE_EQ(used.view.eye.z, 3);  // 30 world lengths
	EXPECT_DOUBLE_EQ(used.view.nearest, 0.1);
	// 2 pixels at 30: 2 * 30 * 2 / 100 = 1.2 in the world, 0.12 in the hierarchy.
	Metric onlyView;
	onlyView.view = used.view;
	EXPECT_NEAR(Threshold(onlyView, kAnySpeed).at({}), 0.12, 1e-12);
	onlyView.view.pixels = 0;
	EXPECT_EQ(Threshold(onlyView, kAnySpeed).at({}), 0);
	// The eye at the contact: the near plane's share, nothing without one.
	camera.eye = {0, 0, 20};
	onlyView.view = resolve(metric, frame).view;
	EXPECT_NEAR(Threshold(onlyView, kAnySpeed).at({}), 0.004, 1e-12);
	camera.nearDistance = 0;
	ASSERT_EQ(contactMetricError(metric, &camera), "");
	onlyView.view = resolve(metric, frame).view;
	EXPECT_EQ(Threshold(onlyView, kAnySpeed).at({}), 0);
	const ContactPlace place = inWorld({{0.1, 0, 0}, 0.01}, frame);
	EXPECT_DOUBLE_EQ(place.center.x, 1);
	EXPECT_DOUBLE_EQ(place.center.z, 20);
	EXPECT_DOUBLE_EQ(place.radius, 0.1);
	EXPECT_DOUBLE_EQ(place.velocity.x, 30);
}

// s0 of the stricter metric is at most that of each, whatever they combine.
TEST(ContactMetric, StricterIsNeverCoarserThanEither)
{
	Random random(25);
	ViewCamera camera;
	camera.imageHeight = 100;
	MetricFrame frame;
	frame.camera = &camera;
	frame.motion.timeStep = 1;
	const auto any = [&]
	{
		ContactMetric metric;
		if (random() % 2) metric.weightedDeviation = uniform(random, 0, 1);
		if (random() % 2) metric.velocity = uniform(random, 0, 1);
		metric.velocityFloorShare = uniform(random, 0, 0.3);
		if (random() % 2) metric.viewPixels = uniform(random, 0, 10);
		const double own = uniform(random, 0, 1);
		if (random() % 2) metric.own = ContactMetric::ownThreshold([own](const ContactPlace&) { return own; }).own;
		if (random() % 4) metric.combine = Combine::kRelaxed;
		return metric;
	};
	const auto s0 = [&](const ContactMetric& metric)
	{
		Metric used = resolve(metric, frame);
		const OwnThreshold own = [&](const Place& place) { return (*metric.own)(inWorld(place, frame)); };
		if (metric.own) used.own = &own;
		return Threshold(used, kAnySpeed).at({{0.5, 0, 0}, 0.1});
	};
	int relaxed = 0, lower = 0;
	for (int i = 0; i < 3000; ++i)
	{
		const ContactMetric a = any(), b = any(), both = stricter(a, b);
		frame.motion.linear = randomVector(random, 0, 1);
		camera.eye = randomVector(random, 0, 20);
		EXPECT_LE(s0(both), std::min(s0(a), s0(b)));
		relaxed += both.combine == Combine::kRelaxed;
		lower += s0(both) < std::min(s0(a), s0(b));
	}
	EXPECT_GT(relaxed, 50);
	EXPECT_LT(lower, 2500);
}

TEST(ContactMetric, RefusesWhatCannotBeUsedByName)
{
	ViewCamera camera;
	camera.imageHeight = 720;
	const double nan = std::nan("");
	struct Case
	{
		const char* field;
		std::function<void(ContactMetric&, ViewCamera&)> change;
	};
	const Case cases[] = {
		{"weightedDeviation is", [](auto& m, auto&) { m.weightedDeviation = -1; }},
		{"weightedDeviationShare", [=](auto& m, auto&) { m.weightedDeviationShare = nan; }},
		{"velocity is", [](auto& m, auto&) { m.velocity = -0.1; }},
		{"velocityFloor is", [=](auto& m, auto&) { m.velocityFloor = nan; }},
		{"velocityFloorShare", [](auto& m, auto&) { m.velocityFloorShare = -1; }},
		{"velocityFloor", [](auto& m, auto&) { m.velocityFloorShare = kOff; }},
		{"viewPixels", [=](auto& m, auto&) { m.viewPixels = nan; }},
		{"maxError is", [](auto& m, auto&) { m.maxError = -1; }},
		{"maxErrorShare", [=](auto& m, auto&) { m.maxErrorShare = nan; }},
		{"own", [](auto& m, auto&) { m.own = std::make_shared<const ContactThreshold>(); }},
		{"camera.eye", [=](auto&, auto& c) { c.eye.x = nan; }},
		{"camera.fieldOfView", [](auto&, auto& c) { c.fieldOfView = 4; }},
		{"camera.imageHeight", [](auto&, auto& c) { c.imageHeight = 0; }},
		{"camera.nearDistance", [](auto&, auto& c) { c.nearDistance = -1; }},
	};
	for (const Case& bad : cases)
	{
		ContactMetric metric = ContactMetric::velocityFactor(0.3);
		metric.viewPixels = 1;
		ViewCamera used = camera;
		EXPECT_EQ(contactMetricError(metric, &used), "");
		bad.change(metric, used);
		const std::string error = contactMetricError(metric, &used);
		EXPECT_NE(error.find(bad.field), std::string::npos) << bad.field << ": '" << error << "'";
	}
	EXPECT_NE(contactMetricError(ContactMetric::viewError(1), nullptr).find("camera"), std::string::npos);
	EXPECT_EQ(contactMetricError(ContactMetric::velocityFactor(1), nullptr), "");
}
}  // namespace
