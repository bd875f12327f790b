// SPDX-License-Identifier: GPL-3.0-or-later
// One edge collapse under the convexity constraints: topology, start position, optional filter, local constraints,
// search for the global ones.
// Source: the paper, sec. 4.2.2 (the five steps of the filtered edge collapse).
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "builder/patches/DeviationGuard.h"
#include "builder/patches/HalfSpaceProgram.h"
#include "builder/patches/Hinge.h"
#include "builder/patches/Quadric.h"
#include "builder/patches/Validity.h"

namespace clod::builder
{
enum class Outcome
{
	Done,
	Blocked,     // by topology or convexity
	OutOfBound,  // by the deviation guard only
};

class Collapser
{
public:
	// The paper's placement (config.paper) filters and bisects.
	Collapser(PatchMesh& mesh, Validity& validity, DeviationGuard& guard, const BuildConfig& config);

	// 1 / length of the edge projected along the mean normal of the faces round it (Otaduy & Lin, SIGGRAPH 2003).
	double resolution(std::uint32_t u, std::uint32_t w) const;
	// Least sum of squared distances to the planes that have gone into both ends, weighted by area, and a little for
	// the edge's length, which decides where the surface is flat (Garland & Heckbert 1997).
	double quadricError(std::uint32_t u, std::uint32_t w) const;
	// Joins w into u. The edge must exist.
	Outcome attempt(std::uint32_t u, std::uint32_t w);
	// Of the last successful attempt: faces round the new vertex, in order.
	const std::vector<std::uint32_t>& newStar() const { return m_star; }
	const std::vector<Quadric>& quadrics() const { return m_quadrics; }
	void restore(std::vector<Quadric>&& quadrics) { m_quadrics = std::move(quadrics); }

private:
	// 1 topology
	bool findStar(std::uint32_t u, std::uint32_t w);
	bool findRing();
	bool findPatches();
	bool staysConnected(std::uint32_t patch) const;
	// 2 to 4 positions
	Quadric joinedQuadric(std::uint32_t u, std::uint32_t w) const;
	void findRows();
	std::optional<Vec3> constrained(const Vec3& wanted) const;
	Star ringPoints() const;
	std::optional<Vec3> searchPaper(const Vec3& start);
	std::optional<Vec3> searchPlain(const Vec3& start);
	// 5 global constraints
	bool accepts(const Vec3& position);
	bool facesAreSound();
	bool staysOutOfOtherHulls() const;
	bool keepsOthersCovered();
	bool doesNotCross() const;
	void commit(const Vec3& position);
	void relink(std::uint32_t removed);
	void vanish(std::uint32_t patch);
	std::uint32_t heirOf(std::uint32_t patch) const;

	PatchMesh& m_mesh;
	Validity& m_validity;
	DeviationGuard& m_guard;
	const BuildConfig& m_config;
	std::vector<Quadric> m_quadrics;

	std::uint32_t m_u = kNone, m_w = kNone;
	Vec3 m_middle;
	double m_ringRadius = 0;
	std::array<std::uint32_t, 2> m_removed{}, m_opposite{};
	std::vector<std::uint32_t> m_star;  // surviving faces round the edge, counter-clockwise
	std::vector<std::uint32_t> m_ring;  // m_ring[i], m_ring[i + 1] is the far edge of m_star[i]
	std::vector<std::uint32_t> m_oldFaces;
	std::vector<std::uint32_t> m_faceFrom;  // by vertex, in findRing: the face whose far edge starts there
	std::vector<std::uint32_t> m_runs;      // by patch, in findPatches: runs of faces round the edge
	std::vector<std::uint32_t> m_scratch;
	std::vector<std::uint32_t> m_patches;    // that keep at least one face
	std::vector<std::uint32_t> m_vanishing;  // that lose all
	std::vector<Plane> m_rows;
	std::vector<TrianglePoints> m_starPoints;
	std::vector<std::vector<Plane>> m_newHulls;
	std::vector<std::uint32_t> m_leaning;  // patches, own and others, with their supports after the move
	std::vector<std::vector<std::uint32_t>> m_supports;
	bool m_outOfBound = false;
};
}  // namespace clod::builder
