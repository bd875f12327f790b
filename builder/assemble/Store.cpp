// SPDX-License-Identifier: GPL-3.0-or-later
// Every bound is rounded outward to the grid of BoundGrid.h, after a slack for the rounding of its own computation in
// double.
#include "builder/assemble/Store.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "builder/assemble/CullBoxes.h"
#include "builder/assemble/MassProperties.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/Walls.h"
#include "clod/hierarchy/BoundGrid.h"

namespace clod::builder
{
namespace
{
constexpr double kFaceDepthShare = 0.03;  // Face::thickness is at most this share of the radius

class Writer
{
public:
	Writer(const HierarchyDraft& draft, const std::vector<Lod>& lods, const BuildConfig& config, const Solid& solid,
		   const Sphere& sphere)
		: m_draft(draft), m_lods(lods), m_config(config), m_solid(solid), m_sphere(sphere)
	{
	}

	HierarchyContent run()
	{
		orderNodes();
		for (std::uint32_t level = 0; level < m_draft.levels.size(); ++level) addLevel(level);
		addNeighbours();
		addFaceDepths();
		addAsset();
		addCullBoxes();
		return std::move(m_content);
	}

private:
	// Children of one parent lie side by side: each level in the order of its primary parents.
	void orderNodes()
	{
		m_newIndex.resize(m_draft.nodes.size());
		m_oldIndex.resize(m_draft.nodes.size());
		std::iota(m_oldIndex.begin(), m_oldIndex.end(), 0u);
		for (std::size_t level = m_draft.levels.size(); level-- > 0;)
		{
			const LevelDraft& l = m_draft.levels[level];
			const auto begin = m_oldIndex.begin() + l.firstNode;
			std::sort(begin, begin + l.nodeCount,
					  [this](std::uint32_t a, std::uint32_t b)
					  {
						  const std::uint32_t p = m_draft.primaryParent[a], q = m_draft.primaryParent[b];
						  return std::make_pair(p == kNone ? 0 : m_newIndex[p], a) <
								 std::make_pair(q == kNone ? 0 : m_newIndex[q], b);
					  });
			for (std::uint32_t i = l.firstNode; i < l.firstNode + l.nodeCount; ++i) m_newIndex[m_oldIndex[i]] = i;
		}
	}

	float bound(double value) const { return boundAtLeast(value * (1 + 1e-12) + 1e-11 * m_sphere.radius); }

	void addLevel(std::uint32_t index)
	{
		const LevelDraft& draft = m_draft.levels[index];
		Level level{};
		level.firstNode = draft.firstNode;
		level.nodeCount = draft.nodeCount;
		level.firstFace = std::uint32_t(m_content.faces.size());
		level.flags = draft.clod ? kClodNode : 0;
		level.patchTolerance = boundAtLeast(draft.patchTolerance);
		for (std::uint32_t i = 0; i < draft.nodeCount; ++i)
		{
			const Node node = addNode(index, m_draft.nodes[m_oldIndex[draft.firstNode + i]]);
			level.maxHausdorff = std::max(level.maxHausdorff, node.hausdorff);
			level.maxDeviation = std::max(level.maxDeviation, node.deviation);
			level.maxCover = std::max(level.maxCover, node.cover);
			level.maxProtrude = std::max(level.maxProtrude, node.protrude);
			level.maxSurf = std::max(level.maxSurf, node.surf);
		}
		level.faceCount = std::uint32_t(m_content.faces.size()) - level.firstFace;
		m_content.levels.push_back(level);
	}

	Node addNode(std::uint32_t level, const NodeDraft& draft)
	{
		Node node{};
		node.level = level;
		node.flags = m_draft.levels[level].clod ? kClodNode : 0;
		addChildren(node, draft);
		addVertices(node, draft);
		node.thickness = float(draft.thickness);
		setVector(node.inward, draft.inward);
		node.curvature = float(draft.curvature);
		node.coneCosine = -1;
		if (node.flags != 0)
		{
			setVector(node.meanNormal, draft.meanNormal);
			node.coneCosine = std::clamp(roundDown(draft.coneCosine - 1e-7), -1.0f, 1.0f);
		}
		setNumbers(node, draft);
		addFaces(node, draft);
		m_content.nodes.push_back(node);
		return node;
	}

	void setNumbers(Node& node, const NodeDraft& draft) const
	{
		const bool inner = node.level > 0;
		node.cover = inner ? bound(draft.bounds.cover) : 0;
		node.reach = inner ? bound(draft.bounds.reach) : 0;
		node.surf = inner ? bound(draft.bounds.surf) : 0;
		node.hausdorff = inner ? bound(draft.hausdorff) : 0;
		node.protrude = bound(draft.bounds.protrude);
		node.deviation = std::max({node.cover, node.protrude, node.surf});
		node.resolution = inner ? boundAtMost(draft.resolution) : 0;
		node.contactArea = boundAtMost(draft.contactArea);
		// Of the stored deviation, whose rounding slack is all there is of the smallest ones.
		const double r = double(node.resolution), own = r > 0 ? double(node.deviation) / (r * r) : 0;
		const double volume = std::max(draft.featureVolume, own) * (1 + 1e-6);
		node.featureVolume = inner ? boundAtLeast(std::min(volume, double(kLargestBound))) : 0;
		if (node.flags == 0) node.featureVolume = std::numeric_limits<float>::infinity();
	}

