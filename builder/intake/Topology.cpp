// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "builder/intake/Intake.h"

namespace clod::builder
{
namespace
{
using Triangle = std::array<std::uint32_t, 3>;

// "face 7 (vertices 3, 4, 9)", numbered as in the file.
std::string describe(const WeldedMesh& mesh, std::size_t triangle)
{
	const Triangle& t = mesh.triangles[triangle];
	return fmt::format("face {} (vertices {}, {}, {})", mesh.polygonInFile[triangle], mesh.vertexInFile[t[0]],
					   mesh.vertexInFile[t[1]], mesh.vertexInFile[t[2]]);
}

using Defects = std::vector<Defect>;

// Appends a defect of `count` elements, if there are any.
void note(Defects& defects, Reason reason, std::size_t count, const std::string& first)
{
	if (count > 0) defects.push_back({reason, first, count});
}

void findDegenerate(const WeldedMesh& mesh, Defects& defects)
{
	std::size_t count = 0;
	std::string first;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		const Triangle& t = mesh.triangles[i];
		if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) continue;
		if (count++ == 0)
			first = describe(mesh, i) + " has two corners at the same place, " + placeOf(mesh.vertices[t[0]]);
	}
	note(defects, Reason::degenerate, count, first);
}

void findDuplicates(const WeldedMesh& mesh, Defects& defects)
{
	std::vector<std::pair<Triangle, std::uint32_t>> sorted;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		Triangle t = mesh.triangles[i];
		std::sort(t.begin(), t.end());
		sorted.emplace_back(t, std::uint32_t(i));
	}
	std::sort(sorted.begin(), sorted.end());
	std::uint32_t repeated = kNone, original = kNone;
	std::size_t count = 0;
	for (std::size_t i = 1; i < sorted.size(); ++i)
	{
		if (sorted[i].first != sorted[i - 1].first) continue;
		++count;
		if (sorted[i].second >= repeated) continue;
		repeated = sorted[i].second;
		original = sorted[i - 1].second;
	}
	if (count > 0)
		note(defects, Reason::duplicate, count,
			 fmt::format("{} has the same corners as face {}, at {}", describe(mesh, repeated),
						 mesh.polygonInFile[original], placeOf(mesh.vertices[mesh.triangles[repeated][0]])));
}

struct HalfEdge
{
	std::uint32_t low, high;  // its vertices
	std::uint32_t triangle;
	bool forward;  // runs from low to high
	bool sameEdge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

// Sorted by edge, then triangle.
std::vector<HalfEdge> halfEdges(const WeldedMesh& mesh)
{
	std::vector<HalfEdge> edges;
	edges.reserve(3 * mesh.triangles.size());
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		for (std::size_t e = 0; e < 3; ++e)
		{
			const std::uint32_t from = mesh.triangles[i][e], to = mesh.triangles[i][(e + 1) % 3];
			edges.push_back({std::min(from, to), std::max(from, to), std::uint32_t(i), from < to});
		}
	std::sort(edges.begin(), edges.end(),
			  [](const HalfEdge& a, const HalfEdge& b)
			  { return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle); });
	return edges;
}

// The faults of one kind; the one whose first triangle comes first, among the same triangle's the first edge.
struct EdgeFault
{
	std::size_t count = 0;
	std::size_t edge = 0;
	std::uint32_t triangle = kNone;
	std::size_t faces = 0;
};

EdgeFault findFaults(const std::vector<HalfEdge>& edges, Reason wanted)
{
	EdgeFault found;
	for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end)
	{
		while (end < edges.size() && edges[end].sameEdge(edges[begin])) ++end;
		const std::size_t faces = end - begin;
		const bool faulty = wanted == Reason::nonManifoldEdge ? faces > 2
							: wanted == Reason::openBoundary
								? faces == 1
								: faces == 2 && edges[begin].forward == edges[begin + 1].forward;
		if (!faulty) continue;
		const std::size_t count = found.count + 1;
		if (edges[begin].triangle < found.triangle) found = {count, begin, edges[begin].triangle, faces};
		found.count = count;
	}
	return found;
}

