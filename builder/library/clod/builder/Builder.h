// SPDX-License-Identifier: GPL-3.0-or-later
// The builder as a library: from a triangle mesh to a hierarchy, in one call that throws nothing, reports its progress
// and can be cancelled. It takes seconds to minutes. It contains CGAL, so a program that links it is under the GPL.
//
// Lengths and frame are the mesh's, except that FileOptions may convert them. Vertices of the hierarchy are relative to
// the centre of mass; its meshFromBody leads back.
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
	refused,    // the mesh is no sound solid, the file cannot be read, or an option is wrong: the message tells which
	limit,      // too large, or out of memory
	cancelled,  // by the callback
	failed      // an internal error, or an exception that the callback threw
};

// Must be closed, oriented outward (counter-clockwise from outside), 2-manifold and free of self-intersections.
// Anything else is refused, or repaired if Options ask for it.
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
	bool repair = false;     // repair a mesh that is no sound solid
	double maxMove = 0;      // with repair: refuse if the surface moves farther; 0 = a quarter of the radius
	double wrap = 0;         // instead: build a watertight wrap that closes gaps narrower than this; 0 = none
};

// unit: that of the file (um, mm, cm, m, in, ft); the hierarchy is then in metres. If empty, lengths stay as they are.
// up: the file's axis that points up (x, y or z); it becomes y. scale: a factor applied after the unit.
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
	double moved = 0;                            // certified distance between the given surface and the one built
};

// Called with the name of the phase and the fraction of it that is done, 0 to 1; return false to cancel. It is called
// by one thread at a time, but not always by the same. Reading, checking and each step of a repair report only their
// end.
using Callback = std::function<bool(const char* phase, double fraction)>;

CLOD_API Outcome build(const TriangleMesh& mesh, const Options& options = {}, const Callback& callback = {}) noexcept;
// Reads OBJ, OFF, PLY, STL, glTF or GLB. For the latter two the path FILE#PART means one part of the scene.
CLOD_API Outcome buildFile(const std::string& path, const FileOptions& options = {},
						   const Callback& callback = {}) noexcept;
}  // namespace clod::builder
