// SPDX-License-Identifier: GPL-3.0-or-later
// The rules of the architecture, each a function from sources to the faults found in them, one sentence a fault.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace clod::test
{
struct Source
{
	std::string path;  // from the project's root, with '/'
	std::string text;
};
using Sources = std::vector<Source>;
using Faults = std::vector<std::string>;

inline constexpr std::size_t kMostSourcesOfFolder = 36;
inline constexpr std::size_t kMostLinesOfSource = 500;

// All .h and .cpp of plugin, cli, builder and demos, and those of tests, ordered by path.
Sources readProduct(const std::string& root);
Sources readTests(const std::string& root);

// Folders of plugin/clod: collide < hierarchy < query < distance < manifold < schedule < bullet. None includes one above it, and
// each include of ours is a file that exists, named from plugin/.
Faults upwardIncludes(const Sources& sources);
// Of the plugin: Bullet's headers in clod/bullet only, the builder's libraries nowhere.
Faults foreignIncludes(const Sources& sources);
// What never links the builder never includes it: plugin, cli and demos.
Faults builderIncludes(const Sources& sources);
// Of the tests: those of the plugin are built without the builder (scripts/test --plugin), so reach no header of its.
Faults buildersInPluginTests(const Sources& sources);
// Of the plugin: folders with more than kMostSourcesOfFolder headers and sources; files with more than
// kMostLinesOfSource.
Faults crowdedFolders(const Sources& sources);
Faults longSources(const Sources& sources);
// Headers of the plugin that reach a single .cpp of the whole product, which is not their own: it should hold them.
// Kernels (*Kernel.h, and CompiledTwice.h that includes them twice) are such by nature.
Faults headersOfOneSource(const Sources& sources);
// Of the plugin: a constant that two headers define is one of the two, whichever the linker takes.
Faults constantsDefinedTwice(const Sources& sources);
// The first line of each names its licence and nothing else: the builder's is the GPL, all others' zlib.
Faults wrongLicences(const Sources& sources);
}  // namespace clod::test
