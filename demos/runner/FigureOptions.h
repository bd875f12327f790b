// SPDX-License-Identifier: Zlib
// What every figure of clod-bench paper is asked for.
#pragma once
#include <functional>
#include <string>

namespace clod::demo
{
struct FigureOptions
{
	std::string directory;  // exists
	double resolution = 1;
	int steps = 0;  // 0: the scene's
};
using FigureProgress = std::function<void(const std::string& phase, double fraction)>;
}  // namespace clod::demo
