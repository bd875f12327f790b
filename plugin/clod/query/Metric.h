// SPDX-License-Identifier: Zlib
// The error metrics: how coarse a pair of nodes may be and still answer. A pair's weighted deviation s* (StopRule.h)
// must not exceed a threshold s0. Each metric sets an s0; several are combined. Lengths in the hierarchies' unit, frame
// A.
//
//   size      s0 = weightedDeviation                 chosen by the caller
//   velocity  s0 = max(floor, time |v_rel|)          time = k dt: errors are less noticeable on moving bodies
//   view      s0 = pixels max(nearest, l) pixelSize  N pixels seen from distance l (eq. 4: N l f / (n i))
//   own       s0 = own(place)                        the caller's function
//
// Velocity and distance differ from contact to contact. A pair of nodes is judged by its place: the ball around the
// smaller of its two culling boxes, which holds a witness point of any contact it can make. Every metric takes its
// smallest value over the ball, so it holds wherever in the ball the contact is. The place is a function of the two
// nodes and the pose, so what a query visits depends only on pose and settings.
//
// Special cases:
// - If the eye is nearer than `nearest`, l = nearest. With nearest = 0 the threshold can be 0, and contacts exact.
// - l is the distance in any direction, as in the paper, because the camera may turn; it is not the depth along the
//   view axis. Towards the corners of a picture N pixels may show as N / cos(angle off the axis)^2.
// - At rest the velocity metric is its floor.
// - A threshold of the caller's function that is negative or NaN counts as 0.
// - A pair whose contact area is 0 has s* = inf and is refined. One without deviation (f = 0) has s* = 0, whatever its
//   area: 0 / 0 does not occur.
//
// Based on: Otaduy & Lin 2003, sec. 5.2. The paper gives no rule for combining.
#pragma once
#include <algorithm>
#include <functional>
#include <limits>
#include <string>

#include "clod/Export.h"
#include "clod/collide/Vector.h"

namespace clod
{
inline constexpr double kOff = std::numeric_limits<double>::infinity();  // the threshold of a metric that is not used

struct Place
{
	Vec3 center;  // frame A
	double radius = 0;
};

// Returns the smallest s0 that the caller accepts anywhere in the place. While a query runs it must depend on the place
// alone.
using OwnThreshold = std::function<double(const Place&)>;

struct VelocityThreshold
{
	double time = kOff;  // k dt, seconds
	double floor = 0;
	Vec3 linear, angular;  // velocity of A's material relative to B's at p: linear + angular x p
};

struct ViewThreshold
{
	double pixels = kOff;  // N
	Vec3 eye;
	double pixelSize = 0;  // f / (n i): what a pixel covers at distance 1
	double nearest = 0;    // n
};

enum class Combine
{
	kStrict,  // every metric must allow: the smallest s0
	kRelaxed  // one is enough: the largest s0
};

// When may a pair of nodes answer? Evaluated in this order: a pair of level-0 nodes always answers; a
// completion node never does; then s* must not exceed the combined s0, nor the certified error maxError.
struct Metric
{
	bool exact = false;               // level 0 only
	double weightedDeviation = kOff;  // s0 of the size metric
	VelocityThreshold velocity;
	ViewThreshold view;
	const OwnThreshold* own = nullptr;  // not owned; null: not used
	Combine combine = Combine::kStrict;
	double maxError = kOff;  // certified: errorBound <= maxError, a hard limit under every combination
	// >= 1: multiplies every limit above, combined or certified; budgets use it (BudgetControl.h). Once it exceeds 1,
	// limits below kFinestShare of the smaller radius (also exact) count as that share. Infinite, or a certified limit beyond
	// kCoarsestShare: the coarsest answer, of the coarsest levels that err by no more than that share while apart.
	double coarsening = 1;
};
// s0 or a certified limit, coarsened; kOff stays kOff.
inline double coarsened(double limit, const Metric& metric, double finest)
{
	return metric.coarsening > 1 && limit < kOff ? metric.coarsening * std::max(limit, finest) : limit;
}
// Compares field by field; two metrics with a function of the caller's are never the same, for its results may differ.
CLOD_API bool same(const Metric& l, const Metric& r);
// Empty, or one sentence naming the first field that cannot be used, and its value.
CLOD_API std::string metricError(const Metric& metric);

struct ThresholdRange
{
	double least, most;
};

// s0 of a metric at a place.
class Threshold
{
public:
	// fastest: no point of either body moves faster relative to the other. Where even that stays below the floor, the
	// velocity metric is the constant floor. finest: the least that is coarsened.
	explicit Threshold(const Metric& metric, double fastest, double finest = 0)
		: m_metric(metric), m_constant(metric.combine == Combine::kStrict ? kOff : kUnset), m_finest(finest)
	{
		if (metric.weightedDeviation < kOff) add(m_constant, metric.weightedDeviation);
		m_moves = metric.velocity.time < kOff && metric.velocity.time * fastest > metric.velocity.floor;
		if (metric.velocity.time < kOff && !m_moves) add(m_constant, metric.velocity.floor);
		m_isSeen = metric.view.pixels < kOff;
		if (isConstant() && m_constant < 0) m_constant = kOff;
	}

