// SPDX-License-Identifier: Zlib
// How far an answer is from the exact one at the same pose: error of the gap and of normals, and coverage both ways.
// Frame, signs and unit as in Peer.h.
#pragma once
#include <vector>

#include "demos/peers/Peer.h"

namespace clod::demo
{
struct AccuracyRules
{
	double tolerance = 0;    // contacts were asked for up to this distance
	double near = 0;         // contacts within this distance of each other support the same part of a body
	double place = 0;        // within this distance they are at the same place: its exact normals may all be meant
	double cosine = 0.9397;  // of 20 degrees: normals that agree better say the same
	double rounding = 0;     // slack of "within its bound"
};
inline constexpr double kNearShare = 0.1;       // of the smaller radius: about as close as support points need to be
inline constexpr double kPlaceShare = 0.02;     // of the smaller radius
inline constexpr double kRoundingShare = 1e-6;  // of the smaller radius: float storage of dispatched points

// The truth at one pose: the signed gap, and every exact contact up to the tolerance plus the largest promised bound.
struct ExactRow
{
	double gap = 0;
	std::vector<PeerContact> contacts;
};

struct RowAccuracy
{
	bool missed = false;  // nothing reported within the tolerance; the gap's error is then what is left to it
	double gapError = 0;  // |reported - exact|; inf: the answer leaves the gap open
	double normalError;  // degrees: median over the reported contacts of the smallest angle to an exact one at the same
	// place (to the nearest one where there is none so close); 90 where none is near or the contact
	// has no normal; NaN: nothing reported
	double covered;  // share of the exact contacts within half the tolerance that have a reported one near, with
					 // an agreeing normal; NaN: there are none
	double founded;  // share of the reported contacts within the tolerance that have an exact one near, no farther
					 // apart than the promised bound (the tolerance where none is promised) allows; NaN: none
	std::size_t contacts = 0;  // reported within the tolerance
};
RowAccuracy compare(const ExactRow& exact, const PeerAnswer& answer, const AccuracyRules& rules);

// Over all rows; quantiles ignore NaN.
struct Accuracy
{
	double gapMedian = 0, gapP95 = 0, gapMax = 0;
	double normalMedian = 0, normalP95 = 0;
	double coveredMean = 0, coveredLow = 0;  // mean and 5 % quantile
	double foundedMean = 0;
	double contactsMedian = 0;
	double missedShare = 0;
};
Accuracy summarize(const std::vector<RowAccuracy>& rows);
}  // namespace clod::demo
