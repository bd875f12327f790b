// SPDX-License-Identifier: Zlib
// Accuracy against time of all methods on one sample of poses, in one run.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "demos/peers/ClodPeer.h"
#include "demos/peers/Pareto.h"

namespace clod::demo
{
// A family that could not be measured, and why.
struct LeftOut
{
	std::string what, reason;
};

struct Tradeoff
{
	double radius = 0;  // the smaller one: unit of every percentage
	double tolerance = 0, floor = 0;
	std::size_t rows = 0;
	int passes = 0;
	std::vector<TradeoffPoint> points;
	std::vector<LeftOut> leftOut;
};

// Passes are outermost: in each, every method answers once, so that a change of the machine's speed meets all of them.
// Dispatches are timed once more with the bodies at rest.
// A method that fails is left out, with its reason.
void measure(Tradeoff& tradeoff, std::vector<PeerPointer>& peers, const ExactSample& sample, int passes,
			 const std::function<void(double)>& progress);

std::string formatPoints(const Tradeoff& tradeoff);                                      // csv
std::string formatPareto(const Tradeoff& tradeoff, const std::vector<ParetoRow>& rows);  // csv
std::string printable(const Tradeoff& tradeoff, const std::vector<ParetoRow>& rows);     // tables for people
nlohmann::ordered_json toJson(const Tradeoff& tradeoff, const std::vector<ParetoRow>& rows);

// A point of a peer's front is answered when one of ours is this many times faster, no less exact.
inline constexpr double kWantedFactor = 2;

// The plot as PNG by gnuplot. False: gnuplot is not installed or failed.
bool plot(const Tradeoff& tradeoff, const std::string& title, const std::string& path);
}  // namespace clod::demo
