// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bullet/PatchHierarchy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include <clod/hierarchy/BoundGrid.h>

namespace clod::test
{
namespace
{
constexpr double kLoose = 1 + 1e-5;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Patches in the order of their centres along a space-filling curve, so that neighbours share parents.
std::vector<std::uint32_t> spatialOrder(const std::vector<Vec3>& centers)
{
	Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
	for (const Vec3& c : centers)
		for (int i = 0; i < 3; ++i)
		{
			low[i] = std::min(low[i], c[i]);
			high[i] = std::max(high[i], c[i]);
		}
	std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
	for (std::uint32_t i = 0; i < centers.size(); ++i)
	{
		std::uint64_t key = 0;
		for (int bit = 9; bit >= 0; --bit)
			for (int axis = 0; axis < 3; ++axis)
			{
				const double extent = std::max(high[axis] - low[axis], 1e-30);
				const auto cell = std::uint64_t(1023 * (centers[i][axis] - low[axis]) / extent);
				key = key * 2 + (cell >> bit & 1);
			}
		keyed.push_back({key, i});
	}
	std::sort(keyed.begin(), keyed.end());
	std::vector<std::uint32_t> order;
	for (const auto& entry : keyed) order.push_back(entry.second);
	return order;
}

struct Maker
{
	PatchedMesh mesh;
	HierarchyContent out;
	std::vector<std::vector<std::uint32_t>> members;  // triangles of each patch
	std::vector<Vec3> normals;

