// SPDX-License-Identifier: GPL-3.0-or-later
// From the units and axes of a mesh file to those of the hierarchy. Without any option a hierarchy has the file's own.
#pragma once
#include <string>
#include <vector>

#include "builder/intake/Soup.h"

namespace clod::builder
{
struct FileFrame
{
	std::string unit;  // of the file's lengths, one of unitNames(): the hierarchy is then in metres; empty: as it is
	std::string up = "y";  // the file's axis that points up, one of upNames(); it becomes y, the scenes' and glTF's
	double scale = 1;      // positive; applied after the unit
};

// {"um", "mm", "cm", "m", "in", "ft"} and {"x", "y", "z"}.
const std::vector<std::string>& unitNames();
const std::vector<std::string>& upNames();

// Converts all vertices; at most two roundings for the unit, one for the scale, none for the axes (a rotation by
// quarter turns: handedness is kept). Names outside the lists are a programming error.
void convert(const FileFrame& frame, Soup& soup);
}  // namespace clod::builder
