// SPDX-License-Identifier: Zlib
// The selection flags that run and replay share: how coarse a contact may be answered.
#pragma once
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "clod/query/ContactMetric.h"
#include "demos/cli/Length.h"

namespace clod::demo
{
struct Selection
{
	bool exact = false, paper = false, fresh = false;
	std::optional<cli::Length> s0, size, maxError;
	std::string combine = "strict";
};

// Where nothing is selected: certified error, as a share of the radius.
inline constexpr double kDefaultMaxError = 0.005;

// Adds --exact --s0 --size --max-error --combine --paper --fresh, and those that are refused as not available yet.
void addSelection(CLI::App& command, Selection& selection);

// The metric, and for a pair whose smaller bounding radius is `radius` the same in words.
ContactMetric toMetric(const Selection& selection);
std::string describe(const Selection& selection, double radius);
nlohmann::ordered_json toJson(const Selection& selection, double radius);
}  // namespace clod::demo
