// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/Cracks.h"

#include <numeric>

#include "builder/repair/FaceEdits.h"

namespace clod::builder
{
namespace
{
// Vertices of open edges, sorted by x.
std::vector<std::uint32_t> borderByX(const WeldedMesh& mesh, const std::map<FaceEdge, std::uint32_t>& faces)
{
	std::vector<bool> onBorder(mesh.vertices.size(), false);
	for (const auto& [edge, count] : faces)
		if (count == 1) onBorder[edge.first] = onBorder[edge.second] = true;
	std::vector<std::uint32_t> border;
	for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
		if (onBorder[v]) border.push_back(v);
	std::sort(border.begin(), border.end(),
			  [&](std::uint32_t a, std::uint32_t b)
			  { return std::make_pair(mesh.vertices[a].x, a) < std::make_pair(mesh.vertices[b].x, b); });
	return border;
}

// Vertices of open edges on the inside of the segment a b, from a to b. `border` is sorted by x.
std::vector<std::uint32_t> verticesOn(const WeldedMesh& mesh, const std::vector<std::uint32_t>& border, std::uint32_t a,
									  std::uint32_t b, double tolerance)
{
	const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b];
	const double l = length(q - p), low = std::min(p.x, q.x) - tolerance, high = std::max(p.x, q.x) + tolerance;
	const auto begin = std::lower_bound(border.begin(), border.end(), low,
										[&](std::uint32_t v, double x) { return mesh.vertices[v].x < x; });
	std::vector<std::pair<double, std::uint32_t>> found;
	for (auto v = begin; v != border.end() && mesh.vertices[*v].x <= high; ++v)
	{
		const double along = dot(mesh.vertices[*v] - p, q - p) / l;
		if (*v == a || *v == b || along <= tolerance || along >= l - tolerance) continue;
		if (length(mesh.vertices[*v] - p - (along / l) * (q - p)) <= tolerance) found.emplace_back(along, *v);
	}
	std::sort(found.begin(), found.end());
	std::vector<std::uint32_t> ordered;
	for (const auto& [along, v] : found) ordered.push_back(v);
	return ordered;
}

// One open edge of each triangle.
void splitOnce(WeldedMesh& mesh, double tolerance, FaceTally& split)
{
	const auto faces = facesAtEdges(mesh);
	const std::vector<std::uint32_t> border = borderByX(mesh, faces);
	const std::size_t count = mesh.triangles.size();
	for (std::size_t i = 0; i < count; ++i)
		for (std::size_t e = 0; e < 3; ++e)
		{
			const Corners t = mesh.triangles[i];
			const std::uint32_t a = t[e], b = t[(e + 1) % 3], c = t[(e + 2) % 3];
			if (faces.at(edgeOf(t, e)) != 1) continue;
			std::vector<std::uint32_t> on = verticesOn(mesh, border, a, b, tolerance);
			on.erase(std::remove(on.begin(), on.end(), c), on.end());
			if (on.empty()) continue;
			split.add(mesh.polygonInFile[i]);
			mesh.triangles[i] = {a, on.front(), c};
			on.push_back(b);
			for (std::size_t k = 1; k < on.size(); ++k)
			{
				mesh.triangles.push_back({on[k - 1], on[k], c});
				mesh.polygonInFile.push_back(mesh.polygonInFile[i]);
			}
			break;
		}
}
}  // namespace

void sewCracks(WeldedMesh& mesh, double tolerance, Changes& changes)
{
	const auto border = borderByX(mesh, facesAtEdges(mesh));
	std::vector<std::uint32_t> target(mesh.vertices.size());
	std::iota(target.begin(), target.end(), 0u);
	std::size_t sewn = 0, first = 0;
	double farthest = 0;
	for (std::size_t i = 0; i < border.size(); ++i)
	{
		if (target[border[i]] != border[i]) continue;
		const Vec3& p = mesh.vertices[border[i]];
		for (std::size_t j = i + 1; j < border.size() && mesh.vertices[border[j]].x - p.x <= tolerance; ++j)
		{
			const double gap = length(mesh.vertices[border[j]] - p);
			if (target[border[j]] != border[j] || gap > tolerance) continue;
			target[border[j]] = border[i];
			farthest = std::max(farthest, gap);
			if (sewn++ == 0) first = mesh.vertexInFile[border[j]];
		}
	}
	if (sewn == 0) return;
	std::vector<bool> keep;
	for (Corners& t : mesh.triangles)
	{
		for (std::uint32_t& v : t) v = target[v];
		keep.push_back(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
	}
	keepFaces(mesh, keep);
	changes.push_back(fmt::format("{} on open edges sewn to others at most {:.3g} away (the first: vertex {})",
								  counted(sewn, "vertex", "vertices"), farthest, first));
}

void splitAtTJunctions(WeldedMesh& mesh, double tolerance, Changes& changes)
{
	FaceTally split;
	for (std::size_t before = std::size_t(-1); split.count != before;)
	{
		before = split.count;
		splitOnce(mesh, tolerance, split);
	}
	split.tell(changes, "split where corners of others lie on their open edges");
}
}  // namespace clod::builder
