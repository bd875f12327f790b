// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/ReadMesh.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "cli/MeshPath.h"

namespace clod::builder
{
namespace
{
std::string readBytes(const std::string& path)
{
	std::error_code error;
	const auto status = std::filesystem::status(path, error);
	if (error || !std::filesystem::exists(status)) throw Refused(Reason::unreadable, fmt::format("no file {}", path));
	if (!std::filesystem::is_regular_file(status))
		throw Refused(Reason::unreadable, fmt::format("{} is not a regular file", path));
	const auto size = std::filesystem::file_size(path, error);
	if (!error && size > kFileLimit)
		throw Refused(Reason::limit, fmt::format("{} has {} bytes; the limit is {}", path, size, kFileLimit));
	std::ifstream file(path, std::ios::binary);
	std::string bytes(error ? 0 : std::size_t(size), '\0');
	file.read(bytes.data(), std::streamsize(bytes.size()));
	if (error || !file) throw Refused(Reason::unreadable, fmt::format("cannot read {}", path));
	return bytes;
}

Soup readFile(const std::string& path)
{
	const std::string ending = cli::endingOf(path);
	if (const std::string problem = cli::notAMesh(path); !problem.empty()) throw Refused(Reason::unreadable, problem);
	const std::string content = readBytes(path);
	if (ending == ".stl") return parseStl(content);
	const std::string_view bytes = withoutByteOrderMark(content);
	if (ending == ".obj") return parseObj(bytes);
	if (ending == ".off") return parseOff(bytes);
	if (ending == ".ply") return parsePly(bytes);
	return parseGltf(bytes, std::filesystem::path(path).parent_path().string());
}
}  // namespace

std::string_view withoutByteOrderMark(std::string_view text)
{
	constexpr std::string_view kMark = "\xef\xbb\xbf";
	return text.substr(text.substr(0, kMark.size()) == kMark ? kMark.size() : 0);
}

Soup readMesh(const std::string& path)
{
	const cli::MeshPath mesh = cli::meshPath(path);
	Soup soup = readFile(mesh.file);
	return mesh.part.empty() ? soup : partOf(soup, mesh.part);
}
}  // namespace clod::builder