	void addChildren(Node& node, const NodeDraft& draft)
	{
		if (draft.children.size() > 0xFFFF)
			throw std::runtime_error("a patch of level " + std::to_string(node.level) +
									 " has more than 65535 children");
		node.firstChild = std::uint32_t(m_content.children.size());
		node.childCount = std::uint16_t(draft.children.size());
		node.primaryChildCount = std::uint16_t(draft.primaryChildren);
		for (std::uint32_t c : draft.children) m_content.children.push_back(m_newIndex[c]);
		const auto first = m_content.children.begin() + node.firstChild;
		std::sort(first, first + node.primaryChildCount);
		std::sort(first + node.primaryChildCount, m_content.children.end());
	}

	void addVertices(Node& node, const NodeDraft& draft)
	{
		node.firstVertex = std::uint32_t(m_content.hullX.size());
		node.vertexCount = std::uint32_t(draft.vertices.size());
		const std::size_t padded = (draft.vertices.size() + kVertexLanes - 1) / kVertexLanes * kVertexLanes;
		for (std::size_t i = 0; i < padded; ++i)
		{
			const Float3 v = toFloat3(draft.vertices[std::min(i, draft.vertices.size() - 1)]);
			m_content.hullX.push_back(v.x);
			m_content.hullY.push_back(v.y);
			m_content.hullZ.push_back(v.z);
		}
	}

	void addFaces(Node& node, const NodeDraft& draft)
	{
		node.firstFace = std::uint32_t(m_content.faces.size());
		node.faceCount = std::uint32_t(draft.faces.size());
		for (std::size_t i = 0; i < draft.faces.size(); ++i)
		{
			Face face{};
			for (std::size_t k = 0; k < 3; ++k) face.vertex[k] = std::uint16_t(draft.faces[i][k]);
			Vec3 normal = normalized(areaVector(draft.face(i)));
			if (normal == Vec3{}) normal = draft.meanNormal;
			setVector(face.normal, normal);
			const Vec3 stored = toVec3(toFloat3(normal));
			double offset = -std::numeric_limits<double>::infinity();
			for (int k = 0; k < 3; ++k) offset = std::max(offset, dot(stored, draft.face(i)[k]));
			face.offset = roundUp(offset);
			face.source = node.level == 0 ? draft.triangles[i] : kNone;
			m_content.faces.push_back(face);
		}
	}

	void addNeighbours()
	{
		for (std::uint32_t level = 0; level < m_lods.size(); ++level)
		{
			const auto neighbours = triangleNeighbours(m_lods[level].mesh);
			std::vector<std::uint32_t> faceOf(neighbours.size()), triangleOf;
			const LevelDraft& l = m_draft.levels[level];
			std::uint32_t face = m_content.levels[level].firstFace;
			for (std::uint32_t i = 0; i < l.nodeCount; ++i)
				for (std::uint32_t t : m_draft.nodes[m_oldIndex[l.firstNode + i]].triangles)
				{
					faceOf[t] = face++;
					triangleOf.push_back(t);
				}
			for (std::size_t i = 0; i < triangleOf.size(); ++i)
				for (std::size_t k = 0; k < 3; ++k)
				{
					const std::uint32_t other = neighbours[triangleOf[i]][k];
					m_content.faces[m_content.levels[level].firstFace + i].neighbour[k] =
						other == kNone ? kNone : faceOf[other];
				}
		}
	}

	void addFaceDepths()
	{
		std::vector<double> walls(m_content.faces.size());
		std::vector<std::uint32_t> owner;
		for (std::uint32_t i = 0; i < m_content.nodes.size(); ++i)
			owner.insert(owner.end(), m_content.nodes[i].faceCount, i);
		parallelFor(walls.size(), m_config.threads,
					[&](std::size_t i)
					{
						const NodeDraft& node = m_draft.nodes[m_oldIndex[owner[i]]];
						Face& face = m_content.faces[i];
						const Triangle t = node.face(i - m_content.nodes[owner[i]].firstFace);
						const Vec3 normal{double(face.normal[0]), double(face.normal[1]), double(face.normal[2])};
						walls[i] = wallBehind(m_solid, centroid(t), -normal);
						face.thickness = boundAtMost(std::min(0.5 * walls[i], kFaceDepthShare * m_sphere.radius));
					});
		const double rounding = 8 * std::ldexp(m_sphere.radius, -24);  // nothing thinner is a wall
		m_thinnest = 2 * m_sphere.radius;
		for (std::size_t i = 0; i < m_content.levels[0].faceCount; ++i)
			if (walls[i] > rounding) m_thinnest = std::min(m_thinnest, walls[i]);
	}

