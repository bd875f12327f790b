// SPDX-License-Identifier: Zlib
// Comparison and validity of metrics.
#include "clod/query/Metric.h"

namespace clod
{
namespace
{
bool same(const VelocityThreshold& l, const VelocityThreshold& r)
{
	return l.time == r.time && l.floor == r.floor && l.linear == r.linear && l.angular == r.angular;
}
bool same(const ViewThreshold& l, const ViewThreshold& r)
{
	return l.pixels == r.pixels && l.eye == r.eye && l.pixelSize == r.pixelSize && l.nearest == r.nearest;
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
	return !l.own && !r.own && l.exact == r.exact && l.weightedDeviation == r.weightedDeviation &&
		   l.combine == r.combine && l.maxError == r.maxError && same(l.velocity, r.velocity) && same(l.view, r.view);
}

std::string metricError(const Metric& metric)
{
	if (!(metric.weightedDeviation >= 0)) return below("weightedDeviation", metric.weightedDeviation);
	if (!(metric.maxError >= 0)) return below("maxError", metric.maxError);
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