	void massProperties();
	void bounds();
	double thickness() const { return std::min(0.5 * mesh.wall, 0.03 * double(out.asset.radius)); }
	std::vector<std::uint32_t> verticesOf(const std::vector<std::uint32_t>& triangles) const;
	double bendOf(const std::vector<std::uint32_t>& triangles) const;
	void addVertices(const std::vector<std::uint32_t>& used, Node& node);
	void addBox(const std::vector<std::uint32_t>& used, const Vec3& sweep);
	void addFace(std::uint32_t triangle, const std::vector<std::uint32_t>& used);
	void addPatch(const std::vector<std::uint32_t>& triangles);
	void linkFaces();
	void addParents();
};

void Maker::massProperties()
{
	Vec3 first;
	double volume = 0, second[6] = {};
	for (const auto& t : mesh.triangles)
	{
		const Vec3 p[3] = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
		const double v = dot(p[0], cross(p[1], p[2])) / 6;
		const Vec3 sum = p[0] + p[1] + p[2];
		volume += v;
		first += (v / 4) * sum;
		const int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
		for (int k = 0; k < 6; ++k)
		{
			const int i = pairs[k][0], j = pairs[k][1];
			double s = sum[i] * sum[j];
			for (const Vec3& q : p) s += q[i] * q[j];
			second[k] += v / 20 * s;
		}
	}
	const Vec3 c = (1 / volume) * first;
	Asset& a = out.asset;
	for (int i = 0; i < 3; ++i) a.meshFromBody[i] = c[i];
	const double xx = second[0] - volume * c.x * c.x, yy = second[1] - volume * c.y * c.y,
				 zz = second[2] - volume * c.z * c.z;
	a.volume = volume;
	a.inertia[0] = yy + zz;
	a.inertia[1] = xx + zz;
	a.inertia[2] = xx + yy;
	a.inertia[3] = -(second[3] - volume * c.x * c.y);
	a.inertia[4] = -(second[4] - volume * c.x * c.z);
	a.inertia[5] = -(second[5] - volume * c.y * c.z);
	a.principal[3] = 1;
	for (Vec3& v : mesh.vertices) v = toVec3(toFloat3(v - c));
}

void Maker::bounds()
{
	Asset& a = out.asset;
	double radius = 0;
	Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
	for (const Vec3& v : mesh.vertices)
	{
		radius = std::max(radius, length(v));
		for (int i = 0; i < 3; ++i)
		{
			low[i] = std::min(low[i], v[i]);
			high[i] = std::max(high[i], v[i]);
		}
	}
	a.radius = float(radius * kLoose);
	store(a.boxMin, low);
	store(a.boxMax, high);
	a.storageTolerance = float(8 * std::ldexp(1.0, -24) * radius);
	a.areaTolerance = boundAtLeast(0.01 * radius);
	a.thinnestWall = boundAtMost(mesh.thinnest > 0 ? mesh.thinnest : mesh.wall);
	a.triangleCount = std::uint32_t(mesh.triangles.size());
	a.componentCount = 1;
}

// Each once, in ascending order.
std::vector<std::uint32_t> Maker::verticesOf(const std::vector<std::uint32_t>& triangles) const
{
	std::vector<std::uint32_t> used;
	for (const std::uint32_t t : triangles)
		for (const std::uint32_t v : mesh.triangles[t]) used.push_back(v);
	std::sort(used.begin(), used.end());
	used.erase(std::unique(used.begin(), used.end()), used.end());
	return used;
}

// Half the angles over the edges between the triangles, each times its edge's length: the integral of a node's curvature.
double Maker::bendOf(const std::vector<std::uint32_t>& triangles) const
{
	double bend = 0;
	for (const std::uint32_t s : triangles)
		for (const std::uint32_t t : triangles)
		{
			if (s >= t) continue;
			std::vector<std::uint32_t> common;
			for (const std::uint32_t v : mesh.triangles[s])
				for (const std::uint32_t w : mesh.triangles[t])
					if (v == w) common.push_back(v);
			if (common.size() != 2) continue;
			const double edge = length(mesh.vertices[common[0]] - mesh.vertices[common[1]]);
			bend += 0.5 * edge * std::acos(std::min(1.0, dot(normals[s], normals[t])));
		}
	return bend;
}

void Maker::addVertices(const std::vector<std::uint32_t>& used, Node& node)
{
	node.firstVertex = std::uint32_t(out.hullX.size());
	node.vertexCount = std::uint32_t(used.size());
	for (std::size_t i = 0; i < (used.size() + kVertexLanes - 1) / kVertexLanes * kVertexLanes; ++i)
	{
		const Vec3& v = mesh.vertices[used[std::min(i, used.size() - 1)]];
		out.hullX.push_back(float(v.x));
		out.hullY.push_back(float(v.y));
		out.hullZ.push_back(float(v.z));
	}
}

void Maker::addBox(const std::vector<std::uint32_t>& used, const Vec3& sweep)
{
	Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
	for (const std::uint32_t v : used)
		for (const Vec3& p : {mesh.vertices[v], mesh.vertices[v] + sweep})
			for (int i = 0; i < 3; ++i)
			{
				low[i] = std::min(low[i], p[i]);
				high[i] = std::max(high[i], p[i]);
			}
	OrientedBox box{};
	const double slack = 1e-5 * double(out.asset.radius);
	const Vec3 center = 0.5 * (low + high);
	box.radius = boundAtLeast(length(0.5 * (high - low)) * kLoose + 2 * slack);
	for (int i = 0; i < 3; ++i)
	{
		box.center[i] = nearestAnchor(center[i], out.asset.radius);
		box.half[i] = boundAtLeast(0.5 * (high[i] - low[i]) + slack);
		box.axis[i][i] = 1;
	}
	out.cullBoxes.push_back(box);
}

void Maker::addFace(std::uint32_t triangle, const std::vector<std::uint32_t>& used)
{
	Face face{};
	double offset = -1e30;
	store(face.normal, normals[triangle]);
	for (int i = 0; i < 3; ++i)
	{
		const std::uint32_t v = mesh.triangles[triangle][std::size_t(i)];
		face.vertex[i] = std::uint16_t(std::lower_bound(used.begin(), used.end(), v) - used.begin());
		Vec3 stored;
		for (int k = 0; k < 3; ++k) stored[k] = double(face.normal[k]);
		offset = std::max(offset, dot(stored, mesh.vertices[v]));
	}
	face.offset = std::nextafter(float(offset), std::numeric_limits<float>::infinity());
	face.thickness = boundAtMost(thickness());
	face.source = triangle;
	out.faces.push_back(face);
}

void Maker::addPatch(const std::vector<std::uint32_t>& triangles)
{
	Node node{};
	Vec3 mean;
	double area = 0;
	for (const std::uint32_t t : triangles)
	{
		const auto& c = mesh.triangles[t];
		const Vec3 vector = cross(mesh.vertices[c[1]] - mesh.vertices[c[0]], mesh.vertices[c[2]] - mesh.vertices[c[0]]);
		mean += vector;
		area += 0.5 * length(vector);
	}
	const std::vector<std::uint32_t> used = verticesOf(triangles);
	const bool whole = triangles.size() == mesh.triangles.size();
	Vec3 direction = normalized(mean);
	if (whole || lengthSquared(direction) == 0) direction = {0, 1, 0};
	node.flags = kClodNode;
	node.thickness = whole ? 0 : boundAtMost(thickness());
	store(node.inward, -direction);
	store(node.meanNormal, direction);
	node.contactArea = boundAtMost(area);
	node.curvature = float(bendOf(triangles) / area);
	double cone = 1;
	for (const std::uint32_t t : triangles) cone = std::min(cone, dot(normals[t], direction));
	node.coneCosine = float(std::max(-1.0, cone - 1e-6));
	node.firstFace = std::uint32_t(out.faces.size());
	node.faceCount = std::uint32_t(triangles.size());
	addVertices(used, node);
	for (const std::uint32_t t : triangles) addFace(t, used);
	addBox(used, double(node.thickness) * -direction);
	out.nodes.push_back(node);
}

void Maker::linkFaces()
{
	std::map<Edge, std::uint32_t> faceOfEdge;
	for (std::uint32_t f = 0; f < out.faces.size(); ++f)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const auto& t = mesh.triangles[out.faces[f].source];
			faceOfEdge[{t[i], t[(i + 1) % 3]}] = f;
		}
	for (Face& face : out.faces)
		for (std::size_t i = 0; i < 3; ++i)
		{
			const auto& t = mesh.triangles[face.source];
			face.neighbour[i] = faceOfEdge.at({t[(i + 1) % 3], t[i]});
		}
}

// Completion levels: four nodes a parent, whose hull is all vertices below.
void Maker::addParents()
{
	std::uint32_t first = 0, level = 0;
	const auto closeLevel = [&](std::uint32_t end)
	{
		Level record{};
		record.firstNode = first;
		record.nodeCount = end - first;
		record.firstFace = level == 0 ? 0 : std::uint32_t(out.faces.size());
		record.faceCount = level == 0 ? std::uint32_t(out.faces.size()) : 0;
		record.flags = level == 0 ? kClodNode : 0;
		out.levels.push_back(record);
	};
	std::vector<std::vector<std::uint32_t>> below = members;
	closeLevel(std::uint32_t(out.nodes.size()));
	while (below.size() > 1)
	{
		const std::uint32_t end = std::uint32_t(out.nodes.size());
		std::vector<std::vector<std::uint32_t>> above;
		++level;
		for (std::uint32_t child = first; child < end; child += 4)
		{
			Node node{};
			const std::uint32_t last = std::min(child + 4, end);
			std::vector<std::uint32_t> triangles;
			float area = kLargestBound;
			for (std::uint32_t c = child; c < last; ++c)
			{
				out.children.push_back(c);
				triangles.insert(triangles.end(), below[c - first].begin(), below[c - first].end());
				area = std::min(area, out.nodes[c].contactArea);
			}
			const std::vector<std::uint32_t> used = verticesOf(triangles);
			node.firstChild = std::uint32_t(out.children.size()) - (last - child);
			node.childCount = node.primaryChildCount = std::uint16_t(last - child);
			node.level = level;
			node.firstFace = std::uint32_t(out.faces.size());
			node.inward[1] = -1;
			node.contactArea = area;
			node.featureVolume = std::numeric_limits<float>::infinity();
			node.coneCosine = -1;
			addVertices(used, node);
			addBox(used, {});
			OrientedBox& box = out.cullBoxes.back();
			for (float& half : box.half) half = boundAtLeast(double(half) + thickness());
			box.radius = boundAtLeast(double(box.radius) + 2 * thickness());
			out.nodes.push_back(node);
			above.push_back(triangles);
		}
		first = end;
		closeLevel(std::uint32_t(out.nodes.size()));
		below = above;
	}
}
}  // namespace

