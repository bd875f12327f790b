// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Assignment.h"

#include <algorithm>
#include <tuple>

#include "builder/assemble/NearestPatches.h"
#include "builder/assemble/Parallel.h"

namespace clod::builder
{
namespace
{
// The four children of the midpoint split; child k of code interval [first, first + 4 size) starts at first + k size.
Triangle childTriangle(const Triangle& t, std::uint32_t k)
{
	const Vec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
	switch (k)
	{
		case 0:
			return {t.a, ab, ca};
		case 1:
			return {ab, t.b, bc};
		case 2:
			return {ca, bc, t.c};
		default:
			return {ab, bc, ca};
	}
}

double longestEdge(const Triangle& t)
{
	return std::max({length(t.b - t.a), length(t.c - t.b), length(t.a - t.c)});
}

struct SplitRule
{
	double tolerance;     // added distance that does not deserve a split
	double loyalty;       // added distance for which a piece stays with the patch its owner below goes to
	double smallestEdge;  // pieces with shorter edges are not split
};

class FaceSplitter
{
public:
	FaceSplitter(const NearestPatches& nearest, const SplitRule& rule, std::uint32_t preferred, std::uint32_t face,
				 const Vec3& normal, std::vector<Piece>& out)
		: m_nearest(nearest), m_rule(rule), m_preferred(preferred), m_face(face), m_normal(normal), m_out(out)
	{
	}

	void split(const Triangle& t, const Lookups& at, std::uint32_t first, std::uint32_t count)
	{
		double excess = 0;
		const bool loyal = m_preferred != kNone && excessOf(m_preferred, t, at) <= m_rule.loyalty;
		const std::uint32_t owner = loyal ? m_preferred : bestOwner(t, at, excess);
		if (loyal || excess <= m_rule.tolerance || count == 1 || longestEdge(t) <= m_rule.smallestEdge)
		{
			m_out.push_back({m_face, std::uint16_t(first), std::uint16_t(count), owner});
			return;
		}
		const Triangle inner = childTriangle(t, 3);
		const Lookup ab = lookUp(inner.a), bc = lookUp(inner.b), ca = lookUp(inner.c);
		const Lookup corners[4][3] = {{at[0], ab, ca}, {ab, at[1], bc}, {ca, bc, at[2]}, {ab, bc, ca}};
		for (std::uint32_t k = 0; k < 4; ++k)
		{
			const Triangle child = childTriangle(t, k);
			const Lookup middle = k == 3 ? at[3] : lookUp(centroid(child));
			split(child, {corners[k][0], corners[k][1], corners[k][2], middle}, first + k * (count / 4), count / 4);
		}
	}

private:
	Lookup lookUp(const Vec3& p) const { return m_nearest.at(p, m_normal); }

	// The candidate whose faces are nearest to the farthest corner; excess: what it costs over each corner's own
	// nearest.
	std::uint32_t bestOwner(const Triangle& t, const Lookups& at, double& excess) const
	{
		std::uint32_t owner = at[3].patch;
		double least = std::numeric_limits<double>::infinity();
		for (std::size_t k : {3, 0, 1, 2})
		{
			if (k != 3 && (at[k].patch == owner || at[k].patch == at[3].patch)) continue;
			const double most = excessOf(at[k].patch, t, at);
			if (most < least) least = most, owner = at[k].patch;
			if (least <= m_rule.tolerance) break;
		}
		excess = least;
		return owner;
	}

	// What it costs over each corner's own nearest patch.
	double excessOf(std::uint32_t patch, const Triangle& t, const Lookups& at) const
	{
		double most = 0;
		for (std::size_t i = 0; i < 3; ++i)
			if (patch != at[i].patch) most = std::max(most, m_nearest.distanceTo(patch, t[int(i)]) - at[i].distance);
		return most;
	}

