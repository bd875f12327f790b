// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh file as read: polygons in double precision, nothing welded, nothing checked but the syntax; and its refusal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <clod/collide/Vector.h>

namespace clod::builder
{
// Why a mesh is not accepted. name() gives the word that starts the message.
enum class Reason
{
	unreadable,         // no such file, not a regular file, unknown format
	noSuchPart,         // the file has no part of that name
	syntax,             // the file does not follow its format
	empty,              // no vertices or no faces
	limit,              // larger than the builder's limits
	notFinite,          // NaN or infinite coordinate
	indexOutOfRange,    // a face names a vertex that does not exist
	degenerate,         // face without area
	duplicate,          // two faces with the same corners
	nonManifoldEdge,    // edge of more than two faces
	nonManifoldVertex,  // two fans of faces meet in one vertex
	openBoundary,       // edge of one face
	orientation,        // neighbouring faces wound differently
	inverted,           // component turned inside out
	zeroVolume,         // encloses nothing
	rounding,           // features vanish in float32 round the centre of mass
	selfIntersection    // two faces cross or overlap
};
const char* name(Reason reason);

// One kind of defect: the first element that has it, named as in the file, and how many have it.
struct Defect
{
	Reason reason;
	std::string first;
	std::size_t count = 1;
};
// "(0.1, 0.2, 0.3)", as refusals name a place of the file.
std::string placeOf(const Vec3& point);
// "duplicate face: face 6 ... (3 such); also open boundary: ..."
std::string sentence(const std::vector<Defect>& defects);

// A mesh that cannot be built, with the first offending element in the message. Elements are numbered from 0 in the
// order of the file; parsers name the line (from 1) or the byte.
class Refused : public std::runtime_error
{
public:
	Refused(Reason reason, const std::string& message)
		: std::runtime_error(std::string(name(reason)) + ": " + message), m_reason(reason)
	{
	}
	// Several kinds at once, the one that decides first; never empty.
	explicit Refused(const std::vector<Defect>& defects)
		: std::runtime_error(sentence(defects)), m_reason(defects.front().reason)
	{
	}
	Reason reason() const { return m_reason; }

private:
	Reason m_reason;
};

// A piece of the file that has a name, and ends before these vertices and polygons; it begins where the last one ends.
struct Part
{
	std::string name;  // letters, digits, '.', '-', '_' and UTF-8 beyond ASCII; no two are the same
	std::size_t vertexEnd, polygonEnd;
};

struct Soup
{
	std::vector<Vec3> vertices;
	std::vector<std::uint32_t> corners;   // of all polygons, one after the other
	std::vector<std::size_t> polygonEnd;  // end of each polygon in corners
	std::vector<Part> parts;              // all of it, in order; none: the format names none, or there are no faces
	std::size_t polygonCount() const { return polygonEnd.size(); }
	std::size_t polygonBegin(std::size_t polygon) const { return polygon == 0 ? 0 : polygonEnd[polygon - 1]; }
	void endPolygon() { polygonEnd.push_back(corners.size()); }
	// Ends a part whose name, made one for files and shells, is this or close to it.
	void endPart(const std::string& name);
};

// One part of a file, in the frame of the whole; its elements are counted from 0 again. Throws Refused.
Soup partOf(const Soup& soup, const std::string& name);

inline constexpr std::size_t kTriangleLimit = 20'000'000;
inline constexpr long long kMostVertices = 0xFFFFFFFF;
inline constexpr std::size_t kPolygonCornerLimit = 256;
inline constexpr std::size_t kFileLimit = std::size_t(4) << 30;

// A vertex index from a file, which must be one of [0, 2^32 - 2]; `place` says where it stood.
std::uint32_t checkedIndex(long long index, const std::string& place);
}  // namespace clod::builder
