// SPDX-License-Identifier: GPL-3.0-or-later
// The builder as a library: from a triangle mesh to a hierarchy, in one call that throws nothing, tells how far it is
// and can be cancelled. It contains CGAL: a program that links it is GPL.
//
//   const auto built = clod::builder::buildFile("cup.obj");
//   if (built.status != clod::builder::Status::built) ... built.message ...
//   btClodShape shape(built.hierarchy);        // or write built.hierarchy->bytes() to a .clod file
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod::builder
{
enum class Status
{
	built,
	refused,    // the mesh is no sound solid, the file cannot be read, or an option is wrong: the message says which
	limit,      // too large, or out of memory
	cancelled,  // the callback said so
	failed      // an error of the builder's, or an exception that the callback threw
};

// Closed, oriented outward (counter-clockwise from outside), a 2-manifold: everything else is refused, or mended.
struct TriangleMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<std::uint32_t, 3>> triangles;
};

struct Options
{
	unsigned threads = 0;    // 0 = all cores; the result never depends on it
	std::uint64_t seed = 1;  // of everything random
	bool paper = false;      // exactly the paper's choices (Otaduy & Lin 2003)
	bool repair = false;     // mend what is wrong with the mesh
	double maxMove = 0;      // with repair: refuse if the surface moves farther; 0 = a quarter of the radius
	double wrap = 0;         // instead: a watertight wrap round the mesh, closing gaps narrower than this; 0 = none
};

// The file's unit (um, mm, cm, m, in, ft: the hierarchy is then in metres; empty: lengths stay as they are), its axis
// that points up (x, y, z; it becomes y) and a factor applied after the unit.
struct FileOptions : Options
{
	std::string unit, up = "y";
	double scale = 1;
};

struct Outcome
{
	Status status = Status::failed;
	std::string message;                         // why there is no hierarchy
	std::shared_ptr<const Hierarchy> hierarchy;  // validated as if loaded, mass properties and meshFromBody filled
	std::vector<std::string> changes;            // what repair or wrap did, in sentences
	double moved = 0;                            // certified: no surface has a point farther than this from the other
};

// Called with the phase and how much of it is done, 0 to 1; returns false to cancel. By one thread at a time, but not
// always the same. Reading, checking and the steps of a repair are told of between, not within.
using Callback = std::function<bool(const char* phase, double fraction)>;

CLOD_API Outcome build(const TriangleMesh& mesh, const Options& options = {}, const Callback& callback = {}) noexcept;
// OBJ, OFF, PLY, STL, glTF, GLB; of the latter two one node's mesh, where the path is FILE#NODE.
CLOD_API Outcome buildFile(const std::string& path, const FileOptions& options = {},
						   const Callback& callback = {}) noexcept;
}  // namespace clod::builder
