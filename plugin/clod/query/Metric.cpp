// SPDX-License-Identifier: Zlib
// Comparison and validity of metrics.
#include "clod/query/Metric.h"

#include <tuple>

namespace clod
{
namespace
{
// Every field: one more does not compile before it is named here.
auto fieldsOf(const VelocityThreshold& threshold)
{
	const auto& [time, floor, linear, angular] = threshold;
	return std::tie(time, floor, linear, angular);
}
auto fieldsOf(const ViewThreshold& threshold)
{
	const auto& [pixels, eye, pixelSize, nearest] = threshold;
	return std::tie(pixels, eye, pixelSize, nearest);
}

std::string below(const char* field, double value)
{
	return "metric." + std::string(field) + " is " + std::to_string(value) + ", but must be >= 0";
}
std::string unbounded(const char* field)
{
	return "metric." + std::string(field) + " is not finite";
}
bool usable(double value)
{
	return value >= 0 && std::isfinite(value);
}
}  // namespace

bool same(const Metric& l, const Metric& r)
{
	const auto fields = [](const Metric& metric)
	{
		const auto& [exact, weightedDeviation, velocity, view, own, combine, maxError, coarsening] = metric;
		return std::tuple_cat(std::tie(exact, weightedDeviation, own, combine, maxError, coarsening), fieldsOf(velocity),
							  fieldsOf(view));
	};
	return !l.own && !r.own && fields(l) == fields(r);
}

std::string metricError(const Metric& metric)
{
	if (!(metric.weightedDeviation >= 0)) return below("weightedDeviation", metric.weightedDeviation);
	if (!(metric.maxError >= 0)) return below("maxError", metric.maxError);
	if (!(metric.coarsening >= 1))
		return "metric.coarsening is " + std::to_string(metric.coarsening) + ", but must be >= 1";
	const VelocityThreshold& velocity = metric.velocity;
	if (!(velocity.time >= 0)) return below("velocity.time", velocity.time);
	if (velocity.time < kOff)
	{
		if (!usable(velocity.floor)) return below("velocity.floor", velocity.floor) + " and finite";
		if (!isFinite(velocity.linear)) return unbounded("velocity.linear");
		if (!isFinite(velocity.angular)) return unbounded("velocity.angular");
	}
	const ViewThreshold& view = metric.view;
	if (!(view.pixels >= 0)) return below("view.pixels", view.pixels);
	if (view.pixels < kOff)
	{
		if (!isFinite(view.eye)) return unbounded("view.eye");
		if (!usable(view.pixelSize)) return below("view.pixelSize", view.pixelSize) + " and finite";
		if (!usable(view.nearest)) return below("view.nearest", view.nearest) + " and finite";
	}
	return {};
}
}  // namespace clod
