// SPDX-License-Identifier: GPL-3.0-or-later
// The patches of a level nearest to points of the input surface.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "builder/Lod.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
struct Lookup
{
	std::uint32_t patch;
	double distance;
};
using Lookups = std::array<Lookup, 4>;  // of a triangle's corners and its centroid

class NearestPatches
{
public:
	NearestPatches(const Lod& lod) : m_lod(lod), m_tree(lod.mesh), m_firstFace(lod.patchCount + 1, 0)
	{
		for (std::uint32_t i = 0; i < lod.mesh.triangles.size(); ++i)
		{
			m_normals.push_back(areaVector(m_tree.triangle(i)));
			++m_firstFace[lod.patchOfTriangle[i] + 1];
		}
		std::partial_sum(m_firstFace.begin(), m_firstFace.end(), m_firstFace.begin());
		m_faces.resize(lod.mesh.triangles.size());
		std::vector<std::uint32_t> next(m_firstFace.begin(), m_firstFace.end() - 1);
		for (std::uint32_t i = 0; i < lod.mesh.triangles.size(); ++i)
		{
			m_faces[next[lod.patchOfTriangle[i]]++] = {ballRound(m_tree.triangle(i)), i};
		}
	}

	// Faces turned away count only where the nearest turned the same way is more than twice as far.
	Lookup at(const Vec3& p, const Vec3& normal) const { return at(p, normal, m_tree.nearest(p)); }
	Lookup at(const Vec3& p, const Vec3& normal, const TriangleTree::Nearest& any) const
	{
		const double distance = std::sqrt(any.distanceSquared);
		if (dot(m_normals[any.triangle], normal) > 0) return {m_lod.patchOfTriangle[any.triangle], distance};
		const auto same = [&](std::uint32_t i) { return dot(m_normals[i], normal) > 0; };
		const TriangleTree::Nearest facing = m_tree.nearest(p, same, 4 * any.distanceSquared * (1 + 1e-9) + 1e-300);
		if (facing.triangle == kNone) return {m_lod.patchOfTriangle[any.triangle], distance};
		return {m_lod.patchOfTriangle[facing.triangle], std::sqrt(facing.distanceSquared)};
	}

	// Of every corner and centroid of a mesh's faces. A vertex is looked up once for all faces round it.
	std::vector<Lookups> ofFaces(const Mesh& mesh, const TriangleTree& faces, const ThreadLimit& threads) const
	{
		std::vector<TriangleTree::Nearest> ofVertex(mesh.vertices.size());
		parallelFor(ofVertex.size(), threads, [&](std::size_t v) { ofVertex[v] = m_tree.nearest(mesh.vertices[v]); });
		std::vector<Lookups> result(faces.size());
		parallelFor(faces.size(), threads,
					[&](std::size_t i)
					{
						const Triangle& t = faces.triangle(std::uint32_t(i));
						const Vec3 normal = areaVector(t);
						for (std::size_t k = 0; k < 3; ++k)
							result[i][k] = at(t[int(k)], normal, ofVertex[mesh.triangles[i][k]]);
						result[i][3] = at(centroid(t), normal);
					});
		return result;
	}

	// infinity where it is more than the limit. Most faces are passed over for the ball round them.
	double distanceTo(std::uint32_t patch, const Vec3& p, double limit) const
	{
		double best = std::numeric_limits<double>::infinity(), within = limit;
		for (std::uint32_t k = m_firstFace[patch]; k < m_firstFace[patch + 1]; ++k)
		{
			if (m_faces[k].ball.isBeyond(p, within)) continue;
			const double here = distanceSquared(p, m_tree.triangle(m_faces[k].index));
			if (here >= best) continue;
			best = here;
			within = std::min(limit, std::sqrt(best) * (1 + 1e-9));
		}
		return std::sqrt(best) <= limit ? std::sqrt(best) : std::numeric_limits<double>::infinity();
	}

	Vec3 middleOf(std::uint32_t patch, Vec3& normal) const
	{
		Vec3 sum;
		double area = 0;
		for (std::uint32_t k = m_firstFace[patch]; k < m_firstFace[patch + 1]; ++k)
		{
			const Vec3& here = m_normals[m_faces[k].index];
			sum += length(here) * m_faces[k].ball.middle;
			normal += here;
			area += length(here);
		}
		return area > 0 ? (1 / area) * sum : m_faces[m_firstFace[patch]].ball.middle;
	}

private:
	struct Face
	{
		Ball ball;
		std::uint32_t index;
	};

	const Lod& m_lod;
	TriangleTree m_tree;
	std::vector<std::uint32_t> m_firstFace;  // per patch into m_faces, and the end
	std::vector<Face> m_faces;
	std::vector<Vec3> m_normals;  // by index of the face
};
}  // namespace clod::builder
