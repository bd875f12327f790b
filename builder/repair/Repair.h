// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes that the intake refuses, made into solids: by mending what is wrong (`repair`), or by shrinking a watertight
// wrap onto them (`wrapAround`). Every change is told in a sentence, and how far the surface moved is certified.
#pragma once
#include <string>
#include <vector>

#include "builder/intake/Intake.h"
#include "builder/repair/SurfaceDistance.h"

namespace clod::builder
{
struct Repaired
{
	Intake solid;
	std::vector<std::string> changes;  // in the order they were made; empty: the file was sound, nothing was done
	// Between the faces of the file that are finite and have area, and the surface that is built (rounded to float):
	DistanceBracket added;  // from the new surface to the file's: lids over holes, bridges of a wrap
	DistanceBracket lost;   // from the file's surface to the new one: what was cut away or dropped
	double moved() const;   // certified: neither surface has a point farther than this from the other
};

// Steps, each only where needed: faces with coordinates that are no numbers, or without area, are dropped; repeated
// faces too (a pair facing both ways goes altogether where the rest closes without it); open edges within 1e-5 of the
// extent are sewn, also to vertices on their length; faces are turned to agree, non-manifold edges and vertices are cut
// apart and moved apart by 1e-4 of the extent at most; holes get lids; components that enclose nothing are dropped;
// components that cross are united, crossings within one are cut out and filled; components are turned outward, or
// inward where they bound a cavity.
//
// Elements in `changes` are numbered as in the file. Throws Refused where the result is still no solid, saying what is
// left, and where the surface would move by more than maxMove. Tells its progress between its steps.
Repaired repair(const Soup& soup, double maxMove, const Progress& progress = {});

// A watertight surface round the faces of the file, about length / 30 outside of them, that closes gaps and holes
// narrower than `length` (Portaneri et al., Alpha Wrapping with an Offset, 2022; CGAL). Longer, and told so, where the
// wrap would have more than so many triangles, unless that is 0. Throws Refused: a limit where the wrap would need
// millions of triangles.
Repaired wrapAround(const Soup& soup, double length, std::size_t mostTriangles = 0, const Progress& progress = {});
}  // namespace clod::builder
