// SPDX-License-Identifier: Zlib
// From a user's thresholds to those of one query.
#include "clod/query/ContactMetric.h"

#include <algorithm>
#include <cmath>

namespace clod
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

struct NamedThreshold
{
	const char* name;
	double ContactMetric::*value;
};
constexpr NamedThreshold kThresholds[] = {{"weightedDeviation", &ContactMetric::weightedDeviation},
										  {"weightedDeviationShare", &ContactMetric::weightedDeviationShare},
										  {"velocity", &ContactMetric::velocity},
										  {"velocityFloor", &ContactMetric::velocityFloor},
										  {"velocityFloorShare", &ContactMetric::velocityFloorShare},
										  {"viewPixels", &ContactMetric::viewPixels},
										  {"maxError", &ContactMetric::maxError},
										  {"maxErrorShare", &ContactMetric::maxErrorShare}};

// Which metrics set s0.
unsigned usedMetrics(const ContactMetric& m)
{
	const bool size = m.weightedDeviation < kOff || m.weightedDeviationShare < kOff;
	return unsigned(size) | unsigned(m.velocity < kOff) << 1 | unsigned(m.viewPixels < kOff) << 2 |
		   unsigned(bool(m.own)) << 3;
}

std::shared_ptr<const ContactThreshold> smaller(const std::shared_ptr<const ContactThreshold>& a,
												const std::shared_ptr<const ContactThreshold>& b)
{
	if (!a || !b || a == b) return a ? a : b;
	const auto both = [a, b](const ContactPlace& place)
	{
		const double ofA = (*a)(place), ofB = (*b)(place);
		return ofA >= 0 && ofB >= 0 ? std::min(ofA, ofB) : 0;
	};
	return std::make_shared<const ContactThreshold>(both);
}

std::string cameraError(const ViewCamera& camera)
{
	if (!isFinite(camera.eye)) return "camera.eye is not finite";
	if (!(camera.fieldOfView > 0 && camera.fieldOfView < kPi))
		return "camera.fieldOfView is " + std::to_string(camera.fieldOfView) + ", but must be between 0 and pi";
	if (!(camera.imageHeight > 0 && std::isfinite(camera.imageHeight)))
		return "camera.imageHeight is " + std::to_string(camera.imageHeight) + ", but must be > 0 and finite";
	if (!(camera.nearDistance >= 0 && std::isfinite(camera.nearDistance)))
		return "camera.nearDistance is " + std::to_string(camera.nearDistance) + ", but must be >= 0 and finite";
	return {};
}
}  // namespace

ContactMetric stricter(const ContactMetric& a, const ContactMetric& b)
{
	ContactMetric metric;
	metric.exact = a.exact || b.exact;
	for (const auto& [name, value] : kThresholds) metric.*value = std::min(a.*value, b.*value);
	// The floor of a metric that is not used does not count.
	const ContactMetric &floorA = a.velocity < kOff ? a : b, &floorB = b.velocity < kOff ? b : a;
	metric.velocityFloor = std::min(floorA.velocityFloor, floorB.velocityFloor);
	metric.velocityFloorShare = std::min(floorA.velocityFloorShare, floorB.velocityFloorShare);
	metric.own = smaller(a.own, b.own);
	// max(min(a1, b1), min(a2, b2)) <= min(max(a1, a2), max(b1, b2)) needs both terms on both sides.
	const bool relaxed =
		a.combine == Combine::kRelaxed && b.combine == Combine::kRelaxed && usedMetrics(a) == usedMetrics(b);
	metric.combine = relaxed ? Combine::kRelaxed : Combine::kStrict;
	return metric;
}

Metric resolve(const ContactMetric& from, const MetricFrame& frame)
{
	Metric metric;
	metric.exact = from.exact;
	metric.combine = from.combine;
	metric.weightedDeviation = std::min(from.weightedDeviation * frame.userLength, from.weightedDeviationShare * frame.radius);
	metric.maxError = std::min(from.maxError * frame.userLength, from.maxErrorShare * frame.radius);
	if (from.velocity < kOff)
	{
		metric.velocity.time = from.velocity * frame.motion.timeStep;
		metric.velocity.floor = std::min(from.velocityFloor * frame.userLength, from.velocityFloorShare * frame.radius);
		metric.velocity.linear = frame.motion.linear;
		metric.velocity.angular = frame.motion.angular;
	}
	if (from.viewPixels < kOff && frame.camera)
	{
		const ViewCamera& camera = *frame.camera;
		metric.view.pixels = from.viewPixels;
		metric.view.eye = (1 / frame.scale) * (inverse(frame.worldFromA) * camera.eye);
		metric.view.pixelSize = 2 * std::tan(0.5 * camera.fieldOfView) / camera.imageHeight;
		metric.view.nearest = camera.nearDistance / frame.scale;
	}
	return metric;
}

ContactPlace inWorld(const Place& place, const MetricFrame& frame)
{
	return {frame.worldFromA * (frame.scale * place.center), frame.scale * place.radius,
			frame.scale * (frame.worldFromA.rotation * frame.motion.velocity(place.center))};
}

std::string contactMetricError(const ContactMetric& metric, const ViewCamera* camera)
{
	for (const auto& [name, value] : kThresholds)
		if (!(metric.*value >= 0)) return std::string(name) + " is " + std::to_string(metric.*value) + ", but must be >= 0";
	if (metric.velocity < kOff && std::min(metric.velocityFloor, metric.velocityFloorShare) == kOff)
		return "velocityFloor and velocityFloorShare are both infinite, but velocity is set";
	if (metric.own && !*metric.own) return "own is an empty function";
	if (metric.viewPixels == kOff) return {};
	return camera ? cameraError(*camera) : "viewPixels is set, but there is no camera";
}
}  // namespace clod
