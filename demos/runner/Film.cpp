// SPDX-License-Identifier: Zlib
// Frames into files, a sheet and a film.
#include "demos/runner/Film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "cli/Files.h"
#include "cli/Program.h"
#include "demos/runner/Process.h"

namespace clod::demo
{
namespace
{
// A sheet as wide as a screen, so that its text is read as it is: two frames a row, or one of several panels.
constexpr std::size_t kSheetCells = 6;
constexpr int kSheetWidth = 1960;

int sheetColumns(const Image& frame)
{
	return frame.width > 2 * frame.height ? 1 : 2;
}

void write(const std::string& path, const Image& image, const std::string& title)
{
	const Result<std::size_t> bytes = writePng(path, image, {{"Title", title}});
	if (!bytes) throw cli::Failure(cli::ExitCode::failure, bytes.error());
}
}  // namespace

int frameEvery(int steps, double dt)
{
	constexpr double kFramesPerSecond = 30;
	constexpr int kFewestFrames = 150;
	return std::max(1, std::min(int(std::lround(1 / (kFramesPerSecond * dt))), steps / kFewestFrames));
}

FrameFolder::FrameFolder(std::string directory, std::string title, std::size_t expected, double framesPerSecond)
	: m_directory(std::move(directory)),
	  m_title(std::move(title)),
	  m_expected(expected),
	  m_framesPerSecond(framesPerSecond)
{
	std::error_code error;
	std::filesystem::create_directories(m_directory, error);
	if (error)
		throw cli::Failure(cli::ExitCode::failure, fmt::format("cannot create {}: {}", m_directory, error.message()));
}

void FrameFolder::add(const Image& image, const std::string& caption)
{
	write(path(fmt::format("frame-{:04}.png", m_count)), image, m_title + ", " + caption);
	// The cells are spread evenly, the last frame among them.
	const std::size_t cell = m_cells.size();
	const bool wanted = m_expected <= kSheetCells || m_count * (kSheetCells - 1) >= cell * (m_expected - 1);
	if (wanted && cell < kSheetCells)
	{
		const int width = std::min(image.width, kSheetWidth / sheetColumns(image));
		m_cells.push_back({resized(image, width, width * image.height / image.width), caption});
	}
	++m_count;
}

bool FrameFolder::makeFilm() const
{
	cli::PartialFile film(path("film.mp4"));
	const int code = runProgram({"ffmpeg", "-loglevel", "error", "-nostdin", "-y", "-framerate",
								 fmt::format("{:.6g}", m_framesPerSecond), "-i", path("frame-%04d.png"), "-frames:v",
								 std::to_string(m_count), "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
								 film.temporaryPath()});
	return code == 0 && film.commit().empty();
}

std::vector<std::string> FrameFolder::finish()
{
	std::vector<std::string> files;
	if (m_cells.empty()) return files;
	files.push_back(path("contact-sheet.png"));
	write(files.back(), contactSheet(m_cells, sheetColumns(m_cells.front().image), 0, m_title), m_title);
	if (makeFilm()) files.push_back(path("film.mp4"));
	return files;
}
}  // namespace clod::demo
