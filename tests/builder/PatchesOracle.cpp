// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/builder/PatchesOracle.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polyhedron_3.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace clod::builder::test
{
namespace
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Corners = std::array<Vec3, 3>;

Corners cornersOf(const Mesh& mesh, std::size_t f)
{
	const auto& t = mesh.triangles[f];
	return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

struct Side
{
	Vec3 normal;
	double offset;
};

Side sideOf(const Corners& t)
{
	const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
	return {n, std::max({dot(n, t[0]), dot(n, t[1]), dot(n, t[2])})};
}

double distanceToTriangle(const Vec3& p, const Corners& t)
{
	const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
	bool above = true;
	double nearest = 1e300;
	for (std::size_t k = 0; k < 3; ++k)
	{
		const Vec3 &a = t[k], &b = t[(k + 1) % 3];
		if (dot(cross(n, b - a), p - a) < 0) above = false;
		const double along = std::clamp(dot(p - a, b - a) / lengthSquared(b - a), 0.0, 1.0);
		nearest = std::min(nearest, length(p - a - along * (b - a)));
	}
	return above ? std::fabs(dot(n, p - t[0])) : nearest;
}

// Solid angles of van Oosterom and Strackee: 1 inside, 0 outside.
double windingNumber(const Mesh& mesh, const Vec3& p)
{
	double sum = 0;
	for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
	{
		const Corners t = cornersOf(mesh, f);
		const Vec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
		const double la = length(a), lb = length(b), lc = length(c);
		sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
	}
	return sum / (2 * 3.14159265358979323846);
}

// Farther along an axis than the limit: the triangle's distance need not be worked out.
bool isBeyond(const Mesh& mesh, std::size_t f, const Vec3& p, double limit)
{
	const auto& t = mesh.triangles[f];
	const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
	for (int k = 0; k < 3; ++k)
	{
		const double low = p[k] - limit, high = p[k] + limit;
		if ((a[k] > high && b[k] > high && c[k] > high) || (a[k] < low && b[k] < low && c[k] < low)) return true;
	}
	return false;
}

double distanceToSurface(const Mesh& mesh, const Vec3& p)
{
	double nearest = 1e300;
	for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
		if (!isBeyond(mesh, f, p, nearest)) nearest = std::min(nearest, distanceToTriangle(p, cornersOf(mesh, f)));
	return nearest;
}

bool isFarFromSurface(const Mesh& mesh, const Vec3& p, double limit)
{
	for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
		if (!isBeyond(mesh, f, p, limit) && distanceToTriangle(p, cornersOf(mesh, f)) <= limit) return false;
	return true;
}

// The exact hull's triangles; empty where all points lie in a plane.
std::vector<Corners> hullOf(const std::vector<Vec3>& vertices)
{
	std::vector<Point> points;
	for (const Vec3& v : vertices) points.emplace_back(v.x, v.y, v.z);
	bool isFlat = true;
	for (std::size_t i = 3; i < points.size() && isFlat; ++i)
		for (std::size_t j = 2; j < i && isFlat; ++j)
			isFlat = CGAL::coplanar(points[0], points[1], points[j], points[i]);
	if (isFlat || points.size() < 4) return {};
	CGAL::Polyhedron_3<Kernel> hull;
	CGAL::convex_hull_3(points.begin(), points.end(), hull);
	std::vector<Corners> result;
	for (auto f = hull.facets_begin(); f != hull.facets_end(); ++f)
	{
		std::vector<Vec3> ring;
		auto h = f->facet_begin();
		do ring.push_back({h->vertex()->point().x(), h->vertex()->point().y(), h->vertex()->point().z()});
		while (++h != f->facet_begin());
		for (std::size_t k = 2; k < ring.size(); ++k) result.push_back({ring[0], ring[k - 1], ring[k]});
	}
	return result;
}

bool reachesInside(const Corners& t, const std::vector<Side>& sides, double depth)
{
	std::vector<Vec3> polygon(t.begin(), t.end());
	for (const Side& side : sides)
	{
		std::vector<Vec3> rest;
		for (std::size_t i = 0; i < polygon.size(); ++i)
		{
			const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
			const double hp = dot(side.normal, p) - side.offset + depth, hq = dot(side.normal, q) - side.offset + depth;
			if (hp < 0) rest.push_back(p);
			if (hp * hq < 0) rest.push_back(p + hp / (hp - hq) * (q - p));
		}
		polygon = rest;
		if (polygon.size() < 3) return false;
	}
	return true;
}

struct PatchView
{
	std::vector<std::size_t> faces;
	std::vector<Vec3> vertices;
};

std::vector<PatchView> viewsOf(const Lod& lod)
{
	std::vector<PatchView> views(lod.patchCount);
	std::vector<std::set<std::uint32_t>> used(lod.patchCount);
	for (std::size_t f = 0; f < lod.mesh.triangles.size(); ++f)
	{
		views[lod.patchOfTriangle[f]].faces.push_back(f);
		for (const std::uint32_t v : lod.mesh.triangles[f]) used[lod.patchOfTriangle[f]].insert(v);
	}
	for (std::size_t p = 0; p < views.size(); ++p)
		for (const std::uint32_t v : used[p]) views[p].vertices.push_back(lod.mesh.vertices[v]);
	return views;
}

using EdgeMap = std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t>;
EdgeMap edgesOf(const Mesh& mesh)
{
	EdgeMap faces;
	for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
		for (std::size_t k = 0; k < 3; ++k) faces[{mesh.triangles[f][k], mesh.triangles[f][(k + 1) % 3]}] = f;
	return faces;
}

std::string faultOfEdges(const Lod& lod, const EdgeMap& edges, double eps)
{
	std::vector<std::size_t> root(lod.mesh.triangles.size());
	for (std::size_t f = 0; f < root.size(); ++f) root[f] = f;
	const auto find = [&](std::size_t f)
	{
		while (root[f] != f) f = root[f] = root[root[f]];
		return f;
	};
	for (const auto& [edge, f] : edges)
	{
		const std::size_t g = edges.at({edge.second, edge.first});
		if (lod.patchOfTriangle[f] != lod.patchOfTriangle[g]) continue;
		root[find(f)] = find(g);
		const Corners t = cornersOf(lod.mesh, f);
		const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
		for (const Vec3& p : cornersOf(lod.mesh, g))
			if (dot(n, p - t[0]) > eps) return "concave edge inside a patch at triangle " + std::to_string(f);
	}
	std::set<std::size_t> components;
	for (std::size_t f = 0; f < root.size(); ++f) components.insert(find(f));
	return components.size() == lod.patchCount ? "" : "a patch is not edge-connected";
}

// Points of the hull's surface that are neither in the solid nor on its surface: the notch a flat hull spans.
std::string faultOfVirtualFaces(const Lod& lod, const std::vector<Corners>& hull, double eps, std::size_t patch)
{
	for (const Corners& t : hull)
	{
		const Vec3 samples[] = {(1.0 / 3) * (t[0] + t[1] + t[2]), 0.5 * (t[0] + t[1]), 0.5 * (t[1] + t[2]),
								0.5 * (t[2] + t[0])};
		for (const Vec3& p : samples)
			if (isFarFromSurface(lod.mesh, p, 32 * eps) && windingNumber(lod.mesh, p) < 0.5)
				return "the hull of patch " + std::to_string(patch) + " leaves the solid";
	}
	return "";
}

// A flat patch: its outline's hull, sampled along all chords between vertices, must lie on the surface or in
// the solid.
std::string faultOfFlat(const Lod& lod, const PatchView& view, double eps, std::size_t patch)
{
	for (std::size_t i = 0; i < view.vertices.size(); ++i)
		for (std::size_t j = 0; j < i; ++j)
			for (const double s : {0.25, 0.5, 0.75})
			{
				const Vec3 p = view.vertices[i] + s * (view.vertices[j] - view.vertices[i]);
				if (isFarFromSurface(lod.mesh, p, 32 * eps) && windingNumber(lod.mesh, p) < 0.5)
					return "flat patch " + std::to_string(patch) + " spans a notch";
			}
	return "";
}

std::string faultOfPatch(const Lod& lod, const PatchView& view, std::size_t patch, double eps)
{
	for (const std::size_t f : view.faces)
	{
		const Corners t = cornersOf(lod.mesh, f);
		const Vec3 n = normalized(cross(t[1] - t[0], t[2] - t[0]));
		for (const Vec3& v : view.vertices)
			if (dot(n, v - t[0]) > 2 * eps) return "patch " + std::to_string(patch) + " has a vertex above a face";
	}
	const std::vector<Corners> hull = hullOf(view.vertices);
	if (hull.empty()) return faultOfFlat(lod, view, eps, patch);
	std::vector<Side> sides;
	for (const Corners& t : hull) sides.push_back(sideOf(t));
	for (std::size_t f = 0; f < lod.mesh.triangles.size(); ++f)
		if (lod.patchOfTriangle[f] != patch && reachesInside(cornersOf(lod.mesh, f), sides, 4 * eps))
			return "triangle " + std::to_string(f) + " enters the hull of patch " + std::to_string(patch);
	return faultOfVirtualFaces(lod, hull, eps, patch);
}
}  // namespace

double boundingRadius(const Mesh& mesh)
{
	Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
	for (const Vec3& v : mesh.vertices)
		for (int k = 0; k < 3; ++k)
		{
			low[k] = std::min(low[k], v[k]);
			high[k] = std::max(high[k], v[k]);
		}
	return 0.5 * length(high - low);
}

std::string faultOfSurface(const Mesh& mesh)
{
	std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
	std::vector<std::size_t> valence(mesh.vertices.size(), 0);
	for (const auto& t : mesh.triangles)
		for (std::size_t k = 0; k < 3; ++k)
		{
			if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return "a directed edge occurs twice";
			++valence[t[k]];
		}
	for (const auto& [a, b] : edges)
		if (edges.count({b, a}) == 0) return "an edge has no second face";
	std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> fans;  // vertex -> next ring vertex
	for (const auto& t : mesh.triangles)
		for (std::size_t k = 0; k < 3; ++k) fans[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
	for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
	{
		if (valence[v] == 0) return "a vertex is unused";
		const Vec3& p = mesh.vertices[v];
		if (double(float(p.x)) != p.x || double(float(p.y)) != p.y || double(float(p.z)) != p.z)
			return "a vertex is no float";
		std::uint32_t at = fans[v].begin()->first;
		for (std::size_t i = 0; i < valence[v]; ++i)
		{
			if (i > 0 && at == fans[v].begin()->first) return "a vertex has two fans";
			at = fans[v][at];
		}
	}
	for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
	{
		const Corners t = cornersOf(mesh, f);
		if (lengthSquared(cross(t[1] - t[0], t[2] - t[0])) == 0) return "a triangle has no area";
	}
	return "";
}

std::string faultOfPatches(const Lod& lod)
{
	if (lod.patchOfTriangle.size() != lod.mesh.triangles.size()) return "labels and triangles differ in number";
	if (lod.patchResolution.size() != lod.patchCount) return "resolutions and patches differ in number";
	for (const std::uint32_t p : lod.patchOfTriangle)
		if (p >= lod.patchCount) return "a label is out of range";
	const double eps = lod.patchTolerance * (1 + 1e-9) + 1e-12 * boundingRadius(lod.mesh);
	const std::string edgeFault = faultOfEdges(lod, edgesOf(lod.mesh), eps);
	if (!edgeFault.empty()) return edgeFault;
	const std::vector<PatchView> views = viewsOf(lod);
	for (std::size_t p = 0; p < views.size(); ++p)
	{
		const std::string fault = faultOfPatch(lod, views[p], p, eps);
		if (!fault.empty()) return fault;
	}
	return "";
}

std::string faultOfSequence(const LodSequence& sequence)
{
	for (std::size_t k = 0; k + 1 < sequence.lods.size(); ++k)
	{
		const Lod &fine = sequence.lods[k], &coarse = sequence.lods[k + 1];
		if (2 * coarse.patchCount > fine.patchCount) return "a cut keeps more than half of the patches";
		if (coarse.patchTolerance < fine.patchTolerance) return "the tolerance shrinks";
		if (coarse.patchOfChild.empty()) continue;  // grown anew
		if (coarse.patchOfChild.size() != fine.patchCount) return "parents and patches differ in number";
		std::set<std::uint32_t> parents;
		for (std::size_t p = 0; p < coarse.patchOfChild.size(); ++p)
		{
			const std::uint32_t parent = coarse.patchOfChild[p];
			if (parent >= coarse.patchCount) return "a parent is out of range";
			parents.insert(parent);
			const double own = fine.patchResolution[p], above = coarse.patchResolution[parent];
			if (own > 0 && (above <= 0 || above > own)) return "a parent has a finer resolution than its child";
		}
		if (parents.size() != coarse.patchCount) return "a patch has no child";
	}
	if (!sequence.lods.front().patchOfChild.empty()) return "the first level has children";
	return "";
}

long eulerCharacteristic(const Mesh& mesh)
{
	return long(mesh.vertices.size()) - long(mesh.triangles.size()) / 2;
}

double deviation(const Mesh& a, const Mesh& b)
{
	double worst = 0;
	for (std::size_t f = 0; f < a.triangles.size(); ++f)
	{
		const Corners t = cornersOf(a, f);
		for (const Vec3& p :
			 {t[0], 0.5 * (t[0] + t[1]), 0.5 * (t[1] + t[2]), 0.5 * (t[2] + t[0]), (1.0 / 3) * (t[0] + t[1] + t[2])})
			worst = std::max(worst, distanceToSurface(b, p));
	}
	return worst;
}
}  // namespace clod::builder::test
