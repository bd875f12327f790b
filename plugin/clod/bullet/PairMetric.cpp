// SPDX-License-Identifier: Zlib
#include "clod/bullet/PairMetric.h"

#include <utility>

namespace clod
{
namespace
{
constexpr double kParting = 0.01;   // of the length, a second
constexpr double kSameTime = 1e-6;  // of the way: Bullet tells it in floats

// Precedence: the pair callback if it answers, else the stricter of the shapes' own metrics, else the world's.
ContactMetric chosenMetric(const Context& context, const PairPose& pose, const ViewCamera* camera, std::string& error)
{
	ContactMetric answer;
	if (context.pairMetric && context.pairMetric(*pose.a->getCollisionObject(), *pose.b->getCollisionObject(), answer))
	{
		error = contactMetricError(answer, camera);
		return answer;
	}
	const std::optional<ContactMetric>& ofA = pose.shapeA->metric();
	const std::optional<ContactMetric> ofB = pose.shapeB ? pose.shapeB->metric() : std::nullopt;
	const ContactMetric& first = ofA ? *ofA : ofB ? *ofB : context.worldMetric;
	error = contactMetricError(first, camera);
	if (!ofA || !ofB) return first;
	if (error.empty()) error = contactMetricError(*ofB, camera);
	return stricter(first, *ofB);
}
}  // namespace

PairMetric::PairMetric()
	: m_own([this](const Place& place) { return (*m_ownThreshold)(inWorld(place, m_frame)) * m_frame.radius; })
{
}

Metric PairMetric::resolve(const Context& context, const PairPose& pose)
{
	if (m_held) return m_held->metric;
	m_frame.radius = pose.rules.length;
	m_frame.scale = pose.scale();
	m_frame.userLength = pose.userLength();
	m_frame.worldFromA = pose.worldFromA;
	m_frame.motion = pose.seenMotion;
	m_frame.camera = context.camera ? &*context.camera : nullptr;
	const ContactMetric chosen = chosenMetric(context, pose, m_frame.camera, m_error);
	Metric metric;
	if (m_error.empty()) m_error = metricError(metric = clod::resolve(chosen, m_frame));
	m_ownThreshold = chosen.own;
	if (m_error.empty() && chosen.own) metric.own = &m_own;
	if (m_error.empty()) return metric;
	metric = Metric{};
	metric.exact = true;
	return metric;
}

void PairMetric::hold(const Metric& metric, const SwitchImpact& impact)
{
	m_held = std::make_unique<Held>();
	m_held->metric = metric;
	m_held->impact = impact;
}

void PairMetric::dropAfter(double share)
{
	if (m_held && m_held->isPending && m_held->impact.share > share + kSameTime) letGo();
}

double PairMetric::goOnHolding(const PairPose& pose, PairCache& cache)
{
	if (!m_held) return 0;
	Held& held = *m_held;
	const Separation now = separationOf(pose, pose.aFromB, held.metric, held.impact.parted, cache);
	// Not by how the separation grows, which overlaps that are corrected make grow, too.
	const double speed = dot(pose.seenMotion.velocity(now.point), now.normal);
	if (!held.isPending && (!(speed > kParting * pose.rules.length) || now.distance >= held.impact.parted))
	{
		letGo();
		return 0;
	}
	if (std::exchange(held.isPending, false)) held.touching = now.distance;
	return held.touching;
}
}  // namespace clod
