// SPDX-License-Identifier: GPL-3.0-or-later
// The last step of a build: from levels of detail to a hierarchy whose numbers are proved.
#include <algorithm>
#include <stdexcept>

#include "builder/assemble/Assembler.h"
#include "builder/assemble/Certify.h"
#include "builder/assemble/CoarseLevels.h"
#include "builder/assemble/Completion.h"
#include "builder/assemble/ContactArea.h"
#include "builder/assemble/Graph.h"
#include "builder/assemble/HullPlanes.h"
#include "builder/assemble/PatchNodes.h"
#include "builder/assemble/Store.h"
#include "builder/assemble/Walls.h"

namespace clod::builder
{
namespace
{
// Cells of one hull. A few hulls of a level need more than a thousand, and an outlier spoils its level and its parents.
constexpr int kProtrusionBudget = 15000;
// Cells of all hulls of a level: where every hull needs many, as on surfaces that are rough at the size of their
// triangles.
constexpr std::size_t kLevelBudget = 20'000'000, kLeastBudget = 1000;
constexpr double kCapShare = 0.25;  // contact areas count within this share of the radius
}  // namespace

Assembler::Assembler(const Mesh& input, const BuildConfig& config, const Progress& progress, const ThreadLimit& threads)
	: m_config(config),
	  m_progress(progress),
	  m_threads(threads),
	  m_solid(input),
	  m_sphere(boundingSphere(input.vertices)),
	  m_scale{m_sphere.radius, 8 * std::ldexp(m_sphere.radius, -24), kProtrusionBudget}
{
}

void Assembler::report(const char* phase, double fraction) const
{
	builder::report(m_progress, phase, fraction);
}

void Assembler::add(Lod&& lod)
{
	if (!m_config.paper && !m_lods.empty() && lod.patchCount <= kMostBridged)
		m_coarse.push_back(std::move(lod));
	else
		take(std::move(lod));
}

void Assembler::take(Lod&& lod)
{
	m_lods.push_back(std::move(lod));
	assign(m_lods.size() - 1);
	certify(m_lods.size() - 1);
	if (m_lods.size() == 1) addAreas();
}

HierarchyContent Assembler::finish()
{
	if (m_lods.empty()) throw std::runtime_error("no levels to assemble");
	report("bridge", 0);
	bridgeCoarseLevels(m_coarse, m_solid, m_scale, m_threads);
	for (Lod& lod : m_coarse) take(std::move(lod));
	report("complete", 0);
	if (!m_config.paper) averageContactAreas(m_draft, m_lods.size());
	completeToRoot(m_draft, cornersBelowTop(), m_threads);
	linkParents();
	crudeCompletionBounds();
	closeMonotone();
	report("store", 0);
	return store(m_draft, m_lods, m_config, m_solid, m_sphere);
}

LevelAssignment Assembler::assignmentOf(std::size_t level)
{
	if (level == 0) m_label = m_lods[0].patchOfTriangle;
	if (level > 0 && m_config.paper)
		for (std::uint32_t& label : m_label) label = m_lods[level].patchOfChild[label];
	if (level == 0 || m_config.paper) return assignByLabel(m_label);
	return assignToNearest(m_lods[0].mesh, m_solid.tree(), m_lods[level], m_below, {m_scale.radius, m_threads});
}

void Assembler::assign(std::size_t level)
{
	const Lod& lod = m_lods[level];
	const LevelDraft record{std::uint32_t(m_draft.nodes.size()), lod.patchCount, true, lod.patchTolerance};
	for (NodeDraft& node : patchNodes(lod, level)) m_draft.nodes.push_back(std::move(node));
	m_draft.levels.push_back(record);
	LevelAssignment here = assignmentOf(level);
	for (const std::vector<Piece>* list : {&here.pieces, &here.extra})
		for (const Piece& piece : *list) m_draft.nodes[record.firstNode + piece.owner].pieces.push_back(piece);
	if (level > 0) link(level, overlaps(m_solid.tree(), m_below, here));
	m_below = std::move(here);
}

void Assembler::link(std::size_t level, const std::vector<Overlap>& shared)
{
	const LevelDraft &fine = m_draft.levels[level - 1], &coarse = m_draft.levels[level];
	const auto distance = [&](std::uint32_t c, std::uint32_t f)
	{ return length(m_draft.nodes[coarse.firstNode + c].vertices[0] - m_draft.nodes[fine.firstNode + f].vertices[0]); };
	const LevelLinks links = linkLevels(shared, fine.nodeCount, coarse.nodeCount, distance);
	for (std::uint32_t c = 0; c < coarse.nodeCount; ++c)
	{
		NodeDraft& node = m_draft.nodes[coarse.firstNode + c];
		const auto isPrimary = [&](std::uint32_t f) { return links.primaryParent[f] == c; };
		for (bool primary : {true, false})
			for (std::uint32_t f : links.children[c])
				if (isPrimary(f) == primary) node.children.push_back(fine.firstNode + f);
		node.primaryChildren =
			std::uint32_t(std::count_if(links.children[c].begin(), links.children[c].end(), isPrimary));
		if (node.primaryChildren == 0)
			throw std::runtime_error("patch " + std::to_string(c) + " of level " + std::to_string(level) +
									 " has no patch of the level below");
	}
}

void Assembler::certify(std::size_t level)
{
	const Tolerance tolerance{0.1, 1e-4 * m_scale.radius};
	const LevelDraft record = m_draft.levels[level];
	ProtrusionScale scale = m_scale;
	scale.budget = std::min(scale.budget, int(std::max(kLeastBudget, kLevelBudget / record.nodeCount)));
	parallelFor(record.nodeCount, m_threads,
				[&](std::size_t i)
				{
					NodeDraft& node = m_draft.nodes[record.firstNode + i];
					if (level > 0) node.bounds.surf = surfOf(node, m_solid.tree(), tolerance).upper;
					thicken(node, m_solid, scale, {1.1, node.bounds.surf, m_lods[level].errorLimit});
					if (level == 0) return;
					const CoverAndReach found = coverAndReachOf(node, m_lods.front().mesh, tolerance);
					node.bounds.cover = found.cover;
					node.bounds.reach = std::max(found.cover, found.reach.upper);
					node.hausdorff = m_config.paper ? exactHausdorff(node) : hausdorffStep(node);
				});
}

// h by the triangle inequality: what the children need, plus their distance to this hull.
double Assembler::hausdorffStep(const NodeDraft& node) const
{
	double most = 0;
	for (std::uint32_t c : node.children)
	{
		const NodeDraft& child = m_draft.nodes[c];
		for (const Vec3& p : child.hullPoints())
			most = std::max(most, child.hausdorff + distanceBound(p, node.hull(), most - child.hausdorff));
	}
	return most;
}

double Assembler::exactHausdorff(const NodeDraft& node) const
{
	double most = 0;
	std::vector<std::uint32_t> open = node.children;
	while (!open.empty())
	{
		const NodeDraft& below = m_draft.nodes[open.back()];
		open.pop_back();
		open.insert(open.end(), below.children.begin(), below.children.end());
		for (const Vec3& p : below.hullPoints()) most = std::max(most, distanceBound(p, node.hull(), most));
	}
	return most;
}

// D of a leaf: at the face nearest to the patch's middle. Coarser ones: the minimum with `paper` (closeNode).
void Assembler::addAreas()
{
	const Mesh& mesh = m_lods.front().mesh;
	const ContactArea area(mesh, m_config.areaTolerance * m_scale.radius, kCapShare * m_scale.radius);
	parallelFor(m_draft.levels[0].nodeCount, m_threads,
				[&](std::size_t i)
				{
					NodeDraft& node = m_draft.nodes[i];
					Vec3 middle;
					double total = 0;
					for (std::size_t f = 0; f < node.faces.size(); ++f)
					{
						const double a = length(areaVector(node.face(f)));
						middle += a * centroid(node.face(f));
						total += a;
					}
					middle = (1 / total) * middle;
					std::size_t best = 0;
					for (std::size_t f = 1; f < node.faces.size(); ++f)
						if (distanceSquared(middle, node.face(f)) < distanceSquared(middle, node.face(best))) best = f;
					const Triangle face = node.face(best);
					node.contactArea =
						area.at(node.triangles[best], closestPoint(middle, face).point, normalized(areaVector(face)));
				});
}

// For each node of the coarsest contact level: the hull corners of it and of everything below.
std::vector<std::vector<Vec3>> Assembler::cornersBelowTop() const
{
	const LevelDraft top = m_draft.levels.back();
	std::vector<std::vector<Vec3>> corners(top.nodeCount);
	parallelFor(top.nodeCount, m_threads,
				[&](std::size_t i)
				{
					std::vector<Vec3> points;
					AxisBox box;
					std::vector<std::uint32_t> open{top.firstNode + std::uint32_t(i)};
					while (!open.empty())
					{
						const NodeDraft& node = m_draft.nodes[open.back()];
						open.pop_back();
						open.insert(open.end(), node.children.begin(), node.children.begin() + node.primaryChildren);
						for (const Vec3& p : node.hullPoints())
						{
							points.push_back(p);
							box.add(p);
						}
					}
					corners[i] = hullShape(points, 1e-6 * length(box.extent())).corners;
				});
	return corners;
}

void Assembler::linkParents()
{
	m_draft.primaryParent.assign(m_draft.nodes.size(), kNone);
	for (std::uint32_t i = 0; i < m_draft.nodes.size(); ++i)
		for (std::uint32_t k = 0; k < m_draft.nodes[i].primaryChildren; ++k)
			m_draft.primaryParent[m_draft.nodes[i].children[k]] = i;
}

// Completion nodes never answer: their own part of protrude is the lemma with one input triangle.
void Assembler::crudeCompletionBounds()
{
	for (std::size_t level = m_lods.size(); level < m_draft.levels.size(); ++level)
		parallelFor(m_draft.levels[level].nodeCount, m_threads,
					[&](std::size_t i)
					{
						NodeDraft& node = m_draft.nodes[m_draft.levels[level].firstNode + i];
						Vec3 middle;
						for (const Vec3& v : node.vertices) middle += (1 / double(node.vertices.size())) * v;
						const Triangle& t = m_solid.tree().triangle(m_solid.tree().nearest(middle).triangle);
						for (const Vec3& v : node.vertices)
							node.bounds.protrude = std::max(node.bounds.protrude, std::sqrt(distanceSquared(v, t)));
					});
}

// Parents take the worst of their children. Resolution is completed first where nothing was collapsed under a node
// of a coarser level but its surface moved all the same: by the coarsest one of its level.
void Assembler::closeMonotone()
{
	for (const LevelDraft& level : m_draft.levels)
	{
		double coarsest = 1 / m_scale.radius;
		for (std::uint32_t i = 0; i < level.nodeCount; ++i) closeNode(m_draft.nodes[level.firstNode + i]);
		bool any = false;
		for (std::uint32_t i = 0; i < level.nodeCount; ++i)
		{
			const double r = m_draft.nodes[level.firstNode + i].resolution;
			if (r > 0 && (!any || r < coarsest)) coarsest = r, any = true;
		}
		if (&level == &m_draft.levels.front()) continue;
		for (std::uint32_t i = 0; i < level.nodeCount; ++i)
		{
			NodeDraft& n = m_draft.nodes[level.firstNode + i];
			const double r = n.resolution > 0 ? n.resolution : coarsest;
			const double deviation = std::max({n.bounds.cover, n.bounds.protrude, n.bounds.surf});
			n.featureVolume = std::max(n.featureVolume, deviation / (r * r));
		}
	}
}

void Assembler::closeNode(NodeDraft& n) const
{
	for (std::uint32_t c : n.children)
	{
		const NodeDraft& child = m_draft.nodes[c];
		n.bounds.cover = std::max(n.bounds.cover, child.bounds.cover);
		n.bounds.reach = std::max(n.bounds.reach, child.bounds.reach);
		n.bounds.protrude = std::max(n.bounds.protrude, child.bounds.protrude);
		n.bounds.surf = std::max(n.bounds.surf, child.bounds.surf);
		n.featureVolume = std::max(n.featureVolume, child.featureVolume);
		n.contactArea = n.contactArea > 0 ? std::min(n.contactArea, child.contactArea) : child.contactArea;
		if (child.resolution > 0)
			n.resolution = n.resolution > 0 ? std::min(n.resolution, child.resolution) : child.resolution;
	}
	n.bounds.reach = std::max(n.bounds.reach, n.bounds.cover);
}

HierarchyContent assembleHierarchy(LodSequence lods, const BuildConfig& config, const Progress& progress)
{
	if (lods.lods.empty() || lods.lods.front().mesh.triangles.empty())
		throw std::runtime_error("no triangles to assemble");
	const std::size_t count = lods.lods.size();
	const ThreadLimit threads(config.threads);
	Assembler assembler(lods.lods.front().mesh, config, progress, threads);
	for (std::size_t level = 0; level < count; ++level)
	{
		report(progress, "certify", double(level) / double(count));
		assembler.add(std::move(lods.lods[level]));
	}
	return assembler.finish();
}
}  // namespace clod::builder
