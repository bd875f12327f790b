// SPDX-License-Identifier: Zlib
// How coarse the contacts of a pair may be, as a user of an engine states it: thresholds as lengths or as shares of the
// pair's smaller bounding radius, for a world, a shape or a pair. resolve() turns it into the query's Metric for one
// step.
//
// Thresholds are in the hierarchies' unit (before any shape scaling; if two bodies are scaled differently, in the unit
// of the one that is scaled less). The camera and the place given to a function of the user are in world lengths.
// Infinity (kOff) means that a metric is not used; if none is used, the coarsest contact level answers. Metric.h
// defines each metric and its special cases.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "clod/Export.h"
#include "clod/collide/RelativeMotion.h"
#include "clod/query/Metric.h"

namespace clod
{
// The camera of the view metric, in world lengths.
struct ViewCamera
{
	Vec3 eye;
	double fieldOfView = 1;   // of the image's height, radians, in (0, pi)
	double imageHeight = 0;   // pixels, > 0
	double nearDistance = 0;  // >= 0: contacts that are closer count as this far
};

// Where a contact may be: a ball in the world. In world lengths, and world lengths per second.
struct ContactPlace
{
	Vec3 center;
	double radius = 0;
	Vec3 velocity;  // of the pair's first body (the one whose content hashes lower) relative to the second, at the
					// centre
};
// Returns the smallest threshold anywhere in the place, as a share of the pair's smaller bounding radius; infinity
// means no demand. Negative values and NaN count as 0. It is called for many places in a dispatch, possibly by several
// threads at once. Results repeat only if it depends on the place alone.
using ContactThreshold = std::function<double(const ContactPlace&)>;

struct CLOD_API ContactMetric
{
	bool exact = false;               // the input surface only
	double weightedDeviation = kOff;  // size metric: the paper's s0, a length
	double weightedDeviationShare = kOff;
	double velocity = kOff;             // k: s0 = k |v_rel| dt, at least the floor
	double velocityFloor = kOff;        // a length; the smaller of both floors counts
	double velocityFloorShare = 0.001;  // a share of the radius
	double viewPixels = kOff;           // N: needs a camera
	std::shared_ptr<const ContactThreshold> own;
	Combine combine = Combine::kStrict;
	double maxError = kOff;  // certified, a hard limit under every combination; a length
	double maxErrorShare = kOff;

	static ContactMetric exactly() { return with(&ContactMetric::exact, true); }
	// The paper's s0 as a share of the radius, e.g. 0.035.
	static ContactMetric deviationShare(double share) { return with(&ContactMetric::weightedDeviationShare, share); }
	// Certified, e.g. 0.005.
	static ContactMetric errorShare(double share) { return with(&ContactMetric::maxErrorShare, share); }
	static ContactMetric velocityFactor(double k) { return with(&ContactMetric::velocity, k); }       // e.g. 0.3
	static ContactMetric viewError(double pixels) { return with(&ContactMetric::viewPixels, pixels); }  // e.g. 1
	static ContactMetric ownThreshold(ContactThreshold threshold)
	{
		return with(&ContactMetric::own, std::make_shared<const ContactThreshold>(std::move(threshold)));
	}

private:
	template <class Field, class Value>
	static ContactMetric with(Field ContactMetric::*field, Value value)
	{
		ContactMetric metric;
		metric.*field = std::move(value);
		return metric;
	}
};

// A metric that is never coarser than either: each threshold is the smaller of both, and it is exact if either is. It
// is relaxed only if both are and use the same metrics.
CLOD_API ContactMetric stricter(const ContactMetric& a, const ContactMetric& b);

// What resolving a metric needs of a pair in a step. Frame A of the query; camera may be null.
struct MetricFrame
{
	double radius = 1;      // the smaller bounding radius, hierarchy unit
	double scale = 1;       // world lengths a hierarchy unit
	double userLength = 1;  // hierarchy units a length of the metric's: not 1 where bodies of different scales meet
	Transform worldFromA;   // translation in world lengths
	RelativeMotion motion;  // as the bodies move now, hierarchy unit; its time step is dt
	const ViewCamera* camera = nullptr;
};
CLOD_API Metric resolve(const ContactMetric& from, const MetricFrame& frame);
// The place of the query in the world, for an own function.
CLOD_API ContactPlace inWorld(const Place& place, const MetricFrame& frame);

// Empty, or one sentence that names the first field that cannot be used and its value: a number that is NaN or
// negative, or a view metric whose camera is missing or has no field of view or resolution.
CLOD_API std::string contactMetricError(const ContactMetric& metric, const ViewCamera* camera);
}  // namespace clod
