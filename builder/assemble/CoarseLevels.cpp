// SPDX-License-Identifier: GPL-3.0-or-later
// Greedy pairwise merging, the pair whose hull sticks out least first (as Mamou & Ghorbel 2009 order theirs by
// concavity).
#include "builder/assemble/CoarseLevels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
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
constexpr std::size_t kMostFaces = 256;       // of a patch; 64 in the finer levels
constexpr double kReflex = 2;                 // eps of a bridged level over what its hulls may stick out: a chord over
											  // a reflex edge rises half as high as the edge
constexpr double kRoomToBridge = 0.8;         // of the error, which the level that is bridged may use up itself
constexpr double kAsFew = 1.25;               // times the patches, of fewer triangles: preferred
constexpr std::size_t kWorthDropping = 1000;  // triangles that are stored once less
constexpr double kSameError = 1.1;            // of the level that was bridged: up to it the bridged one takes its place
constexpr double kShares[] = {0.01, 0.03, 0.1, 0.2, 0.4};  // of the radius: errors that levels are bridged within
constexpr std::size_t kShareCount = std::size(kShares);
constexpr std::size_t kCounted = 3;  // of them decide between levels that cannot both stay
constexpr int kPairBudget = 1000;    // cells of one pair's proof; what is not settled by then is not bridged

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
		while (!m_open.empty()) merge(m_open.begin()->second, threads);
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
		if (m_faces[a].size() + m_faces[b].size() > kMostFaces) return kNever;
		std::vector<std::uint32_t> faces = m_faces[a];
		faces.insert(faces.end(), m_faces[b].begin(), m_faces[b].end());
		const auto isOwn = [&](std::uint32_t f) { return m_label[f] == a || m_label[f] == b; };
		std::set<std::uint32_t> used;
		ConvexBody body;
		for (const std::uint32_t f : faces)
		{
			used.insert(m_lod.mesh.triangles[f].begin(), m_lod.mesh.triangles[f].end());
			body.realNormals.push_back(areaVector(triangleOf(m_lod.mesh, f)));
		}
		for (const std::uint32_t v : used) body.points.push_back(m_lod.mesh.vertices[v]);
		if (!isConvexWithin(faces, isOwn, body.points)) return kNever;
		const Protrusion found = protrusion(m_solid, body, m_scale, m_limit);
		return found.upper <= m_limit && !isEntered(isOwn, body.points) ? found.lower : kNever;
	}

	// Edges within eps, all vertices within 2 eps of every face's plane.
	template <class IsOwn>
	bool isConvexWithin(const std::vector<std::uint32_t>& faces, const IsOwn& isOwn,
						const std::vector<Vec3>& points) const
	{
		for (const std::uint32_t f : faces)
		{
			const Vec3 origin = triangleOf(m_lod.mesh, f).a;
			for (const Vec3& p : points)
				if (dot(m_normals[f], p - origin) > 2 * m_tolerance) return false;
			for (const std::uint32_t other : m_neighbours[f])
			{
				if (!isOwn(other)) continue;
				const Triangle t = triangleOf(m_lod.mesh, other);
				for (int k = 0; k < 3; ++k)
					if (dot(m_normals[f], t[k] - origin) > m_tolerance) return false;
			}
		}
		return true;
	}

	// By a face of another patch, deeper than 4 eps.
	template <class IsOwn>
	bool isEntered(const IsOwn& isOwn, const std::vector<Vec3>& points) const
	{
		std::vector<HalfSpace> planes = hullShape(points, 0.25 * m_scale.rounding).planes;
		for (HalfSpace& plane : planes) plane.offset -= 4 * m_tolerance;
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
			if (!isOwn(f) && meetsInterior(triangleOf(m_lod.mesh, f), planes, 0)) return true;
		return false;
	}

	void merge(const Pair& pair, const ThreadLimit& threads)
	{
		const std::uint32_t into = pair.first, from = pair.second;
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
		const std::vector<std::uint32_t> others(around.begin(), around.end());
		std::vector<double> costs(others.size());
		parallelFor(others.size(), threads, [&](std::size_t i) { costs[i] = cost(into, others[i]); });
		for (std::size_t i = 0; i < others.size(); ++i)
			if (costs[i] < kNever) m_open.insert({costs[i], std::minmax(into, others[i])});
	}

	// Patches are numbered by their first triangle.
	Lod result() const
	{
		Lod lod;
		lod.mesh = m_lod.mesh;
		lod.patchTolerance = std::max(m_tolerance, m_lod.patchTolerance);
		lod.errorLimit = m_limit;
		std::map<std::uint32_t, std::uint32_t> number;
		for (const std::uint32_t label : m_label)
			lod.patchOfTriangle.push_back(number.emplace(label, std::uint32_t(number.size())).first->second);
		lod.patchCount = std::uint32_t(number.size());
		lod.patchResolution.assign(lod.patchCount, 0);
		for (std::uint32_t f = 0; f < m_label.size(); ++f)
		{
			double& r = lod.patchResolution[lod.patchOfTriangle[f]];
			const double own = m_lod.patchResolution[m_lod.patchOfTriangle[f]];
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

ConvexBody bodyOf(const NodeDraft& node)
{
	ConvexBody body{node.vertices, {}};
	for (std::size_t f = 0; f < node.faces.size(); ++f) body.realNormals.push_back(areaVector(node.face(f)));
	return body;
}

// visit(i, patch, its hull) for every patch, thickness left out.
template <class Visit>
void forEachPatch(const Lod& lod, const ThreadLimit& threads, const Visit& visit)
{
	const std::vector<NodeDraft> nodes = patchNodes(lod, 0);
	parallelFor(nodes.size(), threads, [&](std::size_t i) { visit(i, nodes[i], bodyOf(nodes[i])); });
}

// Whether surf and protrude of every patch are certified to be within the limit.
bool isWithin(double limit, const Lod& lod, const Solid& solid, ProtrusionScale scale, const ThreadLimit& threads)
{
	scale.enough = limit;
	const Tolerance tolerance{0.1, 1e-4 * scale.radius};
	std::atomic<bool> within{true};
	forEachPatch(lod, threads,
				 [&](std::size_t, const NodeDraft& patch, const ConvexBody& body)
				 {
					 if (within && (surfOf(patch, solid.tree(), tolerance).upper > limit ||
									protrusion(solid, body, scale, limit).upper > limit))
						 within = false;
				 });
	return within;
}

// The largest surf or protrude of its patches.
double deviationOf(const Lod& lod, const Solid& solid, const ProtrusionScale& scale, const ThreadLimit& threads)
{
	std::vector<double> most(lod.patchCount);
	forEachPatch(lod, threads,
				 [&](std::size_t i, const NodeDraft& patch, const ConvexBody& body)
				 {
					 most[i] = std::max(surfOf(patch, solid.tree(), {0.1, 1e-4 * scale.radius}).upper,
										protrusion(solid, body, scale).upper);
				 });
	return *std::max_element(most.begin(), most.end());
}

struct Candidate
{
	Lod lod;
	std::size_t share;  // the first that it and all finer ones keep
};

// The chain from the finest on in which every level halves the patches of the one below, with the least product of the
// fewest patches within each of the counted shares; of several such the longest.
std::vector<Lod> fewestWithinShares(std::vector<Candidate>&& levels)
{
	struct Chain
	{
		double cost = kNever;
		int shorter = 0;
		std::size_t before = 0;
		bool operator<(const Chain& other) const
		{
			return cost != other.cost ? cost < other.cost : shorter < other.shorter;
		}
	};
	const auto costUpTo = [](std::size_t end, const Candidate& level)
	{
		const double shares = double(std::min(end, kCounted)) - double(std::min(level.share, kCounted));
		return shares * std::log(double(level.lod.patchCount));
	};
	std::vector<Chain> chains(levels.size());
	chains[0].cost = 0;
	for (std::size_t i = 1; i < levels.size(); ++i)
		for (std::size_t k = 0; k < i; ++k)
			if (2 * levels[i].lod.patchCount <= levels[k].lod.patchCount)
				chains[i] = std::min(chains[i],
									 {chains[k].cost + costUpTo(levels[i].share, levels[k]), chains[k].shorter - 1, k});
	for (std::size_t i = 0; i < levels.size(); ++i) chains[i].cost += costUpTo(kShareCount, levels[i]);
	std::vector<Lod> kept;
	std::size_t i = std::size_t(std::min_element(chains.begin(), chains.end()) - chains.begin());
	for (;; i = chains[i].before)
	{
		kept.push_back(std::move(levels[i].lod));
		kept.back().patchOfChild.clear();  // the level below may be another one
		if (i == 0) break;
	}
	std::reverse(kept.begin(), kept.end());
	return kept;
}
}  // namespace

void bridgeCoarseLevels(std::vector<Lod>& lods, const Solid& solid, const ProtrusionScale& scale,
						const ThreadLimit& threads)
{
	if (lods.empty()) return;
	const auto limitOf = [&](std::size_t share)
	{ return 0.999 * kShares[share] * scale.radius; };  // bounds are stored rounded outward
	std::vector<Candidate> levels;
	for (Lod& lod : lods) levels.push_back({std::move(lod), kShareCount});
	for (std::size_t share = 0; share < kShareCount; ++share)
	{
		const double limit = limitOf(share);
		const auto leavesRoom = [&](const Lod& lod)
		{ return lod.errorLimit <= limit || isWithin(kRoomToBridge * limit, lod, solid, scale, threads); };
		std::size_t end = levels.size();
		while (end > 0 && !leavesRoom(levels[end - 1].lod)) --end;
		if (end == 0) continue;
		std::size_t fewest = 0, simplest = 0;  // patches, triangles
		for (std::size_t i = 0; i < end; ++i)
		{
			const Lod &lod = levels[i].lod, &other = levels[simplest].lod;
			levels[i].share = std::min(levels[i].share, share);
			if (lod.patchCount <= levels[fewest].lod.patchCount) fewest = i;
			if (lod.mesh.triangles.size() <= other.mesh.triangles.size()) simplest = i;
		}
		const auto bridgedFrom = [&](std::size_t start)
		{ return Bridges(levels[start].lod, solid, scale, limit).run(threads); };
		Lod bridged = bridgedFrom(fewest);
		if (levels[simplest].lod.mesh.triangles.size() < bridged.mesh.triangles.size())
		{
			Lod other = bridgedFrom(simplest);
			if (double(other.patchCount) <= kAsFew * double(bridged.patchCount))
			{
				bridged = std::move(other);
				fewest = simplest;
			}
		}
		Candidate& start = levels[fewest];
		if (bridged.patchCount == start.lod.patchCount) continue;
		const auto keepsError = [&]
		{
			const double sameError = kSameError * deviationOf(start.lod, solid, scale, threads);
			return isWithin(std::min(sameError, limitOf(start.share)), bridged, solid, scale, threads);
		};
		if (start.lod.mesh.triangles.size() >= kWorthDropping && keepsError())
			start.lod = std::move(bridged);
		else
			levels.insert(levels.begin() + std::ptrdiff_t(end), {std::move(bridged), share});
	}
	lods = fewestWithinShares(std::move(levels));
}
}  // namespace clod::builder
