// SPDX-License-Identifier: Zlib
// The trial as a film: every contender's run at the same moments, its cost and its errors running; and single frames of
// the moments at which each was worst.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "demos/render/Image.h"
#include "demos/trial/Trial.h"

namespace clod::demo
{
struct TrialPictures
{
	std::vector<std::string> files;  // sheet and film, where ffmpeg exists
	std::string film;                // empty: there is none
	std::vector<std::string> worst;  // one a contender, PNG; empty for those without a frame
};
struct FilmRules
{
	int width = 640;        // of a panel, pixels
	int supersampling = 2;  // see Renderer
	double framesPerSecond = 30;
};
TrialPictures paintTrial(const Trial& trial, const std::string& directory, const FilmRules& rules,
						 const std::function<void(double)>& progress);
}  // namespace clod::demo
