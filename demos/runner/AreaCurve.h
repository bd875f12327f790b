// SPDX-License-Identifier: Zlib
// Query time over contact area at fixed resolution (Otaduy & Lin 2003, sec. 3.1: levels of detail should keep the cost
// nearly constant): a nut is screwed onto a bolt, exact and at three thresholds.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "demos/runner/FigureOptions.h"
#include "demos/runner/HierarchyCache.h"

namespace clod::demo
{
// Records the scene contact-area, replays it under every selection, and writes area.csv, area.txt and, where gnuplot is
// installed, area.png. Area: the pairs of patches in contact in exact mode. Value: medians of equal parts of the area,
// what they grow by from the first part to the last, and the files written.
nlohmann::ordered_json makeAreaCurve(const FigureOptions& options, HierarchyCache& cache,
									 const FigureProgress& progress);
}  // namespace clod::demo
