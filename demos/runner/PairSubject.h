// SPDX-License-Identifier: Zlib
// Two bodies at recorded poses, as the commands that compare methods take them: a scene, which is simulated in exact
// mode, or two models and POSES.csv, or none.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cli/Length.h"
#include "cli/Progress.h"
#include "demos/peers/Roster.h"

namespace CLI
{
class App;
}

namespace clod::demo
{
constexpr double kDefaultTolerance = 0.01;  // share of the smaller radius

struct PairInput
{
	std::vector<std::string> words;  // SCENE, or A B [POSES.csv]
	std::optional<cli::Length> tolerance;
	std::vector<std::string> bodies;  // of a scene of more than two: the names of the pair
	double resolution = 1;
	double dt = 0;  // 0: the scene's, else 1/240
	int steps = 0;  // 0: the scene's
};
// INPUT, --tolerance, --resolution, --steps, --pair and --dt.
void addPairInput(CLI::App& command, PairInput& input);

struct PairSubject
{
	std::string title;
	RosterModels models;
	std::vector<PoseRow> poses;
	double tolerance = 0;
	RowClock clock;
	double worldScale = 0;
};
// Throws cli::Failure: usage (2), bad input (3), and what building and simulating can meet.
PairSubject pairSubject(const PairInput& input, HierarchyCache& cache, cli::Progress& progress);
}  // namespace clod::demo
