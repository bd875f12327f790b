// SPDX-License-Identifier: Zlib
// Pictures drawn by gnuplot, where it is installed.
#pragma once
#include <string>

namespace clod::demo
{
// What every script of ours starts with: a white PNG of this size in the project's font.
std::string pngTerminal(int width, int height);
// Runs a script whose output is set to `path`; the picture appears whole or not at all. False where gnuplot is missing
// or fails. Throws cli::Failure (1) where files cannot be written.
bool drawPlot(const std::string& script, const std::string& path);
}  // namespace clod::demo