std::shared_ptr<const Hierarchy> patchHierarchy(const PatchedMesh& input)
{
	Maker maker;
	maker.mesh = input;
	maker.massProperties();
	maker.bounds();
	const std::uint32_t count = *std::max_element(input.patch.begin(), input.patch.end()) + 1;
	std::vector<std::vector<std::uint32_t>> members(count);
	std::vector<Vec3> centers(count);
	for (std::uint32_t t = 0; t < input.triangles.size(); ++t)
	{
		const auto& c = maker.mesh.triangles[t];
		const Vec3* v = maker.mesh.vertices.data();
		maker.normals.push_back(normalized(cross(v[c[1]] - v[c[0]], v[c[2]] - v[c[0]])));
		members[input.patch[t]].push_back(t);
		centers[input.patch[t]] = v[c[0]];
	}
	for (const std::uint32_t p : spatialOrder(centers)) maker.members.push_back(members[p]);
	for (const auto& triangles : maker.members) maker.addPatch(triangles);
	maker.linkFaces();
	maker.addParents();
	auto result = Hierarchy::fromBytes(encode(maker.out));
	if (!result)
	{
		std::fprintf(stderr, "patchHierarchy: %s\n", result.error().c_str());
		std::abort();
	}
	return result.value();
}
}  // namespace clod::test
