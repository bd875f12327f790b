// SPDX-License-Identifier: Zlib
// What a trial found, as one self-contained page, as a machine-readable report, and in a few lines for the terminal.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "demos/trial/Trial.h"
#include "demos/trial/TrialFilm.h"

namespace clod::demo
{
std::string reportPage(const Trial& trial, const TrialPictures& pictures);
void addToReport(nlohmann::ordered_json& report, const Trial& trial);
std::string printable(const Trial& trial);
}  // namespace clod::demo
