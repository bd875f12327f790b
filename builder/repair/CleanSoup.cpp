// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/CleanSoup.h"

#include "builder/intake/Intake.h"
#include "builder/repair/FaceEdits.h"

namespace clod::builder
{
namespace
{
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

// Sets of triangles with the same corners, each in the order of the file.
std::vector<std::vector<std::uint32_t>> sameCorners(const WeldedMesh& mesh)
{
	std::map<Corners, std::vector<std::uint32_t>> sets;
	for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
	{
		Corners key = mesh.triangles[i];
		std::sort(key.begin(), key.end());
		sets[key].push_back(i);
	}
	std::vector<std::vector<std::uint32_t>> repeated;
	for (auto& [key, members] : sets)
		if (members.size() > 1) repeated.push_back(std::move(members));
	return repeated;
}

bool isEvenPermutation(const Corners& t)
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
	FaceTally notNumbers;
	for (std::size_t i = 0; i < usable.vertices.size(); ++i)
	{
		if (isFinite(usable.vertices[i])) continue;
		notNumbers.add(i);
		usable.vertices[i] = {};  // in no face that is kept
	}
	notNumbers.tell(changes, "dropped, not finite", "vertex", "vertices", "vertex");
	const std::vector<std::uint32_t> place = firstAtSamePlace(usable.vertices);
	std::vector<std::uint32_t> polygonInFile;
	FaceTally notFinite, noArea, fans;
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
	notFinite.tell(changes, "dropped for coordinates that are not finite");
	noArea.tell(changes, "dropped, without area");
	fans.tell(changes, "cut into fans", "crossed polygon", "crossed polygons");
	if (usable.polygonCount() == 0) throw Refused(Reason::empty, "no face of the mesh has an area");
	WeldedMesh mesh = weldAndTriangulate(usable);
	for (std::uint32_t& polygon : mesh.polygonInFile) polygon = polygonInFile[polygon];
	return mesh;
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
	FaceTally repeated, pairs;
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
		FaceTally& tally = keep[first] ? repeated : pairs;
		for (const std::uint32_t i : members)
			if (!keep[i]) tally.add(mesh.polygonInFile[i]);
	}
	repeated.tell(changes, "dropped that repeat another one");
	pairs.tell(changes, "dropped that face both ways (walls between touching parts)");
	keepFaces(mesh, keep);
}
}  // namespace clod::builder
