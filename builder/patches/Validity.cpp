// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see Validity.h.
#include "builder/patches/Validity.h"

#include <algorithm>
#include <utility>

namespace clod::builder
{
Validity::Validity(const PatchMesh& mesh)
	: m_mesh(mesh), m_faceStamp(mesh.faces.size(), 0), m_vertexStamp(mesh.positions.size(), 0)
{
}

void Validity::clear()
{
	++m_stamp;
	m_faces.clear();
	m_facePoints.clear();
	m_facePlanes.clear();
	m_points.clear();
	m_box = {};
	m_hull.clear();
}

bool Validity::isMoved(std::uint32_t face) const
{
	const auto& f = m_mesh.faces[face];
	return move.moves(f[0]) || move.moves(f[1]) || move.moves(f[2]);
}

bool Validity::vanishes(std::uint32_t face) const
{
	return move.u != kNone && m_mesh.cornerOf(face, move.u) >= 0 && m_mesh.cornerOf(face, move.w) >= 0;
}

TrianglePoints Validity::points(std::uint32_t face) const
{
	TrianglePoints t = m_mesh.points(face);
	for (std::size_t k = 0; k < 3; ++k)
		if (move.moves(m_mesh.faces[face][k])) t[k] = move.position;
	return t;
}

void Validity::addPoint(std::uint32_t vertex)
{
	if (vertex == move.w) vertex = move.u;
	if (m_vertexStamp[vertex] == m_stamp) return;
	m_vertexStamp[vertex] = m_stamp;
	m_points.push_back(vertex == move.u ? move.position : m_mesh.positions[vertex]);
	m_box.include(m_points.back());
}

void Validity::addFace(std::uint32_t face)
{
	m_faceStamp[face] = m_stamp;
	m_faces.push_back(face);
	m_facePoints.push_back(points(face));
	if (isMoved(face))
	{
		const TrianglePoints& t = m_facePoints.back();
		m_facePlanes.push_back(planeOf(t[0], t[1], t[2]));
	}
	else
		m_facePlanes.push_back(m_mesh.planes[face]);
	for (const std::uint32_t v : m_mesh.faces[face]) addPoint(v);
}

void Validity::load(const std::vector<std::uint32_t>& faces)
{
	clear();
	for (const std::uint32_t f : faces)
		if (!vanishes(f)) addFace(f);
}

// Across the edge k after the move: the far side of a vanishing face takes its place.
std::uint32_t Validity::neighbour(std::uint32_t face, int k) const
{
	const std::uint32_t next = m_mesh.adjacent[face][std::size_t(k)];
	if (!vanishes(next)) return next;
	for (int j = 0; j < 3; ++j)
	{
		const std::uint32_t other = m_mesh.adjacent[next][std::size_t(j)];
		if (other != face && !vanishes(other)) return other;
	}
	return kNone;
}

bool Validity::growsConvex(std::uint32_t face) const
{
	const Plane& plane = m_mesh.planes[face];
	for (const Vec3& p : m_points)
		if (plane.height(p) > 2 * tolerance) return false;
	for (int k = 0; k < 3; ++k)
		if (contains(m_mesh.adjacent[face][std::size_t(k)]) && m_mesh.edgeHeight(face, k) > tolerance) return false;
	for (const std::uint32_t v : m_mesh.faces[face])
	{
		if (m_vertexStamp[v] == m_stamp) continue;
		for (const Plane& p : m_facePlanes)
			if (p.height(m_mesh.positions[v]) > 2 * tolerance) return false;
	}
	return true;
}

bool Validity::grow(std::uint32_t face)
{
	if (!growsConvex(face)) return false;
	m_trial = m_hull;
	const std::size_t faceTotal = m_faces.size(), pointTotal = m_points.size();
	const Box box = m_box;
	addFace(face);
	for (std::size_t i = pointTotal; i < m_points.size(); ++i) m_trial.add(m_points[i]);
	const bool sameHull = pointTotal == m_points.size();
	if (faceTotal == 0 || ((sameHull || isInside(m_trial)) && isCovered()))
	{
		std::swap(m_hull, m_trial);
		return true;
	}
	m_faceStamp[face] = 0;
	for (const std::uint32_t v : m_mesh.faces[face])
	{
		bool isNew = true;
		for (std::size_t i = 0; i < faceTotal && isNew; ++i) isNew = m_mesh.cornerOf(m_faces[i], v) < 0;
		if (isNew) m_vertexStamp[v] = 0;
	}
	m_faces.resize(faceTotal);
	m_facePoints.resize(faceTotal);
	m_facePlanes.resize(faceTotal);
	m_points.resize(pointTotal);
	m_box = box;
	return false;
}

std::vector<Plane> Validity::grownHull() const
{
	std::vector<Plane> planes;
	m_hull.planes(minimumHeight(), planes);
	return planes;
}

bool Validity::canJoin(std::uint32_t a, std::uint32_t b)
{
	const auto& fa = m_mesh.patches[a].faces;
	const auto& fb = m_mesh.patches[b].faces;
	const auto& smaller = fa.size() <= fb.size() ? fa : fb;
	const std::uint32_t other = fa.size() <= fb.size() ? b : a;
	for (const std::uint32_t f : smaller)
		for (int k = 0; k < 3; ++k)
			if (m_mesh.label[m_mesh.adjacent[f][std::size_t(k)]] == other && m_mesh.edgeHeight(f, k) > tolerance)
				return false;
	load(fa);
	for (const std::uint32_t f : fb) addFace(f);
	if (!isBelowAllPlanes()) return false;
	m_hull.clear();
	for (const Vec3& p : m_points) m_hull.add(p);
	return isInside(m_hull) && isCovered();
}

bool Validity::isBelowAllPlanes() const
{
	for (const Plane& plane : m_facePlanes)
		for (const Vec3& p : m_points)
			if (plane.height(p) > 2 * tolerance) return false;
	return true;
}

bool Validity::edgesStayConvex(std::uint32_t patch) const
{
	for (std::size_t i = 0; i < move.faces.size(); ++i)
	{
		const std::uint32_t face = move.faces[i];
		if (m_mesh.label[face] != patch) continue;
		const TrianglePoints own = points(face);
		for (int k = 0; k < 3; ++k)
		{
			const std::uint32_t other = neighbour(face, k);
			if (other == kNone || m_mesh.label[other] != patch) continue;
			const TrianglePoints t = points(other);
			const Plane plane = isMoved(other) ? planeOf(t[0], t[1], t[2]) : m_mesh.planes[other];
			for (int j = 0; j < 3; ++j)
				if (move.planes[i].height(t[std::size_t(j)]) > tolerance ||
					plane.height(own[std::size_t(j)]) > tolerance)
					return false;
		}
	}
	return true;
}

bool Validity::keepsConvex(std::uint32_t patch)
{
	if (!edgesStayConvex(patch)) return false;
	load(m_mesh.patches[patch].faces);
	for (std::size_t i = 0; i < m_faces.size(); ++i)
	{
		if (m_facePlanes[i].height(move.position) > 2 * tolerance) return false;
		if (!isMoved(m_faces[i])) continue;
		for (const Vec3& p : m_points)
			if (m_facePlanes[i].height(p) > 2 * tolerance) return false;
	}
	return true;
}

bool Validity::keepsInside(std::uint32_t patch)
{
	load(m_mesh.patches[patch].faces);
	m_hull.clear();
	for (const Vec3& p : m_points) m_hull.add(p);
	return isInside(m_hull) && isCovered();
}

bool Validity::keepsCovered(std::uint32_t patch)
{
	load(m_mesh.patches[patch].faces);
	return isCovered();
}

bool Validity::isConnected() const
{
	if (m_faces.empty()) return false;
	std::vector<std::uint32_t> queue = {m_faces[0]}, seen = {m_faces[0]};
	for (std::size_t i = 0; i < queue.size(); ++i)
		for (int k = 0; k < 3; ++k)
		{
			const std::uint32_t next = neighbour(queue[i], k);
			if (next == kNone || !contains(next)) continue;
			const auto at = std::lower_bound(seen.begin(), seen.end(), next);
			if (at != seen.end() && *at == next) continue;
			seen.insert(at, next);
			queue.push_back(next);
		}
	return queue.size() == m_faces.size();
}

bool Validity::isValid(const std::vector<std::uint32_t>& faces)
{
	load(faces);
	for (const std::uint32_t f : faces)
		for (int k = 0; k < 3; ++k)
			if (contains(m_mesh.adjacent[f][std::size_t(k)]) && m_mesh.edgeHeight(f, k) > tolerance) return false;
	if (!isConnected() || !isBelowAllPlanes()) return false;
	m_hull.clear();
	for (const Vec3& p : m_points) m_hull.add(p);
	return isInside(m_hull) && isCovered();
}

bool Validity::isInside(const SmallHull& hull)
{
	hull.planes(minimumHeight(), m_hullPlanes);
	if (m_hullPlanes.empty()) return true;
	return searchForeign(m_box, [&](std::uint32_t, const TrianglePoints& t)
						 { return !entersHull(t, m_hullPlanes, kDepth * tolerance); });
}
}  // namespace clod::builder
