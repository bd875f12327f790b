// SPDX-License-Identifier: Zlib
// Which metric a pair is judged by in one dispatch: the user's thresholds, resolved at the pair's pose.
#pragma once
#include <memory>
#include <string>

#include "clod/bullet/Context.h"
#include "clod/bullet/PairPose.h"
#include "clod/bullet/TimeOfImpact.h"

namespace clod
{
class PairMetric
{
public:
	PairMetric();
	PairMetric(const PairMetric&) = delete;
	PairMetric& operator=(const PairMetric&) = delete;

	// A metric that cannot be used makes the pair exact; error() then tells why. Valid until the next call.
	Metric resolve(const Context& context, const PairPose& pose);
	const std::string& error() const { return m_error; }

	// After a SwitchImpact resolve() keeps to the levels that were used, whose surfaces count as touching from then on.
	// It does so while the bodies part, until the finer levels are apart, too: what these find before is no impact.
	// Bodies that do not part are let down onto the finer levels as after any other change.
	void hold(const Metric& metric, const SwitchImpact& impact);
	// Of those just held, before any dispatch.
	void dropAfter(double share);
	bool holds() const { return m_held != nullptr; }
	void letGo() { m_held.reset(); }
	// At the pose of a dispatch to come: lets go where that is over. Returns how far apart surfaces count as touching.
	double goOnHolding(const PairPose& pose, PairCache& cache);

private:
	struct Held
	{
		Metric metric;
		SwitchImpact impact;
		bool isPending = true;  // there was no dispatch since
		double touching = 0;
	};
	std::unique_ptr<Held> m_held;
	MetricFrame m_frame;
	std::shared_ptr<const ContactThreshold> m_ownThreshold;  // of the user's metric
	OwnThreshold m_own;                                      // the same as the query calls it
	std::string m_error;
};
}  // namespace clod
