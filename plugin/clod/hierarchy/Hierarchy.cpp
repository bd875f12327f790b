// SPDX-License-Identifier: Zlib
// Reading a hierarchy from disk. Only regular files are opened; the size is known and bounded before a byte is
// allocated.
#include "clod/hierarchy/Hierarchy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "clod/hierarchy/HierarchyFormat.h"

namespace clod
{
namespace
{
Error fileError(const std::string& path, const std::string& what)
{
	return Error{path + ": " + what};
}

// The header alone decides whether the rest is worth reading.
std::string readBlock(std::ifstream& stream, std::uint64_t size, std::vector<std::byte>& bytes)
{
	std::vector<std::byte> start;
	std::string problem = readFileStart(stream, size, start);
	if (!problem.empty()) return problem;
	bytes.resize(std::size_t(size));
	std::copy(start.begin(), start.end(), bytes.begin());
	stream.read(reinterpret_cast<char*>(bytes.data() + start.size()), std::streamsize(bytes.size() - start.size()));
	return stream ? "" : "cannot be read to its end";
}
}  // namespace

std::string readFileStart(std::ifstream& stream, std::uint64_t size, std::vector<std::byte>& start)
{
	start.resize(std::size_t(std::min<std::uint64_t>(size, kFileStartBytes)));
	stream.read(reinterpret_cast<char*>(start.data()), std::streamsize(start.size()));
	return stream ? checkFileStart(start, size) : "cannot be read";
}

Result<std::uint64_t> openFile(const std::string& path, std::ifstream& stream)
{
	std::error_code code;
	const std::filesystem::file_status status = std::filesystem::status(path, code);
	if (status.type() == std::filesystem::file_type::not_found) return fileError(path, "no such file");
	if (code) return fileError(path, "cannot be examined: " + code.message());
	if (status.type() != std::filesystem::file_type::regular) return fileError(path, "is not a regular file");
	const std::uint64_t size = std::filesystem::file_size(path, code);
	if (code) return fileError(path, "has no readable size: " + code.message());
	if (size > kMostBytes)
		return fileError(path, "is " + std::to_string(size) + " bytes; the limit is " + std::to_string(kMostBytes));
	stream.open(path, std::ios::binary);
	if (!stream) return fileError(path, "cannot be opened for reading");
	return size;
}

Result<std::shared_ptr<const Hierarchy>> Hierarchy::load(const std::string& path)
{
	std::ifstream stream;
	const Result<std::uint64_t> size = openFile(path, stream);
	if (!size) return Error{size.error()};
	const auto read = [&]() -> Result<std::shared_ptr<const Hierarchy>>
	{
		std::vector<std::byte> bytes;
		const std::string problem = readBlock(stream, size.value(), bytes);
		if (!problem.empty()) return Error{problem};
		return fromBytes(std::move(bytes));
	};
	Result<std::shared_ptr<const Hierarchy>> result = withinMemory("", read);
	if (!result) return fileError(path, result.error());
	return result;
}

// The root's box and the asset's box enclose everything: their farthest corner from the origin is at R. The corners of
// a box that fits what it encloses along each of its axes are then within sqrt(3) R; load() refuses others.
double Hierarchy::originRadius() const
{
	const OrientedBox& box = cullBox(root());
	const double half = std::sqrt(double(box.half[0]) * box.half[0] + double(box.half[1]) * box.half[1] +
								  double(box.half[2]) * box.half[2]);
	double squared = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double far = std::max(std::abs(asset().boxMin[i]), std::abs(asset().boxMax[i]));
		squared += far * far;
	}
	return 1.7321 * std::max(std::sqrt(squared), length(toVec3(box.center)) + std::max(half, double(box.radius)));
}
}  // namespace clod
