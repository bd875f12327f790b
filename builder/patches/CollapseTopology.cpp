// SPDX-License-Identifier: GPL-3.0-or-later
// Step 1 of the collapse, the topology, and the bookkeeping after an accepted one.
#include <algorithm>

#include "builder/patches/Collapse.h"

namespace clod::builder
{
// Link condition: the endpoints share exactly the two vertices opposite to the edge, and those keep three faces.
bool Collapser::findStar(std::uint32_t u, std::uint32_t w)
{
	m_u = u;
	m_w = w;
	m_star.clear();
	m_oldFaces.clear();
	std::size_t removed = 0;
	for (const std::uint32_t f : m_mesh.star[u])
	{
		m_oldFaces.push_back(f);
		if (m_mesh.cornerOf(f, w) < 0)
		{
			m_star.push_back(f);
			continue;
		}
		if (removed == 2) return false;
		m_removed[removed] = f;
		for (const std::uint32_t v : m_mesh.faces[f])
			if (v != u && v != w) m_opposite[removed] = v;
		++removed;
	}
	if (removed != 2 || m_opposite[0] == m_opposite[1]) return false;
	for (const std::uint32_t f : m_mesh.star[w])
		if (m_mesh.cornerOf(f, u) < 0)
		{
			m_star.push_back(f);
			m_oldFaces.push_back(f);
		}
	for (const std::uint32_t o : m_opposite)
		if (m_mesh.star[o].size() <= 3) return false;
	return m_star.size() >= 3;
}

// Linear in the number of faces: the hub of a fan has thousands, and is tried along each of them.
bool Collapser::findRing()
{
	const std::size_t n = m_star.size();
	const auto farEdge = [&](std::uint32_t f)
	{
		int corner = m_mesh.cornerOf(f, m_u);
		if (corner < 0) corner = m_mesh.cornerOf(f, m_w);
		const auto& t = m_mesh.faces[f];
		return std::array<std::uint32_t, 2>{t[std::size_t((corner + 1) % 3)], t[std::size_t((corner + 2) % 3)]};
	};
	bool isFan = true;
	for (const std::uint32_t f : m_star)
	{
		std::uint32_t& from = m_faceFrom[farEdge(f)[0]];
		isFan = isFan && from == kNone;
		from = f;
	}
	m_ring.clear();
	m_scratch.clear();
	std::uint32_t face = m_star[0];
	for (std::size_t i = 0; i < n && isFan; ++i)
	{
		const auto edge = farEdge(face);
		m_ring.push_back(edge[0]);
		m_scratch.push_back(face);
		face = m_faceFrom[edge[1]];
		isFan = face != kNone && (face == m_star[0]) == (i + 1 == n);
	}
	for (const std::uint32_t f : m_star) m_faceFrom[farEdge(f)[0]] = kNone;
	if (isFan) m_star.swap(m_scratch);
	return isFan;
}

bool Collapser::findPatches()
{
	m_patches.clear();
	m_vanishing.clear();
	std::uint32_t before = m_mesh.label[m_star.back()];
	for (const std::uint32_t f : m_star)
	{
		const std::uint32_t patch = m_mesh.label[f];
		if (m_runs[patch] == kNone)
		{
			m_runs[patch] = 0;
			m_patches.push_back(patch);
		}
		if (patch != before) ++m_runs[patch];
		before = patch;
	}
	for (const std::uint32_t f : m_removed)
	{
		const std::uint32_t patch = m_mesh.label[f];
		const bool known = std::find(m_vanishing.begin(), m_vanishing.end(), patch) != m_vanishing.end();
		if (m_runs[patch] == kNone && !known) m_vanishing.push_back(patch);
	}
	const bool connected = std::all_of(m_patches.begin(), m_patches.end(),
									   [&](std::uint32_t p) { return m_runs[p] <= 1 || staysConnected(p); });
	for (const std::uint32_t patch : m_patches) m_runs[patch] = kNone;
	return connected;
}

// Of a patch with several runs of faces round the new vertex; one run cannot have been cut.
bool Collapser::staysConnected(std::uint32_t patch) const
{
	const auto& faces = m_mesh.patches[patch].faces;
	const auto isRemoved = [&](std::uint32_t f) { return f == m_removed[0] || f == m_removed[1]; };
	std::vector<std::uint32_t> left;
	for (const std::uint32_t f : faces)
		if (!isRemoved(f)) left.push_back(f);
	std::vector<std::uint32_t> queue = {left.back()};
	left.pop_back();
	const auto reach = [&](std::uint32_t f)
	{
		const auto at = std::find(left.begin(), left.end(), f);
		if (at == left.end()) return;
		*at = left.back();
		left.pop_back();
		queue.push_back(f);
	};
	while (!queue.empty() && !left.empty())
	{
		const std::uint32_t f = queue.back();
		queue.pop_back();
		for (const std::uint32_t next : m_mesh.adjacent[f])
		{
			if (!isRemoved(next))
			{
				reach(next);
				continue;
			}
			for (const std::uint32_t beyond : m_mesh.adjacent[next])
				if (!isRemoved(beyond)) reach(beyond);
		}
	}
	return left.empty();
}

// The two faces beside a removed face become neighbours.
void Collapser::relink(std::uint32_t removed)
{
	std::array<std::uint32_t, 2> beside{};
	std::size_t count = 0;
	for (int k = 0; k < 3; ++k)
	{
		const std::uint32_t a = m_mesh.faces[removed][std::size_t(k)];
		const std::uint32_t b = m_mesh.faces[removed][std::size_t((k + 1) % 3)];
		const bool isEdge = (a == m_u && b == m_w) || (a == m_w && b == m_u);
		if (!isEdge) beside[count++] = m_mesh.adjacent[removed][std::size_t(k)];
	}
	for (std::size_t i = 0; i < 2; ++i)
		m_mesh.adjacent[beside[i]][std::size_t(m_mesh.edgeTo(beside[i], removed))] = beside[1 - i];
}

void Collapser::commit(const Vec3& position)
{
	m_guard.commit(m_oldFaces);
	const double r = resolution(m_u, m_w);
	for (const std::uint32_t patch : m_vanishing) vanish(patch);
	for (const std::uint32_t f : m_removed)
	{
		relink(f);
		for (const std::uint32_t v : m_opposite)
		{
			auto& star = m_mesh.star[v];
			star.erase(std::remove(star.begin(), star.end(), f), star.end());
		}
		auto& faces = m_mesh.patches[m_mesh.label[f]].faces;
		faces.erase(std::remove(faces.begin(), faces.end(), f), faces.end());
		m_mesh.faces[f][0] = kNone;
		m_mesh.faceTree.update(f, Box{});
	}
	m_mesh.faceCount -= 2;
	m_mesh.positions[m_u] = position;
	m_quadrics[m_u] += m_quadrics[m_w];
	for (const std::uint32_t f : m_star)
	{
		const int corner = m_mesh.cornerOf(f, m_w);
		if (corner >= 0) m_mesh.faces[f][std::size_t(corner)] = m_u;
		m_mesh.refreshFace(f);
	}
	m_mesh.star[m_u] = m_star;
	m_mesh.star[m_w].clear();
	for (std::size_t i = 0; i < m_leaning.size(); ++i) m_mesh.lean(m_leaning[i], m_supports[i]);
	for (std::size_t i = 0; i < m_patches.size(); ++i)
	{
		Patch& patch = m_mesh.patches[m_patches[i]];
		patch.resolution = smallerResolution(patch.resolution, r);
		m_mesh.setHull(m_patches[i], std::move(m_newHulls[i]));
	}
}

// Neighbour of a vanishing patch whose face lies nearest to the middle of the collapsed edge's far side.
std::uint32_t Collapser::heirOf(std::uint32_t patch) const
{
	std::uint32_t heir = kNone;
	double nearest = 1e300;
	for (const std::uint32_t f : m_removed)
	{
		if (m_mesh.label[f] != patch) continue;
		const TrianglePoints t = m_mesh.points(f);
		const Vec3 centre = (1.0 / 3) * (t[0] + t[1] + t[2]);
		for (std::size_t i = 0; i < m_star.size(); ++i)
		{
			const double d = squaredDistance(centre, m_starPoints[i]);
			if (d >= nearest) continue;
			nearest = d;
			heir = m_mesh.label[m_star[i]];
		}
	}
	return heir;
}

void Collapser::vanish(std::uint32_t patch)
{
	Patch& lost = m_mesh.patches[patch];
	Patch& heir = m_mesh.patches[heirOf(patch)];
	heir.kids.insert(heir.kids.end(), lost.kids.begin(), lost.kids.end());
	heir.resolution = smallerResolution(heir.resolution, lost.resolution);
	lost.kids.clear();
	lost.hull.clear();
	m_mesh.patchTree.update(patch, Box{});
	lost.box = {};
	--m_mesh.patchCount;
}
}  // namespace clod::builder
