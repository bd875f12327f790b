// SPDX-License-Identifier: Zlib
#include "cli/Files.h"

#include <nlohmann/json.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace clod::cli
{
namespace
{
// Temporary paths a signal handler can unlink: fixed storage, no allocation.
constexpr int kSlots = 16;
constexpr std::size_t kPathLimit = 4096;
struct Slot
{
	std::atomic<int> state{0};  // 0 free, 1 being filled, 2 names a file
	char path[kPathLimit];
};
Slot g_slots[kSlots];

int remember(const std::string& path)
{
	if (path.size() >= kPathLimit) return -1;
	for (int i = 0; i < kSlots; ++i)
	{
		int expected = 0;
		if (!g_slots[i].state.compare_exchange_strong(expected, 1)) continue;
		std::memcpy(g_slots[i].path, path.c_str(), path.size() + 1);
		g_slots[i].state = 2;
		return i;
	}
	return -1;
}

void forget(int slot)
{
	if (slot >= 0) g_slots[slot].state = 0;
}

std::string systemError(const char* what, const std::string& path)
{
	return fmt::format("cannot {} {}: {}", what, path, std::strerror(errno));
}

std::string writeAll(int file, const char* data, std::size_t size, const std::string& path)
{
	while (size > 0)
	{
		const ssize_t written = write(file, data, size);
		if (written < 0 && errno == EINTR) continue;
		if (written < 0) return systemError("write", path);
		data += written;
		size -= std::size_t(written);
	}
	return {};
}

// Opens `target`, writes, flushes and closes it; errors name `path`.
std::string writeTo(const std::string& path, const std::string& target, int flags, const void* data, std::size_t size)
{
	const int file = open(target.c_str(), flags | O_CLOEXEC, 0666);
	if (file < 0) return systemError("write", path);
	std::string error = writeAll(file, static_cast<const char*>(data), size, path);
	if (error.empty() && fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP) error = systemError("write", path);
	if (close(file) != 0 && error.empty()) error = systemError("write", path);
	return error;
}

// Something that cannot be replaced by renaming: /dev/null, a pipe.
bool isDevice(const std::string& path)
{
	struct stat status = {};
	return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

Result<std::vector<std::byte>> readAll(int file, const std::string& path, std::size_t limit)
{
	struct stat status = {};
	if (fstat(file, &status) != 0) return Error{systemError("read", path)};
	if (!S_ISREG(status.st_mode)) return Error{fmt::format("{} is not a regular file", path)};
	if (std::size_t(status.st_size) > limit)
		return Error{fmt::format("{} has {} bytes; the limit is {}", path, status.st_size, limit)};
	std::vector<std::byte> bytes(std::size_t(status.st_size));
	std::size_t filled = 0;
	while (filled < bytes.size())
	{
		const ssize_t got = read(file, bytes.data() + filled, bytes.size() - filled);
		if (got < 0 && errno == EINTR) continue;
		if (got < 0) return Error{systemError("read", path)};
		if (got == 0) break;
		filled += std::size_t(got);
	}
	bytes.resize(filled);
	return bytes;
}
}  // namespace

PartialFile::PartialFile(std::string path) : m_path(std::move(path))
{
	// Numbered besides the process: two threads may write the same path.
	static std::atomic<unsigned> counter{0};
	// The extension stays last: programs choose a file's format by it.
	const std::size_t name = m_path.find_last_of('/') + 1;
	const std::size_t dot = m_path.find_last_of('.');
	const std::size_t end = dot != std::string::npos && dot > name ? dot : m_path.size();
	m_temporary = fmt::format("{}.partial-{}-{}{}", m_path.substr(0, end), getpid(), counter++, m_path.substr(end));
	m_slot = remember(m_temporary);
}

PartialFile::~PartialFile()
{
	if (!m_temporary.empty()) unlink(m_temporary.c_str());
	forget(m_slot);
}

std::string PartialFile::commit()
{
	if (std::rename(m_temporary.c_str(), m_path.c_str()) != 0) return systemError("write", m_path);
	m_temporary.clear();
	return {};
}

std::string writeFile(const std::string& path, const void* data, std::size_t size)
{
	if (isDevice(path)) return writeTo(path, path, O_WRONLY, data, size);
	PartialFile partial(path);
	const std::string error = writeTo(path, partial.temporaryPath(), O_WRONLY | O_CREAT | O_EXCL, data, size);
	return error.empty() ? partial.commit() : error;
}

std::string writeFile(const std::string& path, const std::string& text)
{
	return writeFile(path, text.data(), text.size());
}

std::string writeFile(const std::string& path, const std::vector<std::byte>& bytes)
{
	return writeFile(path, bytes.data(), bytes.size());
}

std::string unwritable(const std::string& path)
{
	struct stat status = {};
	if (path == "-" || isDevice(path)) return {};
	if (stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) return "cannot write " + path + ": it is a directory";
	const PartialFile partial(path);  // never committed
	return writeTo(path, partial.temporaryPath(), O_WRONLY | O_CREAT | O_EXCL, nullptr, 0);
}

std::string writeJson(const std::string& path, const nlohmann::ordered_json& report)
{
	const std::string text = report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
	if (path != "-") return writeFile(path, text);
	const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
	return written ? std::string() : systemError("write", "standard output");
}

Result<std::vector<std::byte>> readFile(const std::string& path, std::size_t limit)
{
	// Non-blocking, so that a FIFO without a writer is refused instead of waited for.
	const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
	if (file < 0) return Error{systemError("open", path)};
	Result<std::vector<std::byte>> result = readAll(file, path, limit);
	close(file);
	return result;
}

void removePartialFiles() noexcept
{
	for (Slot& slot : g_slots)
		if (slot.state == 2) unlink(slot.path);
}
}  // namespace clod::cli
