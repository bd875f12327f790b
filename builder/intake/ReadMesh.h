// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files to polygon soup: OBJ, OFF, PLY, STL, glTF. Strict: whatever a reader does not understand is refused with
// its line or byte. Counts in a file are compared with the bytes left before anything is allocated; no path named
// inside a file is opened, except the buffers of a .gltf that lie beside it.
//
// Sources: the formats' public descriptions (Wavefront OBJ 3.0, Geomview OFF, Stanford PLY 1.0, STL, glTF 2.0).
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "builder/intake/Soup.h"

namespace clod::builder
{
// Reads by the ending of the name, ignoring case; of a glTF scene one part, if the path is FILE#PART. Throws Refused.
Soup readMesh(const std::string& path);

// Some Windows programs put a byte-order mark before text.
std::string_view withoutByteOrderMark(std::string_view text);

// One format each, from memory; only STL, which may be binary with any bytes in front, with a byte-order mark. glTF
// needs the folder its external buffers lie in.
Soup parseObj(std::string_view text);
Soup parseOff(std::string_view text);
Soup parsePly(std::string_view bytes);
Soup parseStl(std::string_view bytes);
Soup parseGltf(std::string_view bytes, const std::string& folder);
}  // namespace clod::builder
