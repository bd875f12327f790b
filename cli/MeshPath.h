// SPDX-License-Identifier: Zlib
// How people name a mesh: a file, or one part of a glTF scene as FILE#PART. Header only, since the builder's library
// reads it, too.
#pragma once
#include <cctype>
#include <string>

namespace clod::cli
{
struct MeshPath
{
	std::string file, part;  // no part: the whole file
};

// The ending of a file's name in lower case, with its dot; empty where it has none.
inline std::string endingOf(const std::string& file)
{
	const std::size_t dot = file.rfind('.'), slash = file.rfind('/');
	if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return {};
	std::string ending = file.substr(dot);
	for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
	return ending;
}

// What the builder reads.
inline constexpr const char* kMeshEndings[] = {".obj", ".off", ".ply", ".stl", ".gltf", ".glb"};

// Why a file of this name can be no mesh; empty where it can.
inline std::string notAMesh(const std::string& file)
{
	std::string endings;
	for (const char* const ending : kMeshEndings)
	{
		if (endingOf(file) == ending) return {};
		endings += (endings.empty() ? "" : ", ") + std::string(ending);
	}
	return file + " does not end in " + endings;
}

inline bool isGltf(const std::string& file)
{
	const std::string ending = endingOf(file);
	return ending == ".gltf" || ending == ".glb";
}

// Only what stands behind a glTF file's ending is a part; any other '#' belongs to the name.
inline MeshPath meshPath(const std::string& path)
{
	const std::size_t mark = path.rfind('#');
	if (mark == std::string::npos || !isGltf(path.substr(0, mark))) return {path, {}};
	return {path.substr(0, mark), path.substr(mark + 1)};
}

// The part's name, or the file's without folder and ending.
inline std::string nameOf(const MeshPath& path)
{
	if (!path.part.empty()) return path.part;
	const std::size_t slash = path.file.rfind('/');
	const std::string name = slash == std::string::npos ? path.file : path.file.substr(slash + 1);
	return name.substr(0, name.size() - endingOf(name).size());
}

// As a shell takes it for one word.
inline std::string shellWord(const std::string& word)
{
	bool isPlain = !word.empty();
	for (const char c : word)
		isPlain = isPlain && (std::isalnum(static_cast<unsigned char>(c)) != 0 ||
							  std::string("/._-+,:=@%").find(c) != std::string::npos);
	if (isPlain) return word;
	std::string quoted = "'";
	for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
	return quoted + "'";
}
}  // namespace clod::cli
