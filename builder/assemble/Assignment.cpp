// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Assignment.h"

#include <algorithm>
#include <memory>
#include <tuple>

#include "builder/assemble/FaceSplitter.h"
#include "builder/assemble/NearestPatches.h"
#include "builder/assemble/Parallel.h"

namespace clod::builder
{
namespace
{
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
	return {found.triangle, first, count, patch};
}
}  // namespace

LevelAssignment assignByLabel(const std::vector<std::uint32_t>& patchOfFace)
{
	LevelAssignment result;
	for (std::uint32_t i = 0; i < patchOfFace.size(); ++i)
	{
		result.pieces.push_back({i, 0, Piece::kCodes, patchOfFace[i]});
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
	const double least = 1e-4 * radius;
	const SplitRule rule{std::max(0.2 * typical, least), std::max(typical, least), std::max(0.5 * typical, least),
						 std::max(0.5 * typical, least)};
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