	const NearestPatches& m_nearest;
	const SplitRule m_rule;
	const std::uint32_t m_preferred;
	const std::uint32_t m_face;
	const Vec3 m_normal;
	std::vector<Piece>& m_out;
};

// How far the level typically is from the input: the 90th percentile over a sample of face centroids.
double typicalDistance(const TriangleTree& input, const NearestPatches& nearest)
{
	constexpr std::size_t kSamples = 2000;
	const std::size_t step = std::max<std::size_t>(1, input.size() / kSamples);
	std::vector<double> distances;
	for (std::size_t i = 0; i < input.size(); i += step)
	{
		const Triangle& t = input.triangle(std::uint32_t(i));
		distances.push_back(nearest.at(centroid(t), areaVector(t)).distance);
	}
	std::sort(distances.begin(), distances.end());
	return distances[distances.size() * 9 / 10];
}

// The smallest piece of the input surface next to a patch's middle.
Piece pieceNextTo(const TriangleTree& input, const NearestPatches& nearest, std::uint32_t patch)
{
	Vec3 normal;
	const Vec3 middle = nearest.middleOf(patch, normal);
	const auto same = [&](std::uint32_t i) { return dot(areaVector(input.triangle(i)), normal) > 0; };
	TriangleTree::Nearest found = input.nearest(middle, same, std::numeric_limits<double>::infinity());
	if (found.triangle == kNone) found = input.nearest(middle);
	Triangle t = input.triangle(found.triangle);
	std::uint32_t first = 0, count = Piece::kCodes;
	while (count > 1)
	{
		std::uint32_t best = 0;
		for (std::uint32_t k = 1; k < 4; ++k)
			if (distanceSquared(middle, childTriangle(t, k)) < distanceSquared(middle, childTriangle(t, best)))
				best = k;
		t = childTriangle(t, best);
		count /= 4;
		first += best * count;
	}
	return {found.triangle, std::uint16_t(first), std::uint16_t(count), patch};
}
}  // namespace

Triangle pieceTriangle(const Triangle& face, const Piece& piece)
{
	Triangle t = face;
	for (std::uint32_t count = Piece::kCodes / 4, rest = piece.first; count >= piece.count; count /= 4)
	{
		t = childTriangle(t, rest / count);
		rest %= count;
	}
	return t;
}

std::vector<Triangle> trianglesOf(const std::vector<Piece>& pieces, const TriangleTree& input)
{
	std::vector<Triangle> triangles;
	triangles.reserve(pieces.size());
	for (const Piece& piece : pieces) triangles.push_back(pieceTriangle(input.triangle(piece.face), piece));
	return triangles;
}

LevelAssignment assignByLabel(const std::vector<std::uint32_t>& patchOfFace)
{
	LevelAssignment result;
	for (std::uint32_t i = 0; i < patchOfFace.size(); ++i)
	{
		result.pieces.push_back({i, 0, std::uint16_t(Piece::kCodes), patchOfFace[i]});
	}
	return result;
}

namespace
{
std::vector<Overlap> summed(std::vector<Overlap> list)
{
	std::stable_sort(list.begin(), list.end(),
					 [](const Overlap& a, const Overlap& b)
					 { return std::tie(a.coarse, a.fine) < std::tie(b.coarse, b.fine); });
	std::vector<Overlap> result;
	for (const Overlap& o : list)
	{
		if (!result.empty() && result.back().coarse == o.coarse && result.back().fine == o.fine)
			result.back().area += o.area;
		else
			result.push_back(o);
	}
	return result;
}

// For each input face: the patch that most of the surface of the face's owner in the level below goes to.
std::vector<std::uint32_t> preferredPatches(const TriangleTree& input, const std::vector<Lookups>& lookups,
											const LevelAssignment& below)
{
	std::vector<std::uint32_t> byFace, ownerBelow(input.size(), kNone);
	for (const Lookups& at : lookups) byFace.push_back(at[3].patch);
	std::vector<Overlap> votes;
	for (const Piece& piece : below.pieces)
	{
		const double area = length(areaVector(input.triangle(piece.face))) * piece.count;
		votes.push_back({piece.owner, byFace[piece.face], area});
		if (ownerBelow[piece.face] == kNone || piece.count == Piece::kCodes) ownerBelow[piece.face] = piece.owner;
	}
	std::vector<std::uint32_t> favourite;
	std::vector<double> most;
	for (const Overlap& vote : summed(std::move(votes)))
	{
		if (vote.coarse >= favourite.size())
		{
			favourite.resize(vote.coarse + 1, kNone);
			most.resize(vote.coarse + 1, -1);
		}
		if (vote.area > most[vote.coarse]) most[vote.coarse] = vote.area, favourite[vote.coarse] = vote.fine;
	}
	for (std::size_t i = 0; i < byFace.size(); ++i) byFace[i] = favourite[ownerBelow[i]];
	return byFace;
}
}  // namespace

LevelAssignment assignToNearest(const Mesh& mesh, const TriangleTree& input, const Lod& lod,
								const LevelAssignment& below, const AssignmentScale& scale)
{
	const NearestPatches nearest(lod);
	const double typical = typicalDistance(input, nearest);
	const double radius = scale.radius;
	const SplitRule rule{std::max(0.2 * typical, 2e-5 * radius), std::max(0.5 * typical, 1e-4 * radius),
						 std::max(0.5 * typical, 5e-4 * radius)};
	const std::vector<Lookups> lookups = nearest.ofFaces(mesh, input, scale.threads);
	const std::vector<std::uint32_t> preferred = preferredPatches(input, lookups, below);
	std::vector<std::vector<Piece>> perFace(input.size());
	parallelFor(input.size(), scale.threads,
				[&](std::size_t i)
				{
					const Triangle& t = input.triangle(std::uint32_t(i));
					FaceSplitter(nearest, rule, preferred[i], std::uint32_t(i), areaVector(t), perFace[i])
						.split(t, lookups[i], 0, Piece::kCodes);
				});
	LevelAssignment result;
	std::vector<bool> used(lod.patchCount, false);
	for (const std::vector<Piece>& pieces : perFace)
		for (const Piece& piece : pieces)
		{
			result.pieces.push_back(piece);
			used[piece.owner] = true;
		}
	for (std::uint32_t patch = 0; patch < lod.patchCount; ++patch)
		if (!used[patch]) result.extra.push_back(pieceNextTo(input, nearest, patch));
	return result;
}

namespace
{
struct Join
{
	std::vector<Overlap> found;
	void add(const TriangleTree& input, const Piece& fine, const Piece& coarse)
	{
		const double share = double(std::min(fine.count, coarse.count)) / double(Piece::kCodes);
		found.push_back({coarse.owner, fine.owner, share * length(areaVector(input.triangle(fine.face)))});
	}
};

bool intersects(const Piece& a, const Piece& b)
{
	return a.face == b.face && a.first < b.first + b.count && b.first < a.first + a.count;
}

bool endsBefore(const Piece& a, const Piece& b)
{
	return a.face < b.face || (a.face == b.face && a.first + a.count <= b.first);
}

// First of the sorted pieces that does not end before the given one.
std::size_t firstMeeting(const std::vector<Piece>& pieces, const Piece& other)
{
	return std::size_t(std::lower_bound(pieces.begin(), pieces.end(), other, endsBefore) - pieces.begin());
}

}  // namespace

std::vector<Overlap> overlaps(const TriangleTree& input, const LevelAssignment& fine, const LevelAssignment& coarse)
{
	Join join;
	std::size_t c = 0;
	for (const Piece& f : fine.pieces)
	{
		while (c < coarse.pieces.size() && endsBefore(coarse.pieces[c], f)) ++c;
		for (std::size_t k = c; k < coarse.pieces.size() && intersects(coarse.pieces[k], f); ++k)
			join.add(input, f, coarse.pieces[k]);
	}
	for (const Piece& f : fine.extra)
		for (std::size_t k = firstMeeting(coarse.pieces, f);
			 k < coarse.pieces.size() && intersects(coarse.pieces[k], f); ++k)
			join.add(input, f, coarse.pieces[k]);
	for (const Piece& e : coarse.extra)
		for (std::size_t k = firstMeeting(fine.pieces, e); k < fine.pieces.size() && intersects(fine.pieces[k], e); ++k)
			join.add(input, fine.pieces[k], e);
	return summed(std::move(join.found));
}
}  // namespace clod::builder
