// SPDX-License-Identifier: Zlib
// clod-bench: the headless benchmark runner.
#include <CLI/CLI.hpp>

#include "cli/Program.h"
#include "demos/runner/Commands.h"

int main(int argc, char** argv)
{
	CLI::App app("Contact levels of detail: models, scenes and measurements", CLOD_PROGRAM_NAME);
	clod::cli::setUpProgram(app, CLOD_BULLET_PRECISION_NAME " (Bullet)",
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
