// SPDX-License-Identifier: Zlib
// Figure 4 of Otaduy & Lin 2003: query time and front size over the simulation of the spoon in the cup, exact and at
// three thresholds; beside it how many contact pairs come and go, and the same figures by regime.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "demos/runner/FigureOptions.h"
#include "demos/runner/HierarchyCache.h"

namespace clod::demo
{
// Simulates spoon-cup with exact contacts, replays its poses under every selection, ours and the paper's (hierarchies
// built with --paper), and writes figure4.csv, figure4.txt and, where gnuplot is installed, figure4.png. Value: the
// figures by regime and the files written, for the report.
nlohmann::ordered_json makeFigure4(const FigureOptions& options, HierarchyCache& cache, const FigureProgress& progress);
}  // namespace clod::demo
