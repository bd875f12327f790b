// SPDX-License-Identifier: GPL-3.0-or-later
// What the repairs of a welded soup share: edges with the faces that have them, taking faces out, counts for the
// report.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "builder/intake/Triangulate.h"
#include "builder/repair/Changes.h"

namespace clod::builder
{
using FaceEdge = std::pair<std::uint32_t, std::uint32_t>;  // the lower vertex first
using Corners = std::array<std::uint32_t, 3>;              // of a triangle

inline FaceEdge edgeOf(const Corners& t, std::size_t e)
{
	return std::minmax(t[e], t[(e + 1) % 3]);
}

// Counts elements and remembers the first for a sentence of the report.
struct FaceTally
{
	std::size_t count = 0, first = 0;
	void add(std::size_t element)
	{
		if (count++ == 0) first = element;
	}
	void tell(Changes& changes, const std::string& what, const char* one = "face", const char* more = "faces",
			  const char* element = "face") const
	{
		if (count > 0)
			changes.push_back(fmt::format("{} {} (the first: {} {})", counted(count, one, more), what, element, first));
	}
};

// Keeps the triangles for which keep is true.
inline void keepFaces(WeldedMesh& mesh, const std::vector<bool>& keep)
{
	std::size_t kept = 0;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
	{
		if (!keep[i]) continue;
		mesh.triangles[kept] = mesh.triangles[i];
		mesh.polygonInFile[kept++] = mesh.polygonInFile[i];
	}
	mesh.triangles.resize(kept);
	mesh.polygonInFile.resize(kept);
}

// How many of the faces that are kept have each edge.
inline std::map<FaceEdge, std::uint32_t> facesAtEdges(const WeldedMesh& mesh, const std::vector<bool>& keep)
{
	std::map<FaceEdge, std::uint32_t> faces;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		for (std::size_t e = 0; e < 3 && keep[i]; ++e) ++faces[edgeOf(mesh.triangles[i], e)];
	return faces;
}

inline std::map<FaceEdge, std::uint32_t> facesAtEdges(const WeldedMesh& mesh)
{
	return facesAtEdges(mesh, std::vector<bool>(mesh.triangles.size(), true));
}
}  // namespace clod::builder
