// SPDX-License-Identifier: GPL-3.0-or-later
// Steps 2 to 5 of the collapse: positions and tests. Topology and bookkeeping are in CollapseTopology.cpp.
// Source: the paper, sec. 4.2.2.
#include "builder/patches/Collapse.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
constexpr double kLeastTurn = 0.2;  // cosine between a face's old and new normal
constexpr double kThinnest = 1e-3;  // height of a new face over its longest edge
constexpr int kBisections = 6;
constexpr double kNormalVariance = 0.1 * 0.1;  // of probabilistic quadrics
constexpr double kLengthShare = 1e-3 * 1e-3;   // of an edge's squared length, in its quadric error

double heightOverLength(const TrianglePoints& t)
{
	const double longest =
		std::max({lengthSquared(t[1] - t[0]), lengthSquared(t[2] - t[1]), lengthSquared(t[0] - t[2])});
	return longest > 0 ? length(cross(t[1] - t[0], t[2] - t[0])) / longest : 0;
}

bool sharesVertex(const std::array<std::uint32_t, 3>& a, const std::array<std::uint32_t, 3>& b)
{
	for (const std::uint32_t v : a)
		if (v == b[0] || v == b[1] || v == b[2]) return true;
	return false;
}
}  // namespace

Collapser::Collapser(PatchMesh& mesh, Validity& validity, DeviationGuard& guard, const BuildConfig& config)
	: m_mesh(mesh),
	  m_validity(validity),
	  m_guard(guard),
	  m_config(config),
	  m_quadrics(mesh.positions.size()),
	  m_faceFrom(mesh.positions.size(), kNone),
	  m_runs(mesh.patches.size(), kNone)
{
	const bool isProbabilistic = config.paper && config.placement == Placement::probabilistic;
	for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
	{
		const TrianglePoints t = mesh.points(f);
		for (const std::uint32_t v : mesh.faces[f])
			m_quadrics[v].addTriangle(t[0], t[1], t[2], isProbabilistic ? kNormalVariance : 0);
	}
}

double Collapser::resolution(std::uint32_t u, std::uint32_t w) const
{
	Vec3 normal;
	for (const std::uint32_t v : {u, w})
		for (const std::uint32_t f : m_mesh.star[v])
		{
			const TrianglePoints t = m_mesh.points(f);
			normal += cross(t[1] - t[0], t[2] - t[0]);
		}
	normal = normalized(normal);
	const Vec3 edge = m_mesh.positions[w] - m_mesh.positions[u];
	const double projected = length(edge - dot(edge, normal) * normal);
	return 1 / std::max(projected, 1e-9 * m_mesh.radius);
}

double Collapser::quadricError(std::uint32_t u, std::uint32_t w) const
{
	const Quadric quadric = joinedQuadric(u, w);
	const Vec3 &from = m_mesh.positions[u], &to = m_mesh.positions[w];
	return quadric.at(quadric.minimiser(0.5 * (from + to))) + kLengthShare * lengthSquared(to - from) * quadric.area();
}

Quadric Collapser::joinedQuadric(std::uint32_t u, std::uint32_t w) const
{
	Quadric quadric = m_quadrics[u];
	quadric += m_quadrics[w];
	return quadric;
}

void Collapser::findRows()
{
	m_rows.clear();
	const std::size_t n = m_ring.size();
	for (std::size_t i = 0; i < n; ++i)
	{
		const std::size_t before = (i + n - 1) % n;
		const Vec3& p = m_mesh.positions[m_ring[i]];
		const Vec3& next = m_mesh.positions[m_ring[(i + 1) % n]];
		const Vec3& previous = m_mesh.positions[m_ring[before]];
		if (m_mesh.label[m_star[before]] == m_mesh.label[m_star[i]])
		{
			const Vec3 normal = cross(p - previous, next - previous);
			if (length(normal) > 1e-12 * m_ringRadius * m_ringRadius)
			{
				const Vec3 unit = normalized(normal);
				m_rows.push_back({unit, dot(unit, previous)});
			}
		}
		const int corner = m_mesh.cornerOf(m_star[i], m_ring[i]);
		const std::uint32_t outer = m_mesh.adjacent[m_star[i]][std::size_t(corner)];
		const Plane& plane = m_mesh.planes[outer];
		if (m_mesh.label[outer] == m_mesh.label[m_star[i]]) m_rows.push_back({-plane.normal, -plane.offset});
	}
}

