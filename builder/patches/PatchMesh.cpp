// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/patches/PatchMesh.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace clod::builder
{
Box boxOf(const TrianglePoints& t)
{
	Box box;
	for (const Vec3& p : t) box.include(p);
	return box;
}

PatchMesh::PatchMesh(const Mesh& mesh)
	: positions(mesh.vertices),
	  faces(mesh.triangles),
	  adjacent(mesh.triangles.size()),
	  planes(mesh.triangles.size()),
	  star(mesh.vertices.size()),
	  label(mesh.triangles.size()),
	  leaning(mesh.triangles.size()),
	  patches(mesh.triangles.size()),
	  faceCount(mesh.triangles.size()),
	  patchCount(mesh.triangles.size())
{
	Box bounds;
	for (const Vec3& p : positions) bounds.include(p);
	radius = positions.empty() ? 0 : 0.5 * length(bounds.high - bounds.low);
	for (std::uint32_t f = 0; f < faces.size(); ++f)
	{
		label[f] = f;
		patches[f].faces = {f};
		for (const std::uint32_t v : faces[f]) star[v].push_back(f);
		const TrianglePoints t = points(f);
		planes[f] = planeOf(t[0], t[1], t[2]);
		patches[f].box = boxOf(t);
	}
	link(mesh);
	rebuildTrees();
}

void PatchMesh::link(const Mesh& mesh)
{
	for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
		for (int k = 0; k < 3; ++k)
		{
			const std::uint32_t a = faces[f][std::size_t(k)], b = faces[f][std::size_t((k + 1) % 3)];
			std::uint32_t found = kNone;
			for (const std::uint32_t g : star[b])
			{
				const int corner = cornerOf(g, b);
				if (faces[g][std::size_t((corner + 1) % 3)] == a) found = g;
			}
			if (found == kNone) throw std::invalid_argument("an edge of the mesh has no second face");
			adjacent[f][std::size_t(k)] = found;
		}
}

double PatchMesh::edgeHeight(std::uint32_t face, int k) const
{
	const std::uint32_t other = adjacent[face][std::size_t(k)];
	const std::uint32_t start = faces[face][std::size_t(k)];
	const std::uint32_t ownFar = faces[face][std::size_t(opposite(k))];
	const int corner = cornerOf(other, start);  // the other face runs the edge backwards, from end to start
	const std::uint32_t otherFar = faces[other][std::size_t((corner + 1) % 3)];
	return std::max(planes[face].height(positions[otherFar]), planes[other].height(positions[ownFar]));
}

Box PatchMesh::boxOfPatch(std::uint32_t patch) const
{
	Box box;
	for (const std::uint32_t f : patches[patch].faces) box.include(boxOf(points(f)));
	return box;
}

void PatchMesh::setHull(std::uint32_t patch, std::vector<Plane> hull)
{
	patches[patch].hull = std::move(hull);
	patches[patch].box = boxOfPatch(patch);
	patchTree.update(patch, patches[patch].box);
}

void PatchMesh::join(std::uint32_t into, std::uint32_t from, std::vector<Plane> hull)
{
	Patch &a = patches[into], &b = patches[from];
	for (const std::uint32_t f : b.faces) label[f] = into;
	a.faces.insert(a.faces.end(), b.faces.begin(), b.faces.end());
	a.kids.insert(a.kids.end(), b.kids.begin(), b.kids.end());
	a.resolution = smallerResolution(a.resolution, b.resolution);
	b = Patch{};
	patchTree.update(from, b.box);
	setHull(into, std::move(hull));
	--patchCount;
}

void PatchMesh::split(std::uint32_t patch)
{
	const Patch whole = std::move(patches[patch]);
	patches[patch] = Patch{};
	patchTree.update(patch, patches[patch].box);
	for (const std::uint32_t f : whole.faces)
	{
		label[f] = f;
		patches[f].faces = {f};
		patches[f].resolution = whole.resolution;
		setHull(f, {});
	}
	patches[whole.faces[0]].kids = whole.kids;
	patchCount += whole.faces.size() - 1;
}

void PatchMesh::dissolve()
{
	std::vector<Patch> single(faces.size());
	for (std::uint32_t f = 0; f < faces.size(); ++f)
	{
		leaning[f].clear();
		if (!isAlive(f)) continue;
		single[f].faces = {f};
		single[f].box = boxOf(points(f));
		single[f].resolution = patches[label[f]].resolution;
		label[f] = f;
	}
	patches = std::move(single);
	patchCount = faceCount;
	rebuildTrees();
}

// Entries are never removed: a stale one costs a test.
void PatchMesh::lean(std::uint32_t patch, const std::vector<std::uint32_t>& supports)
{
	for (const std::uint32_t f : supports)
		if (std::find(leaning[f].begin(), leaning[f].end(), patch) == leaning[f].end()) leaning[f].push_back(patch);
}

void PatchMesh::refreshFace(std::uint32_t face)
{
	const TrianglePoints t = points(face);
	planes[face] = planeOf(t[0], t[1], t[2]);
	faceTree.update(face, boxOf(t));
}

void PatchMesh::rebuildTrees()
{
	std::vector<Box> boxes(faces.size());
	for (std::uint32_t f = 0; f < faces.size(); ++f)
		if (isAlive(f)) boxes[f] = boxOf(points(f));
	faceTree.build(boxes);
	boxes.resize(patches.size());
	for (std::uint32_t p = 0; p < patches.size(); ++p) boxes[p] = patches[p].box;
	patchTree.build(boxes);
}
}  // namespace clod::builder