void findEdgeFaults(const WeldedMesh& mesh, const std::vector<HalfEdge>& edges, Defects& defects)
{
	for (const Reason wanted : {Reason::nonManifoldEdge, Reason::orientation, Reason::openBoundary})
	{
		const EdgeFault fault = findFaults(edges, wanted);
		if (fault.count == 0) continue;
		const HalfEdge& edge = edges[fault.edge];
		std::string text = fmt::format("edge ({}, {}) of {}", mesh.vertexInFile[edge.low], mesh.vertexInFile[edge.high],
									   describe(mesh, edge.triangle));
		if (wanted == Reason::nonManifoldEdge)
			text += fmt::format(" belongs to {} faces", fault.faces);
		else if (wanted == Reason::openBoundary)
			text += " has no face on its other side";
		else
			text += fmt::format(" runs the same way in face {}", mesh.polygonInFile[edges[fault.edge + 1].triangle]);
		text += ", at " + placeOf(0.5 * (mesh.vertices[edge.low] + mesh.vertices[edge.high]));
		note(defects, wanted, fault.count, text);
	}
}

class Sets
{
public:
	explicit Sets(std::size_t count) : m_parent(count) { std::iota(m_parent.begin(), m_parent.end(), 0u); }
	std::uint32_t find(std::uint32_t i)
	{
		while (m_parent[i] != i) i = m_parent[i] = m_parent[m_parent[i]];
		return i;
	}
	void join(std::uint32_t a, std::uint32_t b)
	{
		a = find(a);
		b = find(b);
		m_parent[std::max(a, b)] = std::min(a, b);
	}

private:
	std::vector<std::uint32_t> m_parent;
};

std::uint32_t cornerAt(const WeldedMesh& mesh, std::uint32_t triangle, std::uint32_t vertex)
{
	const Triangle& t = mesh.triangles[triangle];
	return 3 * triangle + (t[0] == vertex ? 0u : t[1] == vertex ? 1u : 2u);
}

// The corners round a vertex, joined across edges, must be one fan. What a faulty edge joins counts as joined, so that
// the fault is not named twice.
void findFans(const WeldedMesh& mesh, const std::vector<HalfEdge>& edges, Defects& defects)
{
	Sets corners(3 * mesh.triangles.size());
	for (std::size_t i = 0; i + 1 < edges.size(); ++i)
	{
		if (!edges[i].sameEdge(edges[i + 1])) continue;
		for (const std::uint32_t vertex : {edges[i].low, edges[i].high})
			corners.join(cornerAt(mesh, edges[i].triangle, vertex), cornerAt(mesh, edges[i + 1].triangle, vertex));
	}
	std::vector<std::uint32_t> fan(mesh.vertices.size(), kNone);
	std::vector<bool> faulty(mesh.vertices.size(), false);
	std::size_t count = 0;
	std::string first;
	for (std::uint32_t i = 0; i < 3 * mesh.triangles.size(); ++i)
	{
		const std::uint32_t vertex = mesh.triangles[i / 3][i % 3];
		if (fan[vertex] == kNone) fan[vertex] = corners.find(i);
		if (fan[vertex] == corners.find(i) || faulty[vertex]) continue;
		faulty[vertex] = true;
		if (count++ == 0)
			first = fmt::format("vertex {} joins separate fans, one with face {}, one with face {}, at {}",
								mesh.vertexInFile[vertex], mesh.polygonInFile[fan[vertex] / 3],
								mesh.polygonInFile[i / 3], placeOf(mesh.vertices[vertex]));
	}
	note(defects, Reason::nonManifoldVertex, count, first);
}
}  // namespace

std::vector<Defect> topologyDefects(const WeldedMesh& mesh)
{
	Defects defects;
	findDegenerate(mesh, defects);
	findDuplicates(mesh, defects);
	if (!defects.empty() && defects.front().reason == Reason::degenerate) return defects;  // its edges mean nothing
	const std::vector<HalfEdge> edges = halfEdges(mesh);
	findEdgeFaults(mesh, edges, defects);
	findFans(mesh, edges, defects);
	return defects;
}

void checkTopology(const WeldedMesh& mesh)
{
	const std::vector<Defect> defects = topologyDefects(mesh);
	if (!defects.empty()) throw Refused(defects);
}

std::size_t components(const WeldedMesh& mesh, std::vector<std::uint32_t>& componentOf)
{
	Sets vertices(mesh.vertices.size());
	for (const Triangle& t : mesh.triangles)
	{
		vertices.join(t[0], t[1]);
		vertices.join(t[0], t[2]);
	}
	std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
	componentOf.clear();
	std::uint32_t count = 0;
	for (const Triangle& t : mesh.triangles)
	{
		std::uint32_t& n = number[vertices.find(t[0])];
		if (n == kNone) n = count++;
		componentOf.push_back(n);
	}
	return count;
}
}  // namespace clod::builder
