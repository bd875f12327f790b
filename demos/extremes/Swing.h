// SPDX-License-Identifier: Zlib
// Swings of a stage's body: their period by closed form and as seen, and what becomes of their amplitude.
#pragma once
#include <functional>

#include "demos/extremes/Stage.h"

namespace clod::demo
{
// Of a pendulum of any amplitude, by the arithmetic-geometric mean of 1 and cos(amplitude / 2). `smallRate` is that of
// small swings, in radians a second.
double swingPeriod(double smallRate, double amplitude);

struct Swing
{
	double period;  // the mean; NaN where it did not come back
	double growth;  // of the amplitude, from the first period to the last: 0 is none
};
// Watches so many periods of the expected length.
Swing watchSwing(Stage& stage, double expected, int periods, const std::function<double()>& angle);
}  // namespace clod::demo
