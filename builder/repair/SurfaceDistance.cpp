// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/SurfaceDistance.h"

#include <algorithm>
#include <array>
#include <queue>

#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
namespace
{
constexpr double kTightness = 1.02;
constexpr std::size_t kPieceLimit = 300'000;

struct Sample
{
	Vec3 point;
	double distance = 0;         // to B
	std::uint32_t triangle = 0;  // the nearest of B
};

struct Piece
{
	std::array<Sample, 3> corners;
	double upper = 0;
	bool operator<(const Piece& other) const { return upper < other.upper; }
};

class Search
{
public:
	Search(const TriangleTree& to, double rounding) : m_to(to), m_rounding(rounding) {}

	void add(const Triangle& t)
	{
		Piece piece;
		for (int i = 0; i < 3; ++i) piece.corners[std::size_t(i)] = sample(t[i]);
		push(piece);
	}
	DistanceBracket finish()
	{
		std::size_t pieces = 0;
		while (!m_open.empty() && m_open.top().upper > enough() && pieces < kPieceLimit)
		{
			const Piece piece = m_open.top();
			m_open.pop();
			split(piece);
			pieces += 2;
		}
		const double open = m_open.empty() ? 0 : m_open.top().upper;
		// Distances are computed in double: a few roundings of coordinates as long as the surfaces.
		m_best.upper = std::max({open, m_settled, m_best.lower});
		return m_best;
	}

private:
	double enough() const { return std::max(kTightness * m_best.lower, m_rounding); }
	Sample sample(const Vec3& p)
	{
		const TriangleTree::Nearest nearest = m_to.nearest(p);
		const Sample result{p, std::sqrt(nearest.distanceSquared), nearest.triangle};
		if (result.distance > m_best.lower)
		{
			m_best.lower = result.distance;
			m_best.at = p;
		}
		return result;
	}
	// The largest distance of the corners to one triangle, the best of those found nearest.
	double bound(const Piece& piece, std::uint32_t extra) const
	{
		double best = std::numeric_limits<double>::infinity();
		for (const std::uint32_t candidate :
			 {piece.corners[0].triangle, piece.corners[1].triangle, piece.corners[2].triangle, extra})
		{
			double most = 0;
			for (const Sample& corner : piece.corners)
				most = std::max(most, distanceSquared(corner.point, m_to.triangle(candidate)));
			best = std::min(best, most);
		}
		return std::sqrt(best);
	}
	void push(Piece& piece)
	{
		const auto& c = piece.corners;
		const Sample centre = sample((1.0 / 3) * (c[0].point + c[1].point + c[2].point));
		double radius = 0;
		for (const Sample& corner : c) radius = std::max(radius, length(corner.point - centre.point));
		piece.upper = std::min(bound(piece, centre.triangle), centre.distance + radius);
		if (piece.upper <= m_rounding)
			m_settled = std::max(m_settled, piece.upper);
		else
			m_open.push(piece);
	}
	// Across the longest edge.
	void split(const Piece& piece)
	{
		std::size_t longest = 0;
		double most = -1;
		for (std::size_t e = 0; e < 3; ++e)
		{
			const double l = lengthSquared(piece.corners[(e + 1) % 3].point - piece.corners[e].point);
			if (l > most) longest = e;
			most = std::max(most, l);
		}
		const Sample &a = piece.corners[longest], &b = piece.corners[(longest + 1) % 3],
					 &c = piece.corners[(longest + 2) % 3];
		const Sample middle = sample(0.5 * (a.point + b.point));
		Piece first{{a, middle, c}}, second{{middle, b, c}};
		push(first);
		push(second);
	}

	const TriangleTree& m_to;
	double m_rounding;
	std::priority_queue<Piece> m_open;
	double m_settled = 0;
	DistanceBracket m_best;
};
}  // namespace

DistanceBracket directedDistance(const Mesh& from, const Mesh& to, double rounding)
{
	if (from.triangles.empty()) return {};
	if (to.triangles.empty())
	{
		const double infinity = std::numeric_limits<double>::infinity();
		return {infinity, infinity, from.vertices[from.triangles.front()[0]]};
	}
	const TriangleTree tree(to);
	Search search(tree, rounding);
	for (const auto& t : from.triangles) search.add({from.vertices[t[0]], from.vertices[t[1]], from.vertices[t[2]]});
	return search.finish();
}
}  // namespace clod::builder
