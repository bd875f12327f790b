// SPDX-License-Identifier: GPL-3.0-or-later
// Do two solids overlap, and how deep, along a motion: by all edges of one against all faces of the other that can meet
// at all during the motions looked at.
//
// Depth is local: of a vertex inside, its distance to the other surface; of an edge that passes through, how far it
// must be moved at right angles to itself: out over the ridge of the faces it entered and left by, or towards the
// surface nearest to its middle, whichever is less. The largest counts.
#pragma once
#include <array>
#include <utility>
#include <vector>

#include "tests/oracle/Solid.h"

namespace clod::oracle
{
// Where A's material has gone after the share `t` of a step: its centre of mass on a line, turned about it. Frame A.
Transform displacement(const RelativeMotion& motion, const Vec3& center, double t);

class Overlap
{
public:
	// Motions under which no point of A moves farther than `reach`.
	Overlap(const Solid& a, const Solid& b, const Transform& aFromB, double reach);

	// A displaced by `moved` (frame A), by which no point of it went farther than `way`.
	bool isAny(const Transform& moved, double way = 1e300) { return find(moved, way, false) > 0; }
	double depth(const Transform& moved, double way = 1e300) { return find(moved, way, true); }
	// Wholly apart at the pose, containment excluded.
	bool isApart();

private:
	struct Crossing
	{
		double at;
		std::uint32_t face;
		bool isEntry;
	};
	// An edge of one solid against faces of the other.
	struct Side
	{
		const Solid* solid;  // the one pierced
		const Solid* other;  // whose edges pierce
		std::vector<std::uint32_t> edges, firstFace, faces;
		std::vector<double> gaps, leastGaps;  // of their boxes at the pose: of each pair, of each edge
	};
	using EdgeFacePairs = std::vector<std::pair<std::pair<std::uint32_t, std::uint32_t>, double>>;  // and their gap
	std::array<EdgeFacePairs, 2> nearPairs(double reach) const;  // as m_sides
	void collect(double reach);
	void place(const Transform& moved);
	double find(const Transform& moved, double way, bool isDepth);
	double findSide(bool edgesOfA, double way, bool isDepth);
	double depthOf(bool edgesOfA, std::uint32_t edge);
	double segmentDepth(bool edgesOfA, const Vec3& from, const Vec3& to, const Crossing& in, const Crossing& out) const;
	double vertexDepth(bool ofA, std::uint32_t vertex);

	const Solid& m_a;
	const Solid& m_b;
	Transform m_aFromB, m_moved, m_back, m_bFromA;
	Side m_sides[2];                // 0: edges of A through B
	std::vector<Vec3> m_atA, m_atB;  // vertices now, frame A
	std::vector<std::uint32_t> m_usedA;
	std::vector<std::uint32_t> m_usedFacesA;
	std::vector<Vec3> m_normalsA, m_normalsB;
	std::vector<std::uint32_t> m_seenA, m_seenB;  // in which call a vertex was looked at
	std::uint32_t m_call = 0;
	std::vector<Crossing> m_crossings;
};
}  // namespace clod::oracle
