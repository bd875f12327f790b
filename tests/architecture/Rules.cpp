// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/architecture/Rules.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace clod::test
{
namespace
{
const char* const kFoldersUpward[] = {"collide", "hierarchy", "query", "distance", "manifold", "schedule", "bullet"};
constexpr int kUnknownFolder = -1;
constexpr int kPackage = -2;

bool startsWith(const std::string& text, const std::string& start)
{
	return text.compare(0, start.size(), start) == 0;
}

bool endsWith(const std::string& text, const std::string& end)
{
	return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool ofPlugin(const std::string& path)
{
	return startsWith(path, "plugin/");
}

std::string folderOf(const std::string& path)
{
	return path.substr(0, path.rfind('/'));
}

// The name between the quotes or brackets of a line's #include; empty where it has none, or names a macro.
std::string includeOf(const std::string& line)
{
	std::size_t at = line.find_first_not_of(" \t");
	if (at == std::string::npos || line[at] != '#') return {};
	at = line.find_first_not_of(" \t", at + 1);
	if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
	at = line.find_first_of("\"<", at + 7);
	if (at == std::string::npos) return {};
	const std::size_t end = line.find_first_of("\">", at + 1);
	return end == std::string::npos ? std::string() : line.substr(at + 1, end - at - 1);
}

std::vector<std::string> includesOf(const Source& source)
{
	std::vector<std::string> includes;
	std::istringstream lines(source.text);
	for (std::string line; std::getline(lines, line);)
	{
		const std::string name = includeOf(line);
		if (!name.empty()) includes.push_back(name);
	}
	return includes;
}

// The file an include names: plugin's own are named from plugin/, the others' from the root.
std::string pathOf(const std::string& include)
{
	return startsWith(include, "clod/") ? "plugin/" + include : include;
}

// What lies in plugin/clod itself is the package's: version and export marks. It is below all folders.
bool isOfPackage(const std::string& path)
{
	return startsWith(path, "plugin/clod/") && path.find('/', std::string("plugin/clod/").size()) == std::string::npos;
}

// Its folder's place in the order.
int rankOf(const std::string& pathInPlugin)
{
	if (isOfPackage(pathInPlugin)) return kPackage;
	for (int rank = 0; rank < int(std::size(kFoldersUpward)); ++rank)
		if (startsWith(pathInPlugin, std::string("plugin/clod/") + kFoldersUpward[rank] + "/")) return rank;
	return kUnknownFolder;
}

bool isBullet(const std::string& include)
{
	const std::string name = include.substr(include.rfind('/') + 1);
	return startsWith(include, "Bullet") || startsWith(include, "LinearMath/") || startsWith(include, "bullet/") ||
		   startsWith(name, "bt");
}

bool isOfBuilderLibraries(const std::string& include)
{
	for (const char* start : {"CGAL/", "Eigen/", "unsupported/Eigen/", "boost/", "gmp", "mpfr"})
		if (startsWith(include, start)) return true;
	return false;
}

bool isKernel(const std::string& path)
{
	return endsWith(path, "Kernel.h") || endsWith(path, "/CompiledTwice.h");
}

// Of each header: the .cpp that it reaches, through whatever headers.
std::map<std::string, std::set<std::string>> readersOfHeaders(const Sources& sources)
{
	std::map<std::string, std::vector<std::string>> includes;
	for (const Source& source : sources)
		for (const std::string& include : includesOf(source)) includes[source.path].push_back(pathOf(include));
	std::map<std::string, std::set<std::string>> readers;
	for (const Source& source : sources)
	{
		if (!endsWith(source.path, ".cpp")) continue;
		std::vector<std::string> open = {source.path};
		while (!open.empty())
		{
			const std::string file = open.back();
			open.pop_back();
			for (const std::string& header : includes[file])
				if (readers[header].insert(source.path).second) open.push_back(header);
		}
	}
	return readers;
}

Sources readFolders(const std::string& root, const std::vector<const char*>& folders)
{
	Sources sources;
	for (const char* part : folders)
		for (const auto& entry : std::filesystem::recursive_directory_iterator(std::filesystem::path(root) / part))
		{
			const std::string extension = entry.path().extension().string();
			if (extension != ".h" && extension != ".cpp") continue;
			std::ifstream file(entry.path(), std::ios::binary);
			sources.push_back({entry.path().lexically_relative(root).generic_string(),
							   {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}});
		}
	std::sort(sources.begin(), sources.end(), [](const Source& l, const Source& r) { return l.path < r.path; });
	return sources;
}
}  // namespace

Sources readTests(const std::string& root)
{
	return readFolders(root, {"tests"});
}

Sources readProduct(const std::string& root)
{
	return readFolders(root, {"plugin", "cli", "builder", "demos"});
}

Faults upwardIncludes(const Sources& sources)
{
	std::set<std::string> paths;
	for (const Source& source : sources) paths.insert(source.path);
	Faults faults;
	for (const Source& source : sources)
	{
		if (!ofPlugin(source.path)) continue;
		const int rank = rankOf(source.path);
		if (rank == kUnknownFolder) faults.push_back(source.path + " lies in no folder of the order");
		for (const std::string& include : includesOf(source))
		{
			if (startsWith(include, "."))
				faults.push_back(source.path + " includes " + include + ", not named from plugin/");
			if (!startsWith(include, "clod/")) continue;
			if (paths.count(pathOf(include)) == 0)
				faults.push_back(source.path + " includes " + include + ", which is no file");
			else if (rankOf(pathOf(include)) > rank)
				faults.push_back(source.path + " includes " + include + ", which lies above it");
		}
	}
	return faults;
}

Faults foreignIncludes(const Sources& sources)
{
	Faults faults;
	for (const Source& source : sources)
	{
		if (!ofPlugin(source.path)) continue;
		for (const std::string& include : includesOf(source))
		{
			const bool ours = startsWith(include, "clod/");
			if (!ours && isBullet(include) && folderOf(source.path) != "plugin/clod/bullet")
				faults.push_back(source.path + " includes " + include + ", but knows no engine");
			if (isOfBuilderLibraries(include))
				faults.push_back(source.path + " includes " + include + ", of a library of the builder's");
		}
	}
	return faults;
}

Faults builderIncludes(const Sources& sources)
{
	Faults faults;
	for (const Source& source : sources)
	{
		if (startsWith(source.path, "builder/")) continue;
		for (const std::string& include : includesOf(source))
			if (startsWith(include, "builder/") || include.find("../builder/") != std::string::npos)
				faults.push_back(source.path + " includes " + include + ", of the builder");
	}
	return faults;
}

Faults buildersInPluginTests(const Sources& sources)
{
	const auto readers = readersOfHeaders(sources);
	Faults faults;
	for (const auto& [header, of] : readers)
		for (const std::string& source : of)
			for (const char* folder : {"bullet", "collide", "distance", "hierarchy", "manifold", "query", "random"})
				if (startsWith(header, "builder/") && startsWith(source, std::string("tests/") + folder + "/"))
					faults.push_back(source + " reaches " + header + ", of the builder");
	return faults;
}

Faults crowdedFolders(const Sources& sources)
{
	std::map<std::string, std::size_t> counts;
	for (const Source& source : sources)
		if (ofPlugin(source.path)) ++counts[folderOf(source.path)];
	Faults faults;
	for (const auto& [folder, count] : counts)
		if (count > kMostSourcesOfFolder) faults.push_back(folder + " holds " + std::to_string(count) + " sources");
	return faults;
}

Faults longSources(const Sources& sources)
{
	Faults faults;
	for (const Source& source : sources)
	{
		const auto lines = std::size_t(std::count(source.text.begin(), source.text.end(), '\n'));
		if (ofPlugin(source.path) && lines > kMostLinesOfSource)
			faults.push_back(source.path + " has " + std::to_string(lines) + " lines");
	}
	return faults;
}

Faults constantsDefinedTwice(const Sources& sources)
{
	const std::regex definition("inline constexpr [^=;]*\\b(k[A-Z][A-Za-z0-9]*)(?: =|\\{|\\[)");
	std::map<std::string, std::string> places;
	Faults faults;
	for (const Source& source : sources)
	{
		if (!ofPlugin(source.path) || !endsWith(source.path, ".h")) continue;
		for (std::sregex_iterator at(source.text.begin(), source.text.end(), definition), end; at != end; ++at)
		{
			const auto [place, isNew] = places.insert({at->str(1), source.path});
			if (!isNew) faults.push_back(at->str(1) + " is defined in " + place->second + " and in " + source.path);
		}
	}
	return faults;
}

Faults headersOfOneSource(const Sources& sources)
{
	const auto readers = readersOfHeaders(sources);
	Faults faults;
	for (const Source& source : sources)
	{
		if (!ofPlugin(source.path) || !endsWith(source.path, ".h") || isKernel(source.path) || isOfPackage(source.path))
			continue;
		const auto found = readers.find(source.path);
		if (found == readers.end())
			faults.push_back(source.path + " serves no source");
		else if (found->second.size() == 1)
		{
			const std::string own = source.path.substr(0, source.path.size() - 2) + ".cpp";
			const std::string& only = *found->second.begin();
			if (only != own) faults.push_back(source.path + " serves " + only + " alone");
		}
	}
	return faults;
}

Faults wrongLicences(const Sources& sources)
{
	Faults faults;
	for (const Source& source : sources)
	{
		const std::string licence = startsWith(source.path, "builder/") ? "GPL-3.0-or-later" : "Zlib";
		const std::string line = "// SPDX-License-Identifier: " + licence;
		if (!startsWith(source.text, line + "\n")) faults.push_back(source.path + " does not begin with '" + line + "'");
	}
	return faults;
}
}  // namespace clod::test
