// SPDX-License-Identifier: Zlib
#include "demos/runner/Gnuplot.h"

#include <fmt/format.h>

#include "cli/Files.h"
#include "cli/Program.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Process.h"

namespace clod::demo
{
std::string pngTerminal(int width, int height)
{
	return fmt::format("set terminal pngcairo size {},{} font \"DejaVu Sans,15\" noenhanced background \"white\"\n",
					   width, height);
}

bool drawPlot(const std::string& script, const std::string& path)
{
	const cli::PartialFile file(temporaryDirectory() + "/clod-plot.gnuplot");  // never committed
	cli::PartialFile picture(path);
	const std::string text = "set output \"" + picture.temporaryPath() + "\"\n" + script;
	if (const std::string problem = cli::writeFile(file.temporaryPath(), text); !problem.empty())
		throw cli::Failure(cli::ExitCode::failure, problem);
	return runProgram({"gnuplot", file.temporaryPath()}) == 0 && picture.commit().empty();
}
}  // namespace clod::demo
