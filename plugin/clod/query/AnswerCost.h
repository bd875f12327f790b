// SPDX-License-Identifier: Zlib
// What so many answers will take by the clock, from what was seen lately. Time is not proportional to answers: few
// coarse ones carry the fixed cost of a query, and hulls that overlap cost more than many that do not. So the last time
// seen is kept for each order of magnitude of answers (a factor of 1.4), and between two of them lies a straight line.
// What was seen long ago is forgotten: poses change, and what was too dear once is tried again.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "clod/query/Constants.h"

namespace clod
{
class AnswerCost
{
public:
	// each: microseconds of an answer while nothing was seen.
	explicit AnswerCost(double each) : m_each(each) {}

	void observe(std::uint64_t answers, double microseconds)
	{
		++m_now;
		if (answers > 0) m_seen[bucketOf(double(answers))] = {double(answers), microseconds, m_now};
	}
	double estimate(double answers) const
	{
		const Seen *below = nullptr, *above = nullptr;
		for (const Seen& seen : m_seen)
		{
			if (seen.when == 0 || m_now - seen.when > kRemembered) continue;
			if (seen.answers <= answers)
				below = &seen;
			else if (!above)
				above = &seen;
		}
		if (!below && !above) return m_each * answers;
		if (!above) return below->microseconds * answers / below->answers;
		if (!below) return above->microseconds * answers / above->answers;
		const double share = (answers - below->answers) / (above->answers - below->answers);
		return below->microseconds + share * (above->microseconds - below->microseconds);
	}

private:
	static constexpr std::size_t kBuckets = 64;
	struct Seen
	{
		double answers = 0, microseconds = 0;
		std::uint64_t when = 0;  // 0: never
	};
	static std::size_t bucketOf(double answers)
	{
		return std::min(kBuckets - 1, std::size_t(2 * std::log2(std::max(1.0, answers))));
	}
	Seen m_seen[kBuckets];
	std::uint64_t m_now = 0;
	double m_each;
};
}  // namespace clod
