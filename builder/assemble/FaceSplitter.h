// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts an input face into pieces, each with the patch of a level that answers for it.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "builder/assemble/NearestPatches.h"
#include "builder/assemble/Piece.h"
#include "builder/assemble/VisitMarks.h"

namespace clod::builder
{
struct SplitRule
{
	double tolerance;     // added distance that does not deserve a split,
	double ofSmall;       // nor, of a piece that was split kFirstSplits times
	double loyalty;       // added distance for which a piece stays with the patch its owner below goes to
	double smallestEdge;  // pieces with shorter edges are not split
	// Small pieces are shared by more nodes than large ones: they are split further where it counts, as those of tall
	// faces are.
	static constexpr int kFirstSplits = 6;
};

// The midpoint-split tree of one face. Its corners lie on a lattice, where each is looked up once.
class FaceSplitter
{
public:
	FaceSplitter(const NearestPatches& nearest, const SplitRule& rule) : m_nearest(nearest), m_rule(rule) {}

	// Appends the face's pieces. at: of its corners and its middle. preferred: the patch that most of its owner in the
	// level below goes to, or none.
	void split(std::uint32_t face, const Triangle& t, const Lookups& at, std::uint32_t preferred,
			   std::vector<Piece>& out);

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

	void split(const Corners& c, std::uint32_t code, std::uint32_t count);
	std::uint32_t midpoint(std::uint32_t a, std::uint32_t b);
	double longestEdge(const Corners& c) const;
	// The candidate whose faces are nearest to the farthest corner; excess: what it costs over each corner's own
	// nearest. The patch nearest to the middle is asked for only where no corner's will do.
	std::uint32_t bestOwner(const Corners& c, double& excess);
	// What a patch costs over each corner's own nearest; more than the limit is not looked at to the end.
	double excessOf(std::uint32_t patch, const Corners& c, double limit);
	double excessAt(std::uint32_t place, std::uint32_t patch);
	std::size_t slotOf(std::uint32_t patch);
	Point& pointAt(std::uint32_t place) { return m_points[m_numberOf[place]]; }
	const Point& pointAt(std::uint32_t place) const { return m_points[m_numberOf[place]]; }
	// False if the place has one.
	bool addPoint(std::uint32_t place);

	const NearestPatches& m_nearest;
	const SplitRule m_rule;
	std::uint32_t m_face = kNone, m_preferred = kNone;
	Vec3 m_normal;
	std::vector<Piece>* m_out = nullptr;
	std::vector<std::uint32_t> m_candidates;
	VisitMarks m_seen;
	std::array<std::uint32_t, kSide * kSide> m_numberOf;  // of the places seen, in
	std::vector<Point> m_points;
};
}  // namespace clod::builder
