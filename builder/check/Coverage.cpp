// SPDX-License-Identifier: GPL-3.0-or-later
// cover and reach: for every point of the input surface there is a chain of nodes from its leaf to the root, each a
// parent of the one before, each within its cover and reach of the point and with the point in its culling box. Shown
// for whole pieces of input faces, largest at their corners by convexity; a piece without such a chain is quartered.
#include <fmt/format.h>

#include <algorithm>

#include "builder/check/Subject.h"

namespace clod::check
{
double outsideBox(const OrientedBox& box, const Vec3& p);  // Culling.cpp

namespace
{
// What a link of a chain must satisfy. Separately only to name what is broken.
struct Demand
{
	bool cover = true, reach = true, box = true;
};

class Chains
{
public:
	explicit Chains(const Subject& s) : m_s(s), m_hulls(s.h.nodes().size), m_faces(s.h.nodes().size)
	{
		for (std::uint32_t i = 0; i < m_hulls.size(); ++i)
		{
			if (s.h.node(i).level == 0) continue;
			m_hulls[i] = s.thickHull(i);
			for (std::uint32_t f = 0; f < s.h.node(i).faceCount; ++f)
			{
				const Triangle face = s.triangle(s.h.node(i).firstFace + f);
				m_faces[i].push_back({face, boxOf({face[0], face[1], face[2]})});
			}
		}
	}

	// The smallest allowance with which every piece of the face has a chain: 0 when the promise holds as stored. Pieces
	// are quartered `depth` times; the last ones are given their own size.
	double allowanceFor(std::uint32_t face, const Demand& demand, int depth) const
	{
		return allowance(m_s.ownerOfFace[face], m_s.triangle(face), demand, depth);
	}

private:
	double allowance(std::uint32_t leaf, const Triangle& piece, const Demand& demand, int depth) const
	{
		if (hasChain(leaf, piece, demand, m_s.slack)) return 0;
		if (depth == 0)
		{
			const double size =
				std::max({length(piece[0] - piece[1]), length(piece[1] - piece[2]), length(piece[2] - piece[0])});
			double given = size + m_s.slack;
			if (hasChain(leaf, piece, demand, given)) return 0;
			while (!hasChain(leaf, piece, demand, given) && given < 4 * m_s.radius) given *= 2;
			return given;
		}
		const Vec3 a = 0.5 * (piece[0] + piece[1]), b = 0.5 * (piece[1] + piece[2]), c = 0.5 * (piece[2] + piece[0]);
		double most = 0;
		for (const Triangle& part :
			 {Triangle{piece[0], a, c}, Triangle{a, piece[1], b}, Triangle{c, b, piece[2]}, Triangle{a, b, c}})
		{
			most = std::max(most, allowance(leaf, part, demand, depth - 1));
			if (most > 0) return most;
		}
		return most;
	}

	bool hasChain(std::uint32_t leaf, const Triangle& piece, const Demand& demand, double given) const
	{
		if (demand.box && !inBox(leaf, piece, given)) return false;
		std::vector<std::uint32_t> open = {leaf}, seen = {leaf};
		while (!open.empty())
		{
			const std::uint32_t node = open.back();
			open.pop_back();
			if (node != leaf && !isLink(node, piece, demand, given)) continue;
			if (node == m_s.h.root()) return true;
			for (const std::uint32_t parent : m_s.parents[node])
			{
				if (std::find(seen.begin(), seen.end(), parent) != seen.end()) continue;
				seen.push_back(parent);
				open.push_back(parent);
			}
		}
		return false;
	}

	bool inBox(std::uint32_t node, const Triangle& piece, double given) const
	{
		return std::all_of(piece.begin(), piece.end(),
						   [&](const Vec3& p) { return outsideBox(m_s.h.cullBox(node), p) <= given; });
	}

	bool isLink(std::uint32_t node, const Triangle& piece, const Demand& demand, double given) const
	{
		const Node& n = m_s.h.node(node);
		if (demand.box && !inBox(node, piece, given)) return false;
		const double cover = double(n.cover) + given, reach = double(n.reach) + given;
		if (!m_s.isContact(node)) return !demand.cover || withinHull(node, piece, cover);
		const double toFaces = distanceToFaces(node, piece, demand.cover ? cover : reach, std::max(cover, reach));
		if (demand.reach && toFaces > reach) return false;
		return !demand.cover || toFaces <= cover || withinHull(node, piece, cover);
	}

	bool withinHull(std::uint32_t node, const Triangle& piece, double bound) const
	{
		return std::all_of(piece.begin(), piece.end(),
						   [&](const Vec3& p)
						   { return distanceToHull(m_hulls[node], p, 0.1 * m_s.slack, bound) <= bound; });
	}

	// An upper bound of the piece's distance to the real faces, infinite beyond `farthest`; stops at the first face
	// within `enough`.
	double distanceToFaces(std::uint32_t node, const Triangle& piece, double enough, double farthest) const
	{
		double best = std::numeric_limits<double>::infinity();
		for (const auto& [face, box] : m_faces[node])
		{
			if (box.distance(piece[0]) > farthest) continue;
			double most = 0;
			for (const Vec3& p : piece)
			{
				most = std::max(most, distance(face, p));
				if (most >= best) break;
			}
			best = std::min(best, most);
			if (best <= enough) break;
		}
		return best;
	}

	const Subject& m_s;
	std::vector<std::vector<Vec3>> m_hulls;
	struct Face
	{
		Triangle triangle;
		Box box;
	};
	std::vector<std::vector<Face>> m_faces;
};
}  // namespace

Invariants checkCoverage(const Subject& s)
{
	constexpr int kDepth = 6;
	const Chains chains(s);
	Tally cover("cover"), reach("reach"), box("culling-of-surface"), chain("chains");
	s.forEach("cover", s.h.levels()[0].faceCount,
			  [&](std::size_t i)
			  {
				  const std::uint32_t f = std::uint32_t(i);
				  const double together = chains.allowanceFor(f, {}, kDepth);
				  const auto separately = [&](Tally& tally, const Demand& demand, const char* what)
				  {
					  const double needed = together > 0 ? chains.allowanceFor(f, demand, kDepth) : 0;
					  tally.add(f, needed,
								fmt::format("input face {} has no chain to the root within {}; it needs {:.3g} more", f,
											what, needed));
				  };
				  separately(cover, {true, false, false}, "cover");
				  separately(reach, {false, true, false}, "reach");
				  separately(box, {false, false, true}, "the culling boxes");
				  chain.add(
					  f, together,
					  fmt::format(
						  "input face {} has no chain to the root within cover, reach and culling boxes together", f));
			  });
	return {cover.result(), reach.result(), box.result(), chain.result()};
}
}  // namespace clod::check
