// SPDX-License-Identifier: Zlib
// Who runs the trial's scene: ours at its default, and what users of Bullet have.
#pragma once
#include "demos/peers/Preparation.h"
#include "demos/trial/Trial.h"

namespace clod::demo
{
// Appends to the trial's contenders, and says of those that cannot take part why (Trial::leftOut).
void addContenders(Trial& trial, const Preparation& preparation,
				   const std::function<void(const std::string&, double)>& progress);
}  // namespace clod::demo
