// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Assignment.h"

#include <algorithm>
#include <memory>
#include <tuple>

#include "builder/assemble/NearestPatches.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/VisitMarks.h"

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

struct SplitRule
{
	double tolerance;     // added distance that does not deserve a split
	double loyalty;       // added distance for which a piece stays with the patch its owner below goes to
	double smallestEdge;  // pieces with shorter edges are not split
};

// The midpoint-split tree of one face. Its corners lie on a lattice, where each is looked up once.
class FaceSplitter
{
public:
	FaceSplitter(const NearestPatches& nearest, const SplitRule& rule) : m_nearest(nearest), m_rule(rule) {}

	// Appends the face's pieces. at: of its corners and its middle.
	void split(std::uint32_t face, const Triangle& t, const Lookups& at, std::uint32_t preferred,
			   std::vector<Piece>& out)
	{
		m_face = face;
		m_normal = areaVector(t);
		m_preferred = preferred;
		m_out = &out;
		m_candidates.clear();
		m_seen.restart(kSide * kSide);
		const Corners corners{0, kSide - 1, (kSide - 1) * kSide};
		for (std::size_t k = 0; k < 3; ++k)
		{
			m_seen.add(corners[k]);
			m_points[corners[k]] = {t[int(k)], at[k], {corners[k], corners[k]}, 0, {}};
		}
		split(corners, 0, Piece::kCodes);
	}

private:
	static constexpr std::uint32_t kSide = (1u << Piece::kDepth) + 1;
	static constexpr std::size_t kRemembered = 8;  // patches a point remembers its distance to
	using Corners = std::array<std::uint32_t, 3>;  // places on the lattice: row * kSide + column

	struct Point
	{
		Vec3 p;
		Lookup nearest;
		std::array<std::uint32_t, 2> between;  // the points it is the midpoint of
		std::uint32_t known;                   // bits: whose excess is
		std::array<double, kRemembered> excess;
	};

	void split(const Corners& c, std::uint32_t code, std::uint32_t count)
	{
		double excess = 0;
		const bool loyal = m_preferred != kNone && excessOf(m_preferred, c, m_rule.loyalty) <= m_rule.loyalty;
		const std::uint32_t owner = loyal ? m_preferred : bestOwner(c, excess);
		if (loyal || excess <= m_rule.tolerance || count == 1 || longestEdge(c) <= m_rule.smallestEdge)
		{
			m_out->push_back({m_face, std::uint16_t(code), std::uint16_t(count), owner});
			return;
		}
		const std::uint32_t ab = midpoint(c[0], c[1]), bc = midpoint(c[1], c[2]), ca = midpoint(c[2], c[0]);
		const Corners children[4] = {{c[0], ab, ca}, {ab, c[1], bc}, {ca, bc, c[2]}, {ab, bc, ca}};  // as childTriangle
		for (std::uint32_t k = 0; k < 4; ++k) split(children[k], code + k * (count / 4), count / 4);
	}

	std::uint32_t midpoint(std::uint32_t a, std::uint32_t b)
	{
		const std::uint32_t middle = (a / kSide + b / kSide) / 2 * kSide + (a % kSide + b % kSide) / 2;
		if (m_seen.add(middle))
		{
			const Vec3 p = 0.5 * (m_points[a].p + m_points[b].p);
			m_points[middle] = {p, m_nearest.at(p, m_normal), {a, b}, 0, {}};
		}
		return middle;
	}

	double longestEdge(const Corners& c) const
	{
		const Vec3 &u = m_points[c[0]].p, &v = m_points[c[1]].p, &w = m_points[c[2]].p;
		return std::max({length(v - u), length(w - v), length(u - w)});
	}

	// The candidate whose faces are nearest to the farthest corner; excess: what it costs over each corner's own
	// nearest. The patch nearest to the middle is asked for only where no corner's will do.
	std::uint32_t bestOwner(const Corners& c, double& excess)
	{
		std::uint32_t owner = kNone;
		excess = std::numeric_limits<double>::infinity();
		const auto consider = [&](std::uint32_t candidate)
		{
			if (candidate == owner) return;
			const double most = excessOf(candidate, c, excess);
			if (most < excess) excess = most, owner = candidate;
		};
		for (std::size_t k = 0; k < 3 && excess > m_rule.tolerance; ++k) consider(m_points[c[k]].nearest.patch);
		if (excess > m_rule.tolerance)
			consider(m_nearest.at(centroid({m_points[c[0]].p, m_points[c[1]].p, m_points[c[2]].p}), m_normal).patch);
		return owner;
	}