// The nearest position inside the half-spaces, as it will be stored; empty where none is near the old star.
std::optional<Vec3> Collapser::constrained(const Vec3& wanted) const
{
	std::vector<Plane> rows = m_rows;
	for (Plane& row : rows) row.offset -= dot(row.normal, m_middle);
	const auto x = nearestInside(wanted - m_middle, std::move(rows), 0.5 * m_validity.tolerance, m_config.seed);
	if (!x || lengthSquared(*x) > m_ringRadius * m_ringRadius) return {};
	return roundedToFloat(m_middle + *x);
}

Star Collapser::ringPoints() const
{
	Star star;
	for (std::size_t i = 0; i < m_ring.size(); ++i)
	{
		star.ring.push_back(m_mesh.positions[m_ring[i]]);
		const std::uint32_t outer = m_mesh.adjacent[m_star[i]][std::size_t(m_mesh.cornerOf(m_star[i], m_ring[i]))];
		for (const std::uint32_t v : m_mesh.faces[outer])
			if (v != m_ring[i] && v != m_ring[(i + 1) % m_ring.size()]) star.beyond.push_back(m_mesh.positions[v]);
	}
	return star;
}

std::optional<Vec3> Collapser::searchPaper(const Vec3& start)
{
	const bool filters = m_config.placement == Placement::filter;
	const Vec3 wanted = filters ? filteredPosition(start, ringPoints(), 1e-9 * m_mesh.radius) : start;
	std::optional<Vec3> high = constrained(wanted);
	if (high && accepts(*high)) return high;
	std::optional<Vec3> low = constrained(start);
	if (!low) return {};
	const Vec3 fallbacks[] = {m_middle, m_mesh.positions[m_u], m_mesh.positions[m_w]};
	for (std::size_t i = 0; !accepts(*low); ++i)
	{
		if (i == 3) return {};
		const auto other = constrained(fallbacks[i]);
		if (other) low = other;
	}
	if (!high) return low;
	Vec3 far = *high;
	for (int i = 0; i < kBisections; ++i)
	{
		const Vec3 middle = roundedToFloat(0.5 * (*low + far));
		(accepts(middle) ? *low : far) = middle;
	}
	return low;
}

std::optional<Vec3> Collapser::searchPlain(const Vec3& start)
{
	const Vec3 wanted[] = {start, m_middle, m_mesh.positions[m_u], m_mesh.positions[m_w]};
	for (const Vec3& target : wanted)
	{
		const auto x = constrained(target);
		m_outOfBound = false;
		if (x && accepts(*x)) return x;
		if (m_outOfBound) return {};
	}
	return {};
}

Outcome Collapser::attempt(std::uint32_t u, std::uint32_t w)
{
	m_outOfBound = false;
	if (!findStar(u, w) || !findRing() || !findPatches()) return Outcome::Blocked;
	m_middle = 0.5 * (m_mesh.positions[u] + m_mesh.positions[w]);
	m_ringRadius = 0;
	for (const std::uint32_t v : m_ring) m_ringRadius = std::max(m_ringRadius, length(m_mesh.positions[v] - m_middle));
	findRows();
	const Vec3 start = joinedQuadric(u, w).minimiser(m_middle);
	m_validity.move.u = u;
	m_validity.move.w = w;
	m_validity.move.faces = m_star;
	auto position = m_config.paper ? searchPaper(start) : searchPlain(start);
	// A bisection may have tried another position last: the hulls and samples kept must be those of the result.
	if (position && m_config.paper && !(m_validity.move.position == *position) && !accepts(*position)) position = {};
	m_validity.move = Move{};
	if (!position) return m_outOfBound ? Outcome::OutOfBound : Outcome::Blocked;
	commit(*position);
	return Outcome::Done;
}

