// SPDX-License-Identifier: Zlib
// Selection flags to the query's settings.
#include "demos/runner/Selection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <functional>

#include <cmath>
#include <vector>

#include "cli/Failure.h"
#include "cli/Program.h"
#include "demos/render/MetricLength.h"

namespace clod::demo
{
namespace
{
std::string checkPercent(const std::string& text)
{
	const bool unit =
		!text.empty() && text.back() != '%' && text.back() != '.' && (text.back() < '0' || text.back() > '9');
	return unit ? "--size takes per cent of the radius, not '" + text + "'; use --s0 for a length" : "";
}

cli::Length shareOf(const cli::Length& percent)
{
	// --size 3.5 and --size 3.5% mean the same share of the radius.
	if (percent.shareOfRadius) return percent;
	return {percent.value / 100, true, percent.text + "%"};
}
// ex,ey,ez,tx,ty,tz,fovy
std::string parseCamera(const std::string& text, std::optional<Camera>& camera)
{
	double v[7];
	int end = 0;
	const int read =
		std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf%n", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6, &end);
	if (read != 7 || std::size_t(end) != text.size()) return "'" + text + "' is not ex,ey,ez,tx,ty,tz,fovy";
	for (const double value : v)
		if (!std::isfinite(value)) return "'" + text + "' holds a number that is not finite";
	const Vec3 eye{v[0], v[1], v[2]}, target{v[3], v[4], v[5]};
	if (eye == target) return "the camera's eye is its target";
	if (!(v[6] > 0 && v[6] < 180)) return "the camera's fovy is not between 0 and 180 degrees";
	camera = Camera{eye, target, v[6]};
	return {};
}

CLI::Option* addNumber(CLI::App& command, const std::string& name, const std::string& type,
					   std::optional<double>& value, const std::string& description)
{
	const auto check = [](const std::string& text) -> std::string
	{
		double number = 0;
		if (!CLI::detail::lexical_cast(text, number) || !(number >= 0) || !std::isfinite(number))
			return "'" + text + "' is not a finite number >= 0";
		return {};
	};
	return command.add_option(name, value, description)->type_name(type)->check(check);
}

// --velocity, --view and what belongs to them.
void addPlaceMetrics(CLI::App& command, Selection& selection)
{
	CLI::Option* velocity = addNumber(command, "--velocity", "K", selection.velocity,
									  "Threshold K times the way of a step at the contact's relative speed");
	cli::addLength(command, "--velocity-floor", selection.velocityFloor,
				   "Its least value, that of a body at rest (default 0.1%)")
		->needs(velocity);
	const auto addCamera = [&command](const char* name, std::optional<Camera>& camera, const std::string& description)
	{
		return command.add_option(name, description)
			->type_name("ex,ey,ez,tx,ty,tz,fovy")
			->check([&camera](const std::string& text) { return parseCamera(text, camera); });
	};
	CLI::Option* eye = addCamera("--camera", selection.camera,
								 "The camera of view metrics and frames: eye, target, vertical field of view");
	addCamera("--camera-to", selection.cameraTo, "Where the camera has gone by the last step, evenly")->needs(eye);
	addNumber(command, "--view", "PIXELS", selection.view,
			  fmt::format("Threshold of so many pixels of a picture {} high, seen from --camera", kViewImageHeight))
		->needs(eye);
	for (const char* name : {"--velocity", "--view"}) command.get_option("--exact")->excludes(command.get_option(name));
}

// CLI11's own range lets a NaN pass.
std::string isNotBudget(const std::string& text)
{
	double value = 0;
	const bool isNumber = CLI::detail::lexical_cast(text, value);
	return isNumber && value >= 0 && value <= 1e15 ? "" : text + " is no number from 0 to 1e15";
}

void addBudget(CLI::App& command, Selection& selection)
{
	command
		.add_option("--budget-tests", selection.budget.tests,
					"At most N hull and culling tests a query (a step of run) beyond the coarsest answer: all "
					"thresholds are raised by one factor")
		->type_name("N")
		->check(isNotBudget);
	command
		.add_option("--budget-us", selection.budget.microseconds,
					"The same in microseconds by the clock (of run: the whole dispatch): does not repeat")
		->type_name("T")
		->check(isNotBudget);
}
}  // namespace

void addSelection(CLI::App& command, Selection& selection)
{
	CLI::Option* exact =
		command.add_flag("--exact", selection.exact, "Leaf level only: every contact at full resolution");
	CLI::Option* s0 = cli::addLength(command, "--s0", selection.s0, "The paper's threshold on the weighted deviation");
	CLI::Option* size =
		cli::addLength(command, "--size", selection.size, "The same threshold in per cent of the radius (3.5 = 3.5%)")
			->type_name("PCT")
			->check(checkPercent);
	CLI::Option* error = cli::addLength(command, "--max-error", selection.maxError,
										"Certified limit of the gap's error, never exceeded (default 0.5% when no "
										"selection is given)");
	exact->excludes(s0)->excludes(size)->excludes(error);
	s0->excludes(size);
	addPlaceMetrics(command, selection);
	cli::addChoice(command, "--combine", selection.combine, {"strict", "relaxed"},
				   "How several thresholds combine: strict = all must allow, relaxed = one is enough")
		->capture_default_str();
	command.add_flag("--paper", selection.paper,
					 "The paper's culling and contact rules; meshes are then built with --paper");
	command.add_flag("--fresh", selection.fresh, "Drop all caches before every query");
	addBudget(command, selection);
}

void refuseUnusedCamera(const Selection& selection)
{
	if (selection.camera && !selection.view)
		throw cli::Failure(cli::ExitCode::usage, "--camera has no effect without --view (or --frames of run)");
}

void refuseClock(const Selection& selection, int repeat)
{
	if (selection.budget.microseconds < kOff && repeat > 1)
		throw cli::Failure(cli::ExitCode::usage,
						   "--budget-us answers by the clock, which --repeat would not find again");
}

ContactMetric toMetric(const Selection& selection)
{
	ContactMetric metric;
	metric.exact = selection.exact;
	const auto set = [](const cli::Length& length, double& absolute, double& share)
	{ (length.shareOfRadius ? share : absolute) = length.value; };
	if (selection.s0) set(*selection.s0, metric.weightedDeviation, metric.weightedDeviationShare);
	if (selection.size) set(shareOf(*selection.size), metric.weightedDeviation, metric.weightedDeviationShare);
	if (selection.maxError) set(*selection.maxError, metric.maxError, metric.maxErrorShare);
	if (selection.velocity) metric.velocity = *selection.velocity;
	if (selection.velocityFloor)
	{
		metric.velocityFloorShare = kOff;
		set(*selection.velocityFloor, metric.velocityFloor, metric.velocityFloorShare);
	}
	if (selection.view) metric.viewPixels = *selection.view;
	metric.combine = selection.combine == "relaxed" ? Combine::kRelaxed : Combine::kStrict;
	if (!selection.hasMetric()) metric.maxErrorShare = kDefaultMaxError;
	return metric;
}

std::optional<CameraPath> toCameraPath(const Selection& selection, std::int64_t steps)
{
	if (!selection.camera) return {};
	const auto toView = [](const Camera& camera)
	{
		return ViewCamera{camera.eye, camera.fovy * 3.14159265358979323846 / 180, double(kViewImageHeight),
						  0.01 * length(camera.target - camera.eye)};
	};
	return CameraPath{toView(*selection.camera), toView(selection.cameraTo.value_or(*selection.camera)), steps};
}

// The thresholds s0, and which of them counts.
using SayLength = std::function<std::string(const cli::Length&)>;
static std::vector<std::string> thresholdsInWords(const Selection& selection, const SayLength& say)
{
	std::vector<std::string> words;
	if (selection.s0) words.push_back("s0 " + say(*selection.s0));
	if (selection.size) words.push_back("s0 " + say(shareOf(*selection.size)));
	const cli::Length floor =
		selection.velocityFloor.value_or(cli::Length{ContactMetric{}.velocityFloorShare, true, "0.1%"});
	if (selection.velocity)
		words.push_back(fmt::format("s0 {:g} of a step's motion, at least {}", *selection.velocity, say(floor)));
	if (selection.view) words.push_back(fmt::format("s0 {:g} pixels of {}", *selection.view, kViewImageHeight));
	if (selection.combine == "relaxed" && words.size() > 1) words.push_back("the largest s0");
	return words;
}

static std::string inWords(const Selection& selection, const SayLength& say)
{
	std::vector<std::string> words = thresholdsInWords(selection, say);
	const cli::Length error = selection.maxError.value_or(cli::Length{kDefaultMaxError, true, "0.5%"});
	if (selection.exact) words.push_back("exact");
	if (selection.maxError || !selection.hasMetric()) words.push_back("certified error at most " + say(error));
	if (selection.budget.tests < kOff) words.push_back(fmt::format("at most {:.0f} tests", selection.budget.tests));
	if (selection.budget.microseconds < kOff)
		words.push_back(fmt::format("about {:g} us", selection.budget.microseconds));
	if (selection.paper) words.push_back("by the paper's rules");
	if (selection.fresh) words.push_back("without caches");
	return fmt::format("{}", fmt::join(words, ", "));
}

std::string describe(const Selection& selection, double radius)
{
	return inWords(selection, [&](const cli::Length& length) { return cli::describe(length, radius); });
}

std::string describeMetric(const Selection& selection, double radius)
{
	return inWords(selection, [&](const cli::Length& length)
				   { return cli::describe(length, radius, [](double metres) { return metricLength(metres); }); });
}

// As on the command line.
static nlohmann::ordered_json toJson(const std::optional<Camera>& camera)
{
	if (!camera) return nullptr;
	const Vec3 &eye = camera->eye, &target = camera->target;
	return {eye.x, eye.y, eye.z, target.x, target.y, target.z, camera->fovy};
}

nlohmann::ordered_json toJson(const Selection& selection, double radius)
{
	MetricFrame frame;
	frame.radius = radius;
	const Metric metric = resolve(toMetric(selection), frame);
	return {{"description", describe(selection, radius)},
			{"exact", metric.exact},
			{"s0", metric.weightedDeviation},
			{"max_error", metric.maxError},
			{"velocity", selection.velocity.value_or(kOff)},
			{"velocity_floor", metric.velocity.floor},
			{"view_pixels", selection.view.value_or(kOff)},
			{"camera", toJson(selection.camera)},
			{"camera_to", toJson(selection.cameraTo)},
			{"combine", selection.combine},
			{"budget_tests", selection.budget.tests},
			{"budget_us", selection.budget.microseconds},
			{"paper", selection.paper},
			{"fresh", selection.fresh}};
}
}  // namespace clod::demo
