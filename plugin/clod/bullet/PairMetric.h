// SPDX-License-Identifier: Zlib
// Which metric a pair is judged by in one dispatch: the user's thresholds, resolved at the pair's pose.
#pragma once
#include <memory>
#include <string>

#include "clod/bullet/Context.h"
#include "clod/bullet/PairPose.h"

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

private:
	MetricFrame m_frame;
	std::shared_ptr<const ContactThreshold> m_ownThreshold;  // of the user's metric
	OwnThreshold m_own;                                      // the same as the query calls it
	std::string m_error;
};
}  // namespace clod
