// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/CleanSoup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "builder/intake/Intake.h"

namespace clod::builder
{
namespace
{
using Triangle = std::array<std::uint32_t, 3>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

Edge edgeOf(const Triangle& t, std::size_t e)
{
	return std::minmax(t[e], t[(e + 1) % 3]);
}

// Counts elements and remembers the first for a sentence of the report.
struct Tally
{
	std::size_t count = 0, first = 0;
	void add(std::size_t element)
	{
		if (count++ == 0) first = element;
	}
	void tell(Changes& changes, const std::string& what) const
	{
		if (count > 0) changes.push_back(fmt::format("{} {} (the first: face {})", count, what, first));
	}
};

bool isFinitePolygon(const Soup& soup, std::size_t polygon)
{
	for (std::size_t c = soup.polygonBegin(polygon); c < soup.polygonEnd[polygon]; ++c)
		if (soup.corners[c] < soup.vertices.size() && !isFinite(soup.vertices[soup.corners[c]])) return false;
	return true;
}

// Corners of a polygon without those that repeat the one before; all indices are in range.
std::vector<std::uint32_t> distinctCorners(const Soup& soup, const std::vector<std::uint32_t>& place,
										   std::size_t polygon)
{
	std::vector<std::uint32_t> corners;
	for (std::size_t c = soup.polygonBegin(polygon); c < soup.polygonEnd[polygon]; ++c)
	{
		const std::uint32_t corner = place[soup.corners[c]];
		if (corners.empty() || corners.back() != corner) corners.push_back(corner);
	}
	while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
	return corners;
}

// A polygon as file and winding leave it, and the way it is cut: from its lowest vertex towards the lower neighbour, so
// that the same polygon facing the other way gets the same triangles.
std::vector<std::uint32_t> canonicalOrder(const std::vector<std::uint32_t>& corners)
{
	const std::size_t n = corners.size();
	const std::size_t low = std::size_t(std::min_element(corners.begin(), corners.end()) - corners.begin());
	const bool forward = corners[(low + 1) % n] <= corners[(low + n - 1) % n];
	std::vector<std::uint32_t> order;
	for (std::size_t i = 0; i < n; ++i) order.push_back(std::uint32_t((low + (forward ? i : n - i)) % n));
	return order;
}

// Corner numbers, three a triangle, wound as the polygon; a polygon that has no ear becomes a fan.
std::vector<std::uint32_t> cutPolygon(const std::vector<std::uint32_t>& corners, const std::vector<Vec3>& vertices,
									  std::size_t polygon, bool& crossed)
{
	if (corners.size() > kPolygonCornerLimit)
		throw Refused(Reason::limit, fmt::format("face {} has {} corners; the limit is {}", polygon, corners.size(),
												 kPolygonCornerLimit));
	if (corners.size() < 3) return {};
	const std::vector<std::uint32_t> order = canonicalOrder(corners);
	std::vector<Vec3> places;
	for (const std::uint32_t corner : order) places.push_back(vertices[corners[corner]]);
	std::vector<std::uint32_t> cut = {0, 1, 2};
	if (corners.size() > 3) cut = cutEars(places);
	crossed = cut.empty();
	for (std::uint32_t i = 2; crossed && i < corners.size(); ++i) cut.insert(cut.end(), {0, i - 1, i});
	const bool turned = order[1] != (order[0] + 1) % corners.size();
	for (std::size_t i = 0; i < cut.size(); i += 3)
	{
		for (std::size_t k = i; k < i + 3; ++k) cut[k] = order[cut[k]];
		if (turned) std::swap(cut[i + 1], cut[i + 2]);
	}
	return cut;
}

bool hasArea(const Vec3& a, const Vec3& b, const Vec3& c)
{
	return lengthSquared(cross(b - a, c - a)) > 0;
}

// Keeps the triangles for which keep is true.
void filter(WeldedMesh& mesh, const std::vector<bool>& keep)
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

bool repeatsACorner(const Triangle& t)
{
	return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

std::map<Edge, std::uint32_t> facesAtEdges(const WeldedMesh& mesh, const std::vector<bool>& keep)
{
	std::map<Edge, std::uint32_t> faces;
	for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
		for (std::size_t e = 0; e < 3 && keep[i]; ++e) ++faces[edgeOf(mesh.triangles[i], e)];
	return faces;
}

// Sets of triangles with the same corners, each in the order of the file.
std::vector<std::vector<std::uint32_t>> sameCorners(const WeldedMesh& mesh)
{
	std::map<Triangle, std::vector<std::uint32_t>> sets;
	for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		Triangle key = mesh.triangles[i];
		std::sort(key.begin(), key.end());
		sets[key].push_back(i);
	}
	std::vector<std::vector<std::uint32_t>> repeated;
	for (auto& [key, members] : sets)
		if (members.size() > 1) repeated.push_back(std::move(members));
	return repeated;
}

bool isEvenPermutation(const Triangle& t)
{
	return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2;
}
}  // namespace

double extentOf(const std::vector<Vec3>& vertices)
{
	Vec3 low = vertices.front(), high = low;
	for (const Vec3& v : vertices)
		for (int i = 0; i < 3; ++i)
		{
			low[i] = std::min(low[i], v[i]);
			high[i] = std::max(high[i], v[i]);
		}
	return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

WeldedMesh usableFaces(const Soup& soup, Changes& changes)
{
	Soup usable;
	usable.vertices = soup.vertices;
	for (Vec3& v : usable.vertices)
		if (!isFinite(v)) v = {};  // in no face that is kept
	const std::vector<std::uint32_t> place = firstAtSamePlace(usable.vertices);
	std::vector<std::uint32_t> polygonInFile;
	Tally notFinite, noArea, fans;
	const auto keep = [&](std::initializer_list<std::uint32_t> corners, std::size_t polygon)
	{
		usable.corners.insert(usable.corners.end(), corners);
		usable.endPolygon();
		polygonInFile.push_back(std::uint32_t(polygon));
	};
	for (std::size_t polygon = 0; polygon < soup.polygonCount(); ++polygon)
	{
		for (std::size_t c = soup.polygonBegin(polygon); c < soup.polygonEnd[polygon]; ++c)
			if (soup.corners[c] >= soup.vertices.size())
				throw Refused(Reason::indexOutOfRange, fmt::format("face {}: vertex index {} (from 0) with {} vertices",
																   polygon, soup.corners[c], soup.vertices.size()));
		if (!isFinitePolygon(soup, polygon))
		{
			notFinite.add(polygon);
			continue;
		}
		const std::vector<std::uint32_t> corners = distinctCorners(soup, place, polygon);
		bool crossed = false;
		const std::vector<std::uint32_t> cut = cutPolygon(corners, usable.vertices, polygon, crossed);
		if (crossed) fans.add(polygon);
		std::size_t kept = 0;
		for (std::size_t i = 0; i < cut.size(); i += 3)
		{
			const std::uint32_t a = corners[cut[i]], b = corners[cut[i + 1]], c = corners[cut[i + 2]];
			if (!hasArea(usable.vertices[a], usable.vertices[b], usable.vertices[c])) continue;
			keep({a, b, c}, polygon);
			++kept;
		}
		if (kept == 0) noArea.add(polygon);
	}
	notFinite.tell(changes, "faces dropped for coordinates that are not finite");
	noArea.tell(changes, "faces without area dropped");
	fans.tell(changes, "crossed polygons cut into fans");
	if (usable.polygonCount() == 0) throw Refused(Reason::empty, "no face of the mesh has an area");
	WeldedMesh mesh = weldAndTriangulate(usable);
	for (std::uint32_t& polygon : mesh.polygonInFile) polygon = polygonInFile[polygon];
	return mesh;
}

void sewCracks(WeldedMesh& mesh, double tolerance, Changes& changes)
{
	std::vector<bool> onBorder(mesh.vertices.size(), false);
	for (const auto& [edge, faces] : facesAtEdges(mesh, std::vector<bool>(mesh.triangles.size(), true)))
		if (faces == 1) onBorder[edge.first] = onBorder[edge.second] = true;
	std::vector<std::uint32_t> border, target(mesh.vertices.size());
	for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
	{
		target[v] = v;
		if (onBorder[v]) border.push_back(v);
	}
	std::sort(border.begin(), border.end(),
			  [&](std::uint32_t a, std::uint32_t b)
			  { return std::make_pair(mesh.vertices[a].x, a) < std::make_pair(mesh.vertices[b].x, b); });
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
	for (Triangle& t : mesh.triangles)
	{
		for (std::uint32_t& v : t) v = target[v];
		keep.push_back(!repeatsACorner(t));
	}
	filter(mesh, keep);
	changes.push_back(fmt::format("{} vertices on open edges sewn to others at most {:.3g} away (the first: vertex {})",
								  sewn, farthest, first));
}

namespace
{
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

// One open edge of each triangle; number of triangles split.
void splitOnce(WeldedMesh& mesh, double tolerance, Tally& split)
{
	const auto faces = facesAtEdges(mesh, std::vector<bool>(mesh.triangles.size(), true));
	std::vector<bool> onBorder(mesh.vertices.size(), false);
	for (const auto& [edge, count] : faces)
		if (count == 1) onBorder[edge.first] = onBorder[edge.second] = true;
	std::vector<std::uint32_t> border;
	for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
		if (onBorder[v]) border.push_back(v);
	std::sort(border.begin(), border.end(),
			  [&](std::uint32_t a, std::uint32_t b)
			  { return std::make_pair(mesh.vertices[a].x, a) < std::make_pair(mesh.vertices[b].x, b); });
	const std::size_t count = mesh.triangles.size();
	for (std::size_t i = 0; i < count; ++i)
		for (std::size_t e = 0; e < 3; ++e)
		{
			const Triangle t = mesh.triangles[i];
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

void splitAtTJunctions(WeldedMesh& mesh, double tolerance, Changes& changes)
{
	Tally split;
	for (std::size_t before = std::size_t(-1); split.count != before;)
	{
		before = split.count;
		splitOnce(mesh, tolerance, split);
	}
	split.tell(changes, "faces split where corners of others lie on their open edges");
}

void dropRepeatedFaces(WeldedMesh& mesh, Changes& changes)
{
	const auto sets = sameCorners(mesh);
	if (sets.empty()) return;
	// Without the pairs that face both ways; of the others the first stays.
	std::vector<bool> keep(mesh.triangles.size(), true), paired(mesh.triangles.size(), false);
	for (const auto& members : sets)
	{
		std::size_t even = 0;
		for (const std::uint32_t i : members) even += isEvenPermutation(mesh.triangles[i]) ? 1 : 0;
		const bool bothWays = 2 * even == members.size();
		for (const std::uint32_t i : members)
		{
			keep[i] = false;
			paired[i] = bothWays;
		}
		if (!bothWays) keep[members.front()] = true;
	}
	std::vector<std::uint32_t> componentOf;
	std::vector<bool> survives(components(mesh, componentOf), false);
	for (std::size_t i = 0; i < keep.size(); ++i)
		if (keep[i]) survives[componentOf[i]] = true;
	const auto faces = facesAtEdges(mesh, keep);
	Tally repeated, pairs;
	for (const auto& members : sets)
	{
		const std::uint32_t first = members.front();
		bool opens = false;
		for (std::size_t e = 0; e < 3; ++e)
		{
			const auto found = faces.find(edgeOf(mesh.triangles[first], e));
			opens = opens || (found != faces.end() && found->second % 2 == 1);
		}
		if (paired[first] && (opens || !survives[componentOf[first]])) keep[first] = true;
		Tally& tally = keep[first] ? repeated : pairs;
		for (const std::uint32_t i : members)
			if (!keep[i]) tally.add(mesh.polygonInFile[i]);
	}
	repeated.tell(changes, "faces dropped that repeat another one");
	pairs.tell(changes, "faces dropped that face both ways (walls between touching parts)");
	filter(mesh, keep);
}
}  // namespace clod::builder
