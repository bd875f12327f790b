// SPDX-License-Identifier: GPL-3.0-or-later
// Files of tests. Tests run side by side, so each writes into a folder that nobody else has.
#pragma once
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace clod::test
{
// A new empty folder, removed at the end with all that is in it.
class TemporaryFolder
{
public:
	TemporaryFolder()
	{
		std::string name = (std::filesystem::temp_directory_path() / "clod-test-XXXXXX").string();
		if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot be made");
		m_path = name;
	}
	~TemporaryFolder() { std::filesystem::remove_all(m_path); }
	TemporaryFolder(const TemporaryFolder&) = delete;
	TemporaryFolder& operator=(const TemporaryFolder&) = delete;

	const std::filesystem::path& path() const { return m_path; }
	std::string file(const std::string& name) const { return (m_path / name).string(); }
	// With this text in it.
	std::string file(const std::string& name, const std::string& text) const
	{
		std::ofstream(file(name), std::ios::binary) << text;
		return file(name);
	}
	// With these bytes in it: anything with data() and size().
	template <class Bytes>
	std::string fileOf(const std::string& name, const Bytes& bytes) const
	{
		return file(name, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
	}

private:
	std::filesystem::path m_path;
};

inline std::string readText(const std::filesystem::path& path)
{
	std::ifstream file(path, std::ios::binary);
	return {std::istreambuf_iterator<char>(file), {}};
}
}  // namespace clod::test
