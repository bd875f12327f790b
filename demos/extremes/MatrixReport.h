// SPDX-License-Identifier: Zlib
// The matrix in words, as csv, as json, and as a picture.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "demos/extremes/Matrix.h"

namespace clod::demo
{
// A line a number. The same for every run on one machine.
std::string formatCsv(const Matrix& matrix);
// Members rows[] (with quantities[] and cells[]), limits[], outside[], needless_limits[], tested_elsewhere[], counts.
void addToReport(nlohmann::ordered_json& report, const Matrix& matrix);
// A line a quantity: the worst of each collider; then limits, and what is outside.
std::string printable(const Matrix& matrix);
// SVG: for each axis (step, speed, size, ...) who holds where; beside it every row.
std::string validityMap(const Matrix& matrix);
}  // namespace clod::demo
