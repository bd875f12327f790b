// SPDX-License-Identifier: GPL-3.0-or-later
// clod-build: from mesh to dual hierarchy, and what can be said about one.
#include <CLI/CLI.hpp>

#include "builder/cli/Commands.h"
#include "cli/Program.h"

int main(int argc, char** argv)
{
	CLI::App program{"Builds and examines dual hierarchies (contact levels of detail) of triangle meshes.",
					 "clod-build"};
	clod::cli::setUpProgram(program, "double (no Bullet)",
							"licence GPL-3.0-or-later (links CGAL); the files it writes carry no licence of ours");
	clod::builder::addBuildCommand(program);
	clod::builder::addInfoCommand(program);
	clod::builder::addCheckCommand(program);
	clod::builder::addExportCommand(program);
	clod::builder::addPartsCommand(program);
	program.footer("Example: clod-build build cup.obj -o cup.clod && clod-build info cup.clod");
	return clod::cli::runProgram(program, argc, argv);
}
