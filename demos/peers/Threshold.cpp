// SPDX-License-Identifier: Zlib
#include "demos/peers/Threshold.h"

#include <fmt/format.h>

#include <algorithm>

namespace clod::demo
{
namespace
{
constexpr double kSizes[] = {0.28, 0.14, 0.07, 0.035, 0.0175, 0.007, 0.0035, 0.00175, 0.0007, 0.00035};
constexpr double kErrors[] = {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002};
}  // namespace

std::string labelOf(const Threshold& threshold, double radius)
{
	MetricFrame frame;
	frame.radius = radius;
	const Metric metric = resolve(threshold.metric, frame);
	std::string text = metric.exact ? "exact" : "";
	const auto add = [&](const char* joint, const std::string& words) { text += (text.empty() ? "" : joint) + words; };
	const char* combined = metric.combine == Combine::kRelaxed ? " or " : " + ";
	if (metric.weightedDeviation < kOff)
		add(combined, fmt::format("size {:g} %", 100 * metric.weightedDeviation / radius));
	if (threshold.metric.velocity < kOff) add(combined, fmt::format("velocity {:g}", threshold.metric.velocity));
	if (threshold.metric.viewPixels < kOff) add(combined, fmt::format("view {:g} px", threshold.metric.viewPixels));
	if (metric.maxError < kOff) add(" + ", fmt::format("max-error {:g} %", 100 * metric.maxError / radius));
	if (threshold.gapError == 0) add(" + ", "exact gap");
	if (threshold.budget.tests < kOff) add(" + ", fmt::format("at most {:.0f} tests", threshold.budget.tests));
	if (threshold.budget.microseconds < kOff) add(" + ", fmt::format("about {:g} us", threshold.budget.microseconds));
	return text;
}

std::vector<Threshold> thresholdLadder()
{
	std::vector<Threshold> ladder;
	const auto add = [&](const ContactMetric& metric, double gapError = kOff)
	{
		ladder.push_back({"", metric, gapError, {}, {}});
		ladder.back().label = labelOf(ladder.back(), 1);
	};
	add(ContactMetric::exactly());
	for (const double size : kSizes) add(ContactMetric::deviationShare(size));
	for (const double error : kErrors) add(ContactMetric::errorShare(error));
	add(ContactMetric::errorShare(0.1), 0);
	add(ContactMetric::deviationShare(0.035), 0);
	add(ContactMetric::errorShare(0.005), 0);
	return ladder;
}

std::vector<Threshold> thresholdLadder(const std::optional<Threshold>& own, double radius)
{
	std::vector<Threshold> ladder = thresholdLadder();
	if (!own) return ladder;
	Threshold last = *own;
	last.label = labelOf(last, radius);
	if (std::none_of(ladder.begin(), ladder.end(), [&](const Threshold& t) { return t.label == last.label; }))
		ladder.push_back(last);
	return ladder;
}
}  // namespace clod::demo
