// SPDX-License-Identifier: Zlib
#include "clod/bullet/PairMetric.h"

namespace clod
{
namespace
{
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
}  // namespace clod