bool Collapser::accepts(const Vec3& position)
{
	m_validity.move.position = position;
	m_starPoints.clear();
	m_validity.move.planes.clear();
	for (const std::uint32_t f : m_star)
	{
		m_starPoints.push_back(m_validity.points(f));
		const TrianglePoints& t = m_starPoints.back();
		m_validity.move.planes.push_back(planeOf(t[0], t[1], t[2]));
	}
	if (!facesAreSound()) return false;
	for (const std::uint32_t patch : m_patches)
		if (!m_validity.keepsConvex(patch)) return false;
	if (!m_guard.surfaceIsNear(position, m_starPoints) || !m_guard.inputIsNear(m_oldFaces, m_star, m_starPoints))
	{
		m_outOfBound = true;
		return false;
	}
	if (!staysOutOfOtherHulls()) return false;
	m_newHulls.clear();
	m_leaning.clear();
	m_supports.clear();
	for (const std::uint32_t patch : m_patches)
	{
		if (!m_validity.keepsInside(patch)) return false;
		m_newHulls.push_back(m_validity.hull());
		m_leaning.push_back(patch);
		m_supports.push_back(m_validity.supports());
	}
	return doesNotCross() && keepsOthersCovered();
}

bool Collapser::facesAreSound()
{
	for (std::size_t i = 0; i < m_star.size(); ++i)
	{
		if (dot(m_validity.move.planes[i].normal, m_mesh.planes[m_star[i]].normal) < kLeastTurn) return false;
		const double thinness = heightOverLength(m_starPoints[i]);
		if (thinness < kThinnest && thinness < heightOverLength(m_mesh.points(m_star[i]))) return false;
	}
	return true;
}

bool Collapser::staysOutOfOtherHulls() const
{
	for (const TrianglePoints& t : m_starPoints)
	{
		const bool outside = m_mesh.patchTree.search(
			boxOf(t),
			[&](std::uint32_t patch)
			{
				const auto& hull = m_mesh.patches[patch].hull;
				if (hull.empty() || std::find(m_patches.begin(), m_patches.end(), patch) != m_patches.end())
					return true;
				return !entersHull(t, hull, 4 * m_validity.tolerance);
			});
		if (!outside) return false;
	}
	return true;
}

// Faces that move away may have covered the front of a patch that is not theirs.
bool Collapser::keepsOthersCovered()
{
	for (const std::uint32_t f : m_oldFaces)
		for (const std::uint32_t patch : m_mesh.leaning[f])
		{
			const bool isKnown = std::find(m_leaning.begin(), m_leaning.end(), patch) != m_leaning.end();
			const bool isGone = m_mesh.patches[patch].faces.empty() ||
								std::find(m_vanishing.begin(), m_vanishing.end(), patch) != m_vanishing.end();
			if (isKnown || isGone) continue;
			if (!m_validity.keepsCovered(patch)) return false;
			m_leaning.push_back(patch);
			m_supports.push_back(m_validity.supports());
		}
	return true;
}

// Walls thinner than the hulls behind them are flat patches, which the hull tests cannot see: no moved face may cross
// another face of the surface.
bool Collapser::doesNotCross() const
{
	for (std::size_t i = 0; i < m_star.size(); ++i)
	{
		const std::array<std::uint32_t, 3> own = {m_u, m_ring[i], m_ring[(i + 1) % m_ring.size()]};
		const bool free = m_mesh.faceTree.search(
			boxOf(m_starPoints[i]),
			[&](std::uint32_t face)
			{
				const auto& f = m_mesh.faces[face];
				const bool inStar = m_mesh.cornerOf(face, m_u) >= 0 || m_mesh.cornerOf(face, m_w) >= 0;
				return inStar || sharesVertex(own, f) || !trianglesCross(m_starPoints[i], m_mesh.points(face));
			});
		if (!free) return false;
	}
	return true;
}
}  // namespace clod::builder
