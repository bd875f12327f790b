// SPDX-License-Identifier: Zlib
// Two bodies that are apart: how much they may move before they have to be looked at again. The front's own bounds cannot
// tell, as some boxes are always just beyond the tolerance: the nearest pair is searched (NearestPair.h).
#pragma once
#include "clod/query/InsideTest.h"
#include "clod/query/NearestPair.h"
#include "clod/query/Query.h"
#include "clod/query/SafeMotion.h"

namespace clod
{
// What of the pair is asked for besides contacts: later answers of another kind need another search.
struct AskedGap
{
	bool isAsked = false;
	bool isAskedApart = false;  // at any separation: nothing is left out then, however far apart the bodies are
	double error = kOff;        // GapSettings::gapError
	bool operator==(const AskedGap& other) const { return isAsked == other.isAsked && error == other.error; }
};

class SeparationCache
{
public:
	void forget() { *this = SeparationCache{}; }

	// Nothing is near still: not at these settings, nor at thresholds such as theirs, from where the search was made to
	// this pose, whatever the way between.
	bool holds(const QueryContext& context, const ContactSettings& settings, const AskedGap& gap);
	// What a gap's bound adds to the tolerance while it holds.
	double largestCover() const { return m_largestCover; }

	// After a traversal that found nothing. lastMove: motion and change of the sweep since the query before.
	struct Tools
	{
		NearestPair& nearest;
		InsideProbes &probesA, &probesB;
		QueryStats& stats;
		const WorkLimit& limit;
	};
	void seek(const QueryContext& context, const StopRule& rule, const ContactSettings& settings, const AskedGap& gap,
			  double lastMove, const Tools& tools);

private:
	double motionToGo(const QueryContext& context, const StopRule& rule, const ContactSettings& settings,
					  const AskedGap& gap, double cap, const Tools& tools);
	bool isWithinThresholds(const QueryContext& context, const Metric& metric) const;
	bool isMeantFor(const ContactSettings& settings, const AskedGap& gap) const;

	ContactSettings m_settings;
	AskedGap m_gap;
	RelativePose m_pose;
	SafeMotion m_motion;  // from there
	ThresholdRange m_thresholds{0, 0};
	double m_largestCover = 0;
};
}  // namespace clod
