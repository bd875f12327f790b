// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <vector>

namespace clod::builder
{
// What a repair did, a sentence each, in the order it was done.
using Changes = std::vector<std::string>;
}  // namespace clod::builder
