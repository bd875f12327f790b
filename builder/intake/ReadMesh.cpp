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
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // before text of some Windows programs

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
	std::string_view bytes = content;
	if (bytes.substr(0, kByteOrderMark.size()) == kByteOrderMark) bytes.remove_prefix(kByteOrderMark.size());
	if (ending == ".obj") return parseObj(bytes);
	if (ending == ".off") return parseOff(bytes);
	if (ending == ".ply") return parsePly(bytes);
	if (ending == ".stl") return parseStl(bytes);
	return parseGltf(bytes, std::filesystem::path(path).parent_path().string());
}
}  // namespace

Soup readMesh(const std::string& path)
{
	const cli::MeshPath mesh = cli::meshPath(path);
	Soup soup = readFile(mesh.file);
	return mesh.part.empty() ? soup : partOf(soup, mesh.part);
}
}  // namespace clod::builder
