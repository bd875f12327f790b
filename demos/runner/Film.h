// SPDX-License-Identifier: Zlib
// A folder of frames with its contact sheet and, where ffmpeg exists, a film.
#pragma once
#include <string>
#include <vector>

#include "demos/render/Overlay.h"

namespace clod::demo
{
// Steps between frames of a film that lasts as long as what it shows: 30 frames a second, more where those would be
// fewer than 150.
int frameEvery(int steps, double dt);

class FrameFolder
{
public:
	// Creates the folder; throws cli::Failure (1) where that fails. `expected` frames will be added, of which the film
	// shows so many a second.
	FrameFolder(std::string directory, std::string title, std::size_t expected, double framesPerSecond);
	void add(const Image& image, const std::string& caption);
	// contact-sheet.png, and film.mp4 where ffmpeg exists. Value: the files written, frames not listed.
	std::vector<std::string> finish();
	std::size_t frames() const { return m_count; }

private:
	std::string path(const std::string& name) const { return m_directory + "/" + name; }
	bool makeFilm() const;

	std::string m_directory, m_title;
	std::size_t m_expected, m_count = 0;
	double m_framesPerSecond;
	std::vector<CaptionedImage> m_cells;
};
}  // namespace clod::demo
