// SPDX-License-Identifier: Zlib
// Hierarchies by mesh: runs the clod-build that lies beside this program, and keeps what it built.
//
// An entry's name is the hash of the mesh's bytes, the parameters and the builder's own bytes, so a changed mesh,
// option or builder never meets an old entry. Entries are written aside and renamed; one that does not load is built
// again.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "cli/Failure.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod::demo
{
using HierarchyPointer = std::shared_ptr<const Hierarchy>;

struct CacheOptions
{
	std::string directory;  // empty: $XDG_CACHE_HOME/clod, else ~/.cache/clod
	bool enabled = true;    // false: build into a temporary file and keep nothing
};

// How a mesh is built; part of an entry's name.
struct BuildOptions
{
	bool paper = false;
	bool repair = false;
	double scale = 1;       // all lengths of the file times this
	std::string wrap = {};  // instead of repair: closes gaps narrower than this length, as the builder reads it
	std::size_t mostTriangles = 0;  // of a wrap; 0: any number
};

// A mesh as a file would hold it.
struct MeshSource
{
	std::string name;       // for messages
	std::string extension;  // ".obj", ... : how the bytes are to be read
	std::vector<std::byte> bytes;
	std::string path;  // where the bytes lie already; empty: in memory only
	std::string part = {};  // of a glTF scene, the only one to build; empty: all of it
};

// The builder refused a mesh, and told why on stderr.
struct RefusedMesh : cli::Failure
{
	RefusedMesh(cli::ExitCode code, const std::string& message, bool mendable)
		: Failure(code, message), isMendable(mendable)
	{
	}
	bool isMendable;  // --repair, --wrap or a coarser wrap may help
};

class HierarchyCache
{
public:
	// quiet: no progress of the builder.
	HierarchyCache(CacheOptions options, bool quiet);

	// The hierarchy of a mesh in memory, built where the cache has none. Throws cli::Failure: bad input (3) with the
	// builder's reason on stderr, or failure (1) where the builder is missing or broken.
	HierarchyPointer build(const MeshSource& mesh, const BuildOptions& options);
	// A .clod file is loaded; any other file is a mesh, and FILE#PART one part of a glTF scene. A .clod file that
	// contradicts `paper`, or that had to be scaled, is a usage error (2).
	HierarchyPointer open(const std::string& path, const BuildOptions& options);

	// Entries built by this object, and those found whole in the cache.
	int built() const { return m_built; }
	int found() const { return m_found; }
	// What repair or wrap did to the mesh opened last, in sentences; empty: nothing.
	const std::vector<std::string>& changes() const { return m_changes; }
	// Where entries lie; empty when disabled.
	const std::string& directory() const { return m_options.directory; }

private:
	std::string entryPath(const MeshSource& mesh, const BuildOptions& options) const;
	HierarchyPointer buildInto(const std::string& entry, const MeshSource& mesh, const BuildOptions& options,
							   bool keep);
	void runBuilder(const std::string& meshPath, const std::string& output, const std::string& report,
					const BuildOptions& options) const;
	void readChanges(const std::string& report, const Hierarchy& hierarchy);

	CacheOptions m_options;
	bool m_quiet;
	int m_built = 0, m_found = 0;
	std::vector<std::string> m_changes;
};

// The parts of a glTF scene as the builder names them; none of other files. Throws cli::Failure.
struct ScenePart
{
	std::string name;
	std::size_t faces;
	double radius;
};
std::vector<ScenePart> partsOf(const std::string& file);

// $TMPDIR or /tmp.
std::string temporaryDirectory();
// The clod-build beside this executable.
std::string builderPath();
}  // namespace clod::demo
