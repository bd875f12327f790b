// SPDX-License-Identifier: GPL-3.0-or-later
// Greedy pairwise merging, the pair whose hull sticks out least first (as Mamou & Ghorbel 2009 order theirs by
// concavity).
#include "builder/assemble/CoarseLevels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "builder/assemble/Certify.h"
#include "builder/assemble/Displacement.h"
#include "builder/assemble/HullPlanes.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/PatchNodes.h"

namespace clod::builder
{
namespace
{
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostFaces = 64;  // of a patch, as in the finer levels
constexpr double kReflex = 2;           // eps of a bridged level over what its hulls may stick out: a chord over
										// a reflex edge rises half as high as the edge
constexpr double kRoomToBridge = 0.8;   // of the error, which the level that is bridged may use up itself
constexpr int kPairBudget = 1000;       // cells of one pair's proof; what is not settled by then is not bridged

Triangle triangleOf(const Mesh& mesh, std::uint32_t f)
{
	const auto& t = mesh.triangles[f];
	return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

// Patches of one level that become fewer.
class Bridges
{
public:
	Bridges(const Lod& lod, const Solid& solid, const ProtrusionScale& scale, double limit)
		: m_lod(lod),
		  m_solid(solid),
		  m_scale{scale.radius, scale.rounding, kPairBudget, limit},
		  m_limit(limit),
		  m_tolerance(kReflex * limit),
		  m_neighbours(triangleNeighbours(lod.mesh)),
		  m_label(lod.patchOfTriangle),
		  m_faces(lod.patchCount)
	{
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
		{
			const Triangle t = triangleOf(lod.mesh, f);
			m_normals.push_back(normalized(areaVector(t)));
			m_faces[m_label[f]].push_back(f);
		}
	}

	Lod run(const ThreadLimit& threads)
	{
		const std::vector<Pair> pairs = neighbouringPairs();
		std::vector<double> costs(pairs.size());
		parallelFor(pairs.size(), threads, [&](std::size_t i) { costs[i] = cost(pairs[i].first, pairs[i].second); });
		for (std::size_t i = 0; i < pairs.size(); ++i)
			if (costs[i] < kNever) m_open.insert({costs[i], pairs[i]});
		while (!m_open.empty()) merge(m_open.begin()->second);
		return result();
	}

private:
	using Pair = std::pair<std::uint32_t, std::uint32_t>;

	std::vector<Pair> neighbouringPairs() const
	{
		std::set<Pair> pairs;
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
			for (const std::uint32_t other : m_neighbours[f])
				if (m_label[f] < m_label[other]) pairs.insert({m_label[f], m_label[other]});
		return {pairs.begin(), pairs.end()};
	}

	// How far the common hull is seen to reach out of the solid; never where that is not proved to be within the limit,
	// or the union would be no patch of this tolerance.
	double cost(std::uint32_t a, std::uint32_t b) const
	{
		std::vector<std::uint32_t> faces = m_faces[a];
		faces.insert(faces.end(), m_faces[b].begin(), m_faces[b].end());
		if (faces.size() > kMostFaces) return kNever;
		std::set<std::uint32_t> used;
		ConvexBody body;
		for (const std::uint32_t f : faces)
		{
			used.insert(m_lod.mesh.triangles[f].begin(), m_lod.mesh.triangles[f].end());
			body.realNormals.push_back(areaVector(triangleOf(m_lod.mesh, f)));
		}
		for (const std::uint32_t v : used) body.points.push_back(m_lod.mesh.vertices[v]);
		if (!isConvexWithin(faces, body.points)) return kNever;
		const Protrusion found = protrusion(m_solid, body, m_scale, m_limit);
		return found.upper <= m_limit && !isEntered(faces, body.points) ? found.lower : kNever;
	}

	// Edges within eps, all vertices within 2 eps of every face's plane.
	bool isConvexWithin(const std::vector<std::uint32_t>& faces, const std::vector<Vec3>& points) const
	{
		for (const std::uint32_t f : faces)
		{
			const Vec3 origin = triangleOf(m_lod.mesh, f).a;
			for (const Vec3& p : points)
				if (dot(m_normals[f], p - origin) > 2 * m_tolerance) return false;
			for (const std::uint32_t other : m_neighbours[f])
			{
				if (std::find(faces.begin(), faces.end(), other) == faces.end()) continue;
				const Triangle t = triangleOf(m_lod.mesh, other);
				for (int k = 0; k < 3; ++k)
					if (dot(m_normals[f], t[k] - origin) > m_tolerance) return false;
			}
		}
		return true;
	}

	// By a face of another patch, deeper than 4 eps.
	bool isEntered(const std::vector<std::uint32_t>& faces, const std::vector<Vec3>& points) const
	{
		std::vector<HalfSpace> planes = hullShape(points, 0.25 * m_scale.rounding).planes;
		for (HalfSpace& plane : planes) plane.offset -= 4 * m_tolerance;
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
			if (std::find(faces.begin(), faces.end(), f) == faces.end() &&
				meetsInterior(triangleOf(m_lod.mesh, f), planes, 0))
				return true;
		return false;
	}

	void merge(const Pair& pair)
	{
		const auto [into, from] = pair;
		for (const std::uint32_t f : m_faces[from]) m_label[f] = into;
		m_faces[into].insert(m_faces[into].end(), m_faces[from].begin(), m_faces[from].end());
		m_faces[from].clear();
		for (auto it = m_open.begin(); it != m_open.end();)
		{
			const Pair& p = it->second;
			const bool stale = p.first == into || p.second == into || p.first == from || p.second == from;
			it = stale ? m_open.erase(it) : std::next(it);
		}
		std::set<std::uint32_t> around;
		for (const std::uint32_t f : m_faces[into])
			for (const std::uint32_t other : m_neighbours[f]) around.insert(m_label[other]);
		around.erase(into);
		for (const std::uint32_t other : around)
		{
			const double c = cost(into, other);
			if (c < kNever) m_open.insert({c, {std::min(into, other), std::max(into, other)}});
		}
	}

	// Patches are numbered by their first triangle.
	Lod result() const
	{
		Lod lod;
		lod.mesh = m_lod.mesh;
		lod.patchTolerance = std::max(m_tolerance, m_lod.patchTolerance);
		lod.errorLimit = m_limit;
		std::map<std::uint32_t, std::uint32_t> number;
		lod.patchOfChild.assign(m_lod.patchCount, kNone);
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
		{
			const std::uint32_t patch = number.emplace(m_label[f], std::uint32_t(number.size())).first->second;
			lod.patchOfTriangle.push_back(patch);
			lod.patchOfChild[m_lod.patchOfTriangle[f]] = patch;
		}
		lod.patchCount = std::uint32_t(number.size());
		lod.patchResolution.assign(lod.patchCount, 0);
		for (std::uint32_t p = 0; p < m_lod.patchCount; ++p)
		{
			double& r = lod.patchResolution[lod.patchOfChild[p]];
			const double own = m_lod.patchResolution[p];
			if (own > 0) r = r > 0 ? std::min(r, own) : own;
		}
		return lod;
	}

	const Lod& m_lod;
	const Solid& m_solid;
	const ProtrusionScale m_scale;
	const double m_limit;  // what a hull may stick out
	const double m_tolerance;
	const std::vector<std::array<std::uint32_t, 3>> m_neighbours;
	std::vector<std::uint32_t> m_label;
	std::vector<std::vector<std::uint32_t>> m_faces;  // by patch
	std::vector<Vec3> m_normals;
	std::set<std::pair<double, Pair>> m_open;
};

// Largest certified surf or protrude of a level, thickness left out.
double deviationOf(const Lod& lod, const Solid& solid, const ProtrusionScale& scale, const ThreadLimit& threads)
{
	const std::vector<NodeDraft> nodes = patchNodes(lod, 0);
	std::vector<double> most(nodes.size());
	parallelFor(nodes.size(), threads,
				[&](std::size_t i)
				{
					ConvexBody body{nodes[i].vertices, {}};
					for (std::size_t f = 0; f < nodes[i].faces.size(); ++f)
						body.realNormals.push_back(areaVector(nodes[i].face(f)));
					most[i] = std::max(surfOf(nodes[i], solid.tree(), {0.1, 1e-4 * scale.radius}).upper,
									   protrusion(solid, body, scale).upper);
				});
	return *std::max_element(most.begin(), most.end());
}
}  // namespace

void bridgeCoarseLevels(std::vector<Lod>& lods, const Solid& solid, const ProtrusionScale& scale,
						const ThreadLimit& threads)
{
	for (const double share : {0.1, 0.2, 0.4})
	{
		const double limit = 0.999 * share * scale.radius;  // bounds are stored rounded outward
		const auto leavesRoom = [&](const Lod& lod)
		{ return lod.errorLimit <= limit || deviationOf(lod, solid, scale, threads) <= kRoomToBridge * limit; };
		std::size_t end = lods.size();
		while (end > 0 && !leavesRoom(lods[end - 1])) --end;
		if (end == 0) continue;
		Lod& start = lods[end - 1];
		Lod bridged = Bridges(start, solid, scale, limit).run(threads);
		if (2 * bridged.patchCount <= start.patchCount)
			lods.resize(end);
		else if (end > 1 && !std::isfinite(start.errorLimit) && bridged.patchCount < start.patchCount &&
				 2 * bridged.patchCount <= lods[end - 2].patchCount)
		{
			// Every level has half the patches of the one below: the one that was bridged makes way.
			std::vector<std::uint32_t> patchOfChild;
			for (const std::uint32_t patch : start.patchOfChild) patchOfChild.push_back(bridged.patchOfChild[patch]);
			bridged.patchOfChild = std::move(patchOfChild);
			lods.resize(end - 1);
		}
		else
			continue;
		lods.push_back(std::move(bridged));
	}
}
}  // namespace clod::builder