	void addCullBoxes()
	{
		m_content.cullBoxes.resize(m_content.nodes.size());
		parallelFor(m_content.nodes.size(), m_config.threads,
					[this](std::size_t i)
					{
						const std::uint32_t old = m_oldIndex[i];
						m_content.cullBoxes[i] =
							fitCullBox(enclosed(old), m_draft.nodes[old].meanNormal, m_content.asset.radius);
					});
	}

	// What the culling box of a node must contain: its own pieces and the hulls of its primary descendants; for a
	// completion node also the pieces of the contact nodes right below the completion.
	std::vector<Vec3> enclosed(std::uint32_t root) const
	{
		std::vector<Vec3> points;
		std::vector<std::uint32_t> open{root};
		while (!open.empty())
		{
			const std::uint32_t index = open.back();
			const NodeDraft& node = m_draft.nodes[index];
			open.pop_back();
			for (std::uint32_t k = 0; k < node.primaryChildren; ++k) open.push_back(node.children[k]);
			for (const Vec3& p : storedHullPoints(node)) points.push_back(p);
			const std::uint32_t parent = m_draft.primaryParent[index];
			const bool top = parent == kNone || m_draft.nodes[parent].faces.empty();
			if (index != root && !top) continue;
			const std::vector<Vec3> corners = territoryOf(node.pieces, m_lods.front().mesh).corners;
			points.insert(points.end(), corners.begin(), corners.end());
		}
		return points;
	}

	std::vector<Vec3> storedHullPoints(const NodeDraft& node) const
	{
		std::vector<Vec3> points = node.vertices;
		const Vec3 sweep = node.thickness * toVec3(toFloat3(node.inward));
		for (const Vec3& v : node.vertices) points.push_back(v + sweep);
		return points;
	}

	void addAsset()
	{
		Asset& asset = m_content.asset;
		const Mesh& mesh = m_lods.front().mesh;
		const MassProperties mass = massProperties(mesh);
		asset.volume = mass.volume;
		std::copy(mass.inertia.begin(), mass.inertia.end(), asset.inertia);
		std::copy(mass.principal.begin(), mass.principal.end(), asset.principal);
		const float larger = float(m_sphere.radius * (1 + 4e-6));  // than what moving the centre leads to
		Vec3 center;
		for (int i = 0; i < 3; ++i)
		{
			asset.sphereCenter[i] = nearestAnchor(m_sphere.center[i], larger);
			center[i] = double(asset.sphereCenter[i]);
		}
		double radius = 0;
		for (const Vec3& v : mesh.vertices) radius = std::max(radius, length(v - center));
		asset.radius = roundUp(radius * (1 + 1e-12));
		AxisBox box;
		for (const NodeDraft& node : m_draft.nodes)
			for (const Vec3& p : storedHullPoints(node)) box.add(p);
		for (int i = 0; i < 3; ++i)
		{
			asset.boxMin[i] = roundDown(box.low[i]);
			asset.boxMax[i] = roundUp(box.high[i]);
		}
		asset.storageTolerance = roundUp(8 * std::ldexp(double(asset.radius), -24));
		asset.areaTolerance = boundAtLeast(m_config.areaTolerance * m_sphere.radius);
		asset.thinnestWall = boundAtMost(m_thinnest);
		asset.flags = m_config.paper ? kPaperBuild : 0;
		asset.triangleCount = std::uint32_t(mesh.triangles.size());
		asset.componentCount = componentCount(mesh);
	}

	static std::uint32_t componentCount(const Mesh& mesh)
	{
		const auto neighbours = triangleNeighbours(mesh);
		std::vector<bool> seen(neighbours.size(), false);
		std::uint32_t count = 0;
		for (std::uint32_t i = 0; i < neighbours.size(); ++i)
		{
			if (seen[i]) continue;
			++count;
			std::vector<std::uint32_t> open{i};
			seen[i] = true;
			while (!open.empty())
			{
				const std::uint32_t face = open.back();
				open.pop_back();
				for (std::uint32_t other : neighbours[face])
					if (other != kNone && !seen[other]) seen[other] = true, open.push_back(other);
			}
		}
		return count;
	}

	static void setVector(float (&out)[3], const Vec3& v)
	{
		for (int i = 0; i < 3; ++i) out[i] = roundToFloat(v[i]);
	}

	const HierarchyDraft& m_draft;
	const std::vector<Lod>& m_lods;
	const BuildConfig& m_config;
	const Solid& m_solid;
	const Sphere& m_sphere;
	std::vector<std::uint32_t> m_newIndex, m_oldIndex;
	double m_thinnest = 0;
	HierarchyContent m_content;
};
}  // namespace

HierarchyContent store(const HierarchyDraft& draft, const std::vector<Lod>& lods, const BuildConfig& config,
					   const Solid& solid, const Sphere& sphere)
{
	return Writer(draft, lods, config, solid, sphere).run();
}
}  // namespace clod::builder