	explicit Threshold(double constant) : m_constant(constant) {}

	bool isConstant() const { return !m_moves && !m_isSeen && !m_metric.own; }
	// Only where isConstant().
	double constant() const { return coarsened(m_constant, m_metric, m_finest); }

	double at(const Place& place) const
	{
		double s0 = m_constant;
		if (m_moves) add(s0, std::max(m_metric.velocity.floor, m_metric.velocity.time * slowest(place)));
		if (m_isSeen)
		{
			const double distance = length(m_metric.view.eye - place.center) - place.radius;
			add(s0, m_metric.view.pixels * std::max(m_metric.view.nearest, distance) * m_metric.view.pixelSize);
		}
		if (m_metric.own)
		{
			const double own = (*m_metric.own)(place);
			add(s0, own >= 0 ? own : 0);
		}
		return coarsened(s0, m_metric, m_finest);
	}

	// All of at() for places within the ball, whatever an own threshold is.
	ThresholdRange within(const Place& ball) const
	{
		ThresholdRange range{m_constant, m_constant};
		const auto addBoth = [&](double least, double most)
		{
			add(range.least, kDown * least);
			add(range.most, kUp * most);
		};
		if (m_moves)
		{
			const VelocityThreshold& v = m_metric.velocity;
			const double fastest = length(v.linear + cross(v.angular, ball.center)) + length(v.angular) * ball.radius;
			addBoth(std::max(v.floor, v.time * slowest(ball)), std::max(v.floor, v.time * fastest));
		}
		if (m_isSeen)
		{
			const ViewThreshold& view = m_metric.view;
			const double distance = length(view.eye - ball.center), share = view.pixels * view.pixelSize;
			addBoth(share * std::max(view.nearest, distance - ball.radius),
					share * std::max(view.nearest, distance + ball.radius));
		}
		if (m_metric.own) addBoth(0, kOff);
		return {coarsened(range.least, m_metric, m_finest), coarsened(range.most, m_metric, m_finest)};
	}

private:
	static constexpr double kUp = 1 + 1e-9, kDown = 1 - 1e-9;  // for rounding
	static constexpr double kUnset = -1;

	void add(double& s0, double other) const
	{
		s0 = m_metric.combine == Combine::kStrict ? std::min(s0, other) : std::max(s0, other);
	}
	double slowest(const Place& place) const
	{
		const VelocityThreshold& v = m_metric.velocity;
		return std::max(0.0, length(v.linear + cross(v.angular, place.center)) - length(v.angular) * place.radius);
	}

	Metric m_metric;
	double m_constant;  // of the metrics that do not depend on the place
	double m_finest = 0;
	bool m_moves = false, m_isSeen = false;
};
}  // namespace clod
