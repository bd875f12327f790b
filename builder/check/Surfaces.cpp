// SPDX-License-Identifier: GPL-3.0-or-later
// Every contact level is a closed oriented 2-manifold whose patches are edge-connected; vertices are told apart by
// their coordinates, neighbours are found anew from them.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "builder/check/Rounding.h"
#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
using Key = std::tuple<double, double, double>;

// Triangles of a level over numbered vertices.
struct LevelMesh
{
	std::vector<std::array<std::uint32_t, 3>> triangles;
	std::size_t vertexCount = 0;
};

LevelMesh numbered(const Subject& s, const Level& level)
{
	LevelMesh mesh;
	std::map<Key, std::uint32_t> number;
	for (std::uint32_t f = 0; f < level.faceCount; ++f)
	{
		const Triangle t = s.triangle(level.firstFace + f);
		std::array<std::uint32_t, 3> corners;
		for (std::size_t i = 0; i < 3; ++i)
			corners[i] = number.emplace(Key{t[i].x, t[i].y, t[i].z}, std::uint32_t(number.size())).first->second;
		mesh.triangles.push_back(corners);
	}
	mesh.vertexCount = number.size();
	return mesh;
}

using EdgeMap = std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>;  // directed edge to face

// Adds every directed edge; the first face that repeats one, or kNone.
std::uint32_t directedEdges(const LevelMesh& mesh, EdgeMap& edges)
{
	for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
		for (std::size_t e = 0; e < 3; ++e)
			if (!edges.emplace(std::pair(mesh.triangles[f][e], mesh.triangles[f][(e + 1) % 3]), f).second) return f;
	return kNone;
}

// Faces round each vertex reached by turning from edge to edge, against all faces at it.
std::uint32_t firstSplitVertexFace(const LevelMesh& mesh, const EdgeMap& edges)
{
	std::vector<std::uint32_t> facesAt(mesh.vertexCount, 0), start(mesh.vertexCount, kNone);
	for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
		for (const std::uint32_t v : mesh.triangles[f])
		{
			++facesAt[v];
			if (start[v] == kNone) start[v] = f;
		}
	for (std::uint32_t v = 0; v < mesh.vertexCount; ++v)
	{
		std::uint32_t turned = 0, face = start[v];
		do
		{
			const auto& t = mesh.triangles[face];
			const std::size_t at = t[0] == v ? 0 : t[1] == v ? 1 : 2;
			face = edges.at({v, t[(at + 2) % 3]});  // the face across the edge that enters v
			++turned;
		} while (face != start[v] && turned <= facesAt[v]);
		if (turned != facesAt[v]) return start[v];
	}
	return kNone;
}

void checkLevel(const Subject& s, const Level& level, std::size_t index, Tally& manifold, Tally& connected)
{
	const LevelMesh mesh = numbered(s, level);
	EdgeMap edges;
	std::uint32_t bad = directedEdges(mesh, edges);
	for (const auto& [edge, face] : edges)
	{
		const auto twin = edges.find({edge.second, edge.first});
		if (twin == edges.end()) bad = std::min(bad, face);
		if (twin == edges.end() || bad != kNone) continue;
		const auto& stored = s.h.faces()[level.firstFace + face].neighbour;
		if (std::find(stored, stored + 3, level.firstFace + twin->second) == stored + 3) bad = face;
	}
	if (bad == kNone) bad = firstSplitVertexFace(mesh, edges);
	manifold.add(
		index, bad == kNone ? 0 : 1,
		fmt::format("level {}: the surface is not a closed manifold at face {}", index, level.firstFace + bad));
	if (bad != kNone) return;
	for (std::uint32_t i = 0; i < level.nodeCount; ++i)
	{
		const Node& n = s.h.node(level.firstNode + i);
		std::vector<bool> reached(n.faceCount, false);
		std::vector<std::uint32_t> open = {0};
		reached[0] = true;
		std::size_t count = 0;
		while (!open.empty())
		{
			const std::uint32_t local = open.back();
			open.pop_back();
			++count;
			const auto& t = mesh.triangles[n.firstFace + local - level.firstFace];
			for (std::size_t e = 0; e < 3; ++e)
			{
				const std::uint32_t other = edges.at({t[(e + 1) % 3], t[e]}) + level.firstFace - n.firstFace;
				if (other >= n.faceCount || reached[other]) continue;
				reached[other] = true;
				open.push_back(other);
			}
		}
		connected.add(
			level.firstNode + i, count == n.faceCount ? 0 : 1,
			fmt::format("node {}: {} of its {} faces hang together", level.firstNode + i, count, n.faceCount));
	}
}

// Normals, offsets and cones of the face records against the stored vertices.
Invariant faceRecords(const Subject& s)
{
	Tally tally("face-records");
	for (std::uint32_t f = 0; f < s.h.faces().size; ++f)
	{
		const Face& face = s.h.faces()[f];
		const Node& n = s.h.node(s.ownerOfFace[f]);
		const Triangle t = s.triangle(f);
		const Vec3 normal = toVec3(face.normal), area = cross(t[1] - t[0], t[2] - t[0]);
		const double top = std::max({dot(normal, t[0]), dot(normal, t[1]), dot(normal, t[2])});
		double longest = 0;
		for (std::size_t e = 0; e < 3; ++e) longest = std::max(longest, length(t[(e + 1) % 3] - t[e]));
		const double noise = 4e-16 * (1 + longest * longest / std::max(length(area), 1e-300));
		bool sound = isNextAbove(face.offset, top, 1e-15 * s.radius) &&
					 dot(normal, toVec3(n.meanNormal)) >= double(n.coneCosine) - 1e-5 &&
					 double(face.thickness) <= 0.03 * s.radius * (1 + 1e-5);
		for (int k = 0; k < 3; ++k)
			sound = sound && (area == Vec3{} || isNearestOf(face.normal[k], normalized(area)[k], noise));
		tally.add(f, sound ? 0 : 1, fmt::format("face {}: normal, offset, cone or thickness is wrong", f));
	}
	return tally.result();
}
// Every hull vertex of a contact node is a corner of one of its faces, and none is there twice.
Invariant nodeVertices(const Subject& s)
{
	Tally tally("node-vertices");
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		const Node& n = s.h.node(i);
		if (!s.isContact(i)) continue;
		std::vector<bool> used(n.vertexCount, false);
		for (const Face& face : s.h.faces(n))
			for (const std::uint16_t v : face.vertex) used[v] = true;
		std::map<Key, std::uint32_t> places;
		for (std::uint32_t v = 0; v < n.vertexCount; ++v)
		{
			const Vec3 p = s.h.hull(n).vertex(v);
			places.emplace(Key{p.x, p.y, p.z}, v);
		}
		const bool sound = std::find(used.begin(), used.end(), false) == used.end() && places.size() == n.vertexCount;
		tally.add(i, sound ? 0 : 1, fmt::format("node {}: a vertex belongs to no face, or is there twice", i));
	}
	return tally.result();
}
}  // namespace

Invariants checkSurfaces(const Subject& s)
{
	Tally manifold("level-manifold"), connected("patch-connected");
	for (std::size_t k = 0; k < s.h.levels().size; ++k)
		if (s.h.levels()[k].faceCount > 0) checkLevel(s, s.h.levels()[k], k, manifold, connected);
	return {manifold.result(), connected.result(), faceRecords(s), nodeVertices(s)};
}
}  // namespace clod::check
