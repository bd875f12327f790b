// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see Decompose.h.
#include "builder/patches/Decompose.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
// Connected components of the surface, each as its faces.
std::vector<std::vector<std::uint32_t>> componentsOf(const PatchMesh& mesh)
{
	std::vector<std::vector<std::uint32_t>> components;
	std::vector<char> seen(mesh.faces.size(), 0);
	for (std::uint32_t seed = 0; seed < mesh.faces.size(); ++seed)
	{
		if (seen[seed] || !mesh.isAlive(seed)) continue;
		seen[seed] = 1;
		std::vector<std::uint32_t> faces = {seed};
		for (std::size_t i = 0; i < faces.size(); ++i)
			for (const std::uint32_t next : mesh.adjacent[faces[i]])
				if (!seen[next])
				{
					seen[next] = 1;
					faces.push_back(next);
				}
		components.push_back(std::move(faces));
	}
	return components;
}

// The planes of its faces are then the whole hull. Quadratic, but only reached by surfaces whose edges are all convex.
bool isConvexComponent(const PatchMesh& mesh, const std::vector<std::uint32_t>& faces, double tolerance)
{
	for (const std::uint32_t f : faces)
		for (int k = 0; k < 3; ++k)
			if (mesh.edgeHeight(f, k) > tolerance) return false;
	std::vector<Vec3> corners;
	for (const std::uint32_t f : faces)
		for (const std::uint32_t v : mesh.faces[f])
			if (mesh.star[v][0] == f) corners.push_back(mesh.positions[v]);
	if (corners.size() > kVertexLimit) return false;
	for (const std::uint32_t f : faces)
		for (const Vec3& p : corners)
			if (mesh.planes[f].height(p) > 2 * tolerance) return false;
	return true;
}

bool isFreeOfOthers(const PatchMesh& mesh, const std::vector<std::uint32_t>& faces, double tolerance)
{
	std::vector<char> own(mesh.faces.size(), 0);
	std::vector<Plane> planes;
	Box box;
	for (const std::uint32_t f : faces)
	{
		own[f] = 1;
		planes.push_back(mesh.planes[f]);
		box.include(boxOf(mesh.points(f)));
	}
	return mesh.faceTree.search(
		box, [&](std::uint32_t face) { return own[face] || !entersHull(mesh.points(face), planes, 4 * tolerance); });
}

void adopt(PatchMesh& mesh, const std::vector<std::uint32_t>& faces, std::vector<Plane> hull)
{
	const std::uint32_t patch = faces[0];
	double resolution = 0;
	for (const std::uint32_t f : faces)
	{
		resolution = smallerResolution(resolution, mesh.patches[f].resolution);
		mesh.label[f] = patch;
		mesh.patches[f].faces.clear();
		mesh.patches[f].box = {};
	}
	mesh.patches[patch].faces = faces;
	mesh.patches[patch].resolution = resolution;
	mesh.patches[patch].hull = std::move(hull);
	mesh.patches[patch].box = mesh.boxOfPatch(patch);
	mesh.patchCount -= faces.size() - 1;
}

std::vector<std::uint32_t> growFrom(const PatchMesh& mesh, Validity& validity, std::uint32_t seed,
									std::vector<std::uint32_t>& triedFor, const std::vector<char>& taken)
{
	validity.clear();
	validity.grow(seed);
	std::vector<std::uint32_t> faces = {seed};
	triedFor[seed] = seed;
	for (std::size_t i = 0; i < faces.size(); ++i)
		for (int k = 0; k < 3 && faces.size() < kFaceLimit; ++k)
		{
			const std::uint32_t next = mesh.adjacent[faces[i]][std::size_t(k)];
			if (taken[next] || triedFor[next] == seed || mesh.edgeHeight(faces[i], k) > validity.tolerance) continue;
			triedFor[next] = seed;
			if (validity.grow(next)) faces.push_back(next);
		}
	return faces;
}

std::vector<std::uint32_t> neighboursOf(const PatchMesh& mesh, std::uint32_t patch)
{
	std::vector<std::uint32_t> result;
	for (const std::uint32_t f : mesh.patches[patch].faces)
		for (const std::uint32_t g : mesh.adjacent[f])
			if (mesh.label[g] != patch) result.push_back(mesh.label[g]);
	std::sort(result.begin(), result.end());
	result.erase(std::unique(result.begin(), result.end()), result.end());
	return result;
}
}  // namespace

void decompose(PatchMesh& mesh, Validity& validity, const Progress& progress)
{
	std::vector<char> taken(mesh.faces.size(), 0);
	for (const auto& component : componentsOf(mesh))
		if (isConvexComponent(mesh, component, validity.tolerance) &&
			isFreeOfOthers(mesh, component, validity.tolerance) && validity.coversItself(component))
		{
			std::vector<Plane> planes;
			for (const std::uint32_t f : component) planes.push_back(mesh.planes[f]);
			adopt(mesh, component, std::move(planes));
			for (const std::uint32_t f : component) taken[f] = 1;
		}
	std::vector<std::uint32_t> triedFor(mesh.faces.size(), kNone);
	for (std::uint32_t seed = 0; seed < mesh.faces.size(); ++seed)
	{
		if (seed % 1024 == 0) report(progress, "decompose", double(seed) / double(mesh.faces.size()));
		if (taken[seed] || !mesh.isAlive(seed)) continue;
		const auto faces = growFrom(mesh, validity, seed, triedFor, taken);
		for (const std::uint32_t f : faces) taken[f] = 1;
		std::vector<Plane> hull = validity.grownHull();
		validity.isValid(faces);
		adopt(mesh, faces, std::move(hull));
		mesh.lean(seed, validity.supports());
	}
	mesh.rebuildTrees();
	joinEverywhere(mesh, validity);
}

bool tryJoin(PatchMesh& mesh, Validity& validity, std::uint32_t a, std::uint32_t b)
{
	if (mesh.patches[a].faces.size() + mesh.patches[b].faces.size() > kFaceLimit) return false;
	if (!validity.canJoin(a, b)) return false;
	mesh.join(a, b, validity.hull());
	mesh.lean(a, validity.supports());
	return true;
}

std::size_t joinEverywhere(PatchMesh& mesh, Validity& validity)
{
	std::size_t joins = 0;
	for (std::uint32_t a = 0; a < mesh.patches.size(); ++a)
	{
		if (mesh.patches[a].faces.empty()) continue;
		for (bool joined = true; joined;)
		{
			joined = false;
			for (const std::uint32_t b : neighboursOf(mesh, a))
				if (tryJoin(mesh, validity, a, b))
				{
					++joins;
					joined = true;
					break;
				}
		}
	}
	return joins;
}
}  // namespace clod::builder
