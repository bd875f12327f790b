// SPDX-License-Identifier: Zlib
// Files that appear whole or not at all: written aside in the same directory, flushed, then renamed.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <clod/hierarchy/Result.h>

namespace clod::cli
{
// A file being written aside. Destroyed without commit(), or interrupted (see Program.h), it leaves nothing behind.
class PartialFile
{
public:
	explicit PartialFile(std::string path);
	PartialFile(const PartialFile&) = delete;
	PartialFile& operator=(const PartialFile&) = delete;
	~PartialFile();
	// Where to write. Exists only once the caller created it.
	const std::string& temporaryPath() const { return m_temporary; }
	// Renames onto the final path; empty on success, otherwise the reason.
	std::string commit();

private:
	std::string m_path, m_temporary;
	int m_slot = -1;
};

// Empty on success, otherwise a sentence with path and reason.
std::string writeFile(const std::string& path, const void* data, std::size_t size);
std::string writeFile(const std::string& path, const std::string& text);
std::string writeFile(const std::string& path, const std::vector<std::byte>& bytes);

// Why a file could not be written there, found out without leaving one; empty where it can. "-" is stdout.
std::string unwritable(const std::string& path);

// "-" writes to stdout. Keys keep their order; non-finite numbers become null.
std::string writeJson(const std::string& path, const nlohmann::ordered_json& report);

// The whole of a regular file of at most `limit` bytes, read without trusting its size.
Result<std::vector<std::byte>> readFile(const std::string& path, std::size_t limit);

// Async-signal-safe: unlinks every partial file of this process.
void removePartialFiles() noexcept;
}  // namespace clod::cli
