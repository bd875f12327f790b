// SPDX-License-Identifier: Zlib
// clod-bench: the headless benchmark runner.
#include <CLI/CLI.hpp>

#include "cli/Program.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Statistics.h"

int main(int argc, char** argv)
{
	const bool isDouble = clod::demo::hasDoublePrecision();
	CLI::App app("Contact levels of detail: models, scenes and measurements", isDouble ? "clod-bench-float64" : "clod-bench");
	clod::cli::setUpProgram(app, isDouble ? "double (Bullet)" : "single (Bullet)",
							"Licence: Zlib. Uses Bullet, CLI11, fmt, nlohmann-json.");
	app.footer("Example: clod-bench run spoon-cup --size 3.5 --frames frames");
	clod::demo::addModelCommand(app);
	clod::demo::addListCommand(app);
	clod::demo::addRunCommand(app);
	clod::demo::addReplayCommand(app);
	clod::demo::addPaperCommand(app);
	clod::demo::addTradeoffCommand(app);
	clod::demo::addIdleCommand(app);
	clod::demo::addBudgetCommand(app);
	clod::demo::addScalingCommand(app);
	clod::demo::addLevelsCommand(app);
	clod::demo::addTryCommand(app);
	clod::demo::addExtremesCommand(app);
	return clod::cli::runProgram(app, argc, argv);
}