	// What a patch costs over each corner's own nearest; more than the limit is not looked at to the end.
	double excessOf(std::uint32_t patch, const Corners& c, double limit)
	{
		double most = 0;
		for (std::size_t i = 0; i < 3 && most <= limit; ++i)
			if (patch != m_points[c[i]].nearest.patch) most = std::max(most, excessAt(c[i], patch));
		return most;
	}

	double excessAt(std::uint32_t place, std::uint32_t patch)
	{
		Point& point = m_points[place];
		const std::size_t slot = slotOf(patch);
		if (slot < kRemembered && (point.known >> slot & 1)) return point.excess[slot];
		// No farther than from the points it lies between, and the way from there.
		double limit = std::numeric_limits<double>::infinity();
		for (const std::uint32_t other : point.between)
		{
			const Point& from = m_points[other];
			const bool isNearest = from.nearest.patch == patch;
			if (!isNearest && (slot >= kRemembered || !(from.known >> slot & 1))) continue;
			const double there = from.nearest.distance + (isNearest ? 0 : from.excess[slot]);
			limit = std::min(limit, (there + length(from.p - point.p)) * (1 + 1e-9) + 1e-300);
		}
		const double excess = m_nearest.distanceTo(patch, point.p, limit) - point.nearest.distance;
		if (slot < kRemembered)
		{
			point.known |= 1u << slot;
			point.excess[slot] = excess;
		}
		return excess;
	}

	std::size_t slotOf(std::uint32_t patch)
	{
		const auto found = std::find(m_candidates.begin(), m_candidates.end(), patch);
		const std::size_t slot = std::size_t(found - m_candidates.begin());
		if (found == m_candidates.end()) m_candidates.push_back(patch);
		return slot;
	}

	const NearestPatches& m_nearest;
	const SplitRule m_rule;
	std::uint32_t m_face = kNone, m_preferred = kNone;
	Vec3 m_normal;
	std::vector<Piece>* m_out = nullptr;
	std::vector<std::uint32_t> m_candidates;
	VisitMarks m_seen;
	std::array<Point, kSide * kSide> m_points;
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

Territory territoryOf(const std::vector<Piece>& pieces, const Mesh& input)
{
	thread_local VisitMarks seen;
	thread_local std::vector<std::uint32_t> cornerOf;
	seen.restart(input.vertices.size());
	cornerOf.resize(input.vertices.size());
	Territory result;
	const auto added = [&result](const Vec3& p)
	{
		result.corners.push_back(p);
		return std::uint32_t(result.corners.size() - 1);
	};
	result.triangles.reserve(pieces.size());
	for (const Piece& piece : pieces)
	{
		const auto& t = input.triangles[piece.face];
		if (piece.count == Piece::kCodes)
		{
			for (const std::uint32_t v : t)
				if (seen.add(v)) cornerOf[v] = added(input.vertices[v]);
			result.triangles.push_back({cornerOf[t[0]], cornerOf[t[1]], cornerOf[t[2]]});
			continue;
		}
		const Triangle part = pieceTriangle({input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]}, piece);
		const std::uint32_t a = added(part.a), b = added(part.b), c = added(part.c);
		result.triangles.push_back({a, b, c});
	}
	return result;
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
	// Faces in chunks: a splitter is large, the pieces of one face are few.
	constexpr std::size_t kChunk = 256;
	std::vector<std::vector<Piece>> perChunk((input.size() + kChunk - 1) / kChunk);
	parallelFor(perChunk.size(), scale.threads,
				[&](std::size_t chunk)
				{
					const auto splitter = std::make_unique<FaceSplitter>(nearest, rule);
					for (std::size_t i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, input.size()); ++i)
						splitter->split(std::uint32_t(i), input.triangle(std::uint32_t(i)), lookups[i], preferred[i],
										perChunk[chunk]);
				});
	LevelAssignment result;
	std::vector<bool> used(lod.patchCount, false);
	std::size_t count = 0;
	for (const std::vector<Piece>& pieces : perChunk) count += pieces.size();
	result.pieces.reserve(count);
	for (const std::vector<Piece>& pieces : perChunk)
		result.pieces.insert(result.pieces.end(), pieces.begin(), pieces.end());
	for (const Piece& piece : result.pieces) used[piece.owner] = true;
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
