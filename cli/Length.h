// SPDX-License-Identifier: Zlib
// Lengths on the command line: `0.0005` (the mesh's own unit), `0.5mm`, `2cm`, `1m` (the unit then being the metre), or
// `1%` of the bounding radius (of the smaller one where two bodies meet).
#pragma once
#include <functional>
#include <optional>
#include <string>

#include <clod/hierarchy/Result.h>

namespace CLI
{
class App;
class Option;
}  // namespace CLI

namespace clod::cli
{
struct Length
{
	double value = 0;  // in the mesh's unit, or the share of the radius (0.01 for 1%)
	bool shareOfRadius = false;
	std::string text;  // as the user wrote it
	double inMeshUnit(double radius) const { return shareOfRadius ? value * radius : value; }
};

// Finite and >= 0; anything else is an error naming the text. `inf` is not a length.
Result<Length> parseLength(const std::string& text);

// How the length was understood: "1% of the radius 0.04 = 0.0004", lengths as `inWords` puts them, else in the mesh's
// unit.
std::string describe(const Length& length, double radius, const std::function<std::string(double)>& inWords = {});

// The words to try on a mesh that was refused with these: --repair, then wraps, each coarser than the last.
std::string mendingAfter(bool repair, const std::optional<Length>& wrap);

// An option taking a length; left empty when absent.
CLI::Option* addLength(CLI::App& command, const std::string& name, std::optional<Length>& value,
					   const std::string& description);
}  // namespace clod::cli
