// SPDX-License-Identifier: GPL-3.0-or-later
// The patches of a level nearest to points of the input surface.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
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
	NearestPatches(const Lod& lod) : m_lod(lod), m_tree(lod.mesh), m_faces(lod.patchCount)
	{
		for (std::uint32_t i = 0; i < lod.mesh.triangles.size(); ++i)
		{
			const Triangle& t = m_tree.triangle(i);
			const Vec3 middle = centroid(t);
			const double radius = std::max({length(t.a - middle), length(t.b - middle), length(t.c - middle)});
			m_balls.push_back({middle, radius * (1 + 1e-9)});
			m_normals.push_back(areaVector(t));
			m_faces[lod.patchOfTriangle[i]].push_back(i);
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
	std::vector<Lookups> ofFaces(const Mesh& mesh, const TriangleTree& faces, unsigned threads) const
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

	// Most faces are passed over for the ball round them.
	double distanceTo(std::uint32_t patch, const Vec3& p) const
	{
		double best = std::numeric_limits<double>::infinity(), reach = best;
		for (std::uint32_t i : m_faces[patch])
		{
			const double most = reach + m_balls[i].radius;
			if (lengthSquared(p - m_balls[i].middle) > most * most) continue;
			const double here = distanceSquared(p, m_tree.triangle(i));
			if (here >= best) continue;
			best = here;
			reach = std::sqrt(best) * (1 + 1e-9);
		}
		return std::sqrt(best);
	}

	Vec3 middleOf(std::uint32_t patch, Vec3& normal) const
	{
		Vec3 sum;
		double area = 0;
		for (std::uint32_t i : m_faces[patch])
		{
			const double a = length(m_normals[i]);
			sum += a * centroid(m_tree.triangle(i));
			normal += m_normals[i];
			area += a;
		}
		return area > 0 ? (1 / area) * sum : centroid(m_tree.triangle(m_faces[patch][0]));
	}

private:
	struct Ball
	{
		Vec3 middle;
		double radius;
	};

	const Lod& m_lod;
	TriangleTree m_tree;
	std::vector<std::vector<std::uint32_t>> m_faces;
	std::vector<Vec3> m_normals;
	std::vector<Ball> m_balls;  // round each face
};
}  // namespace clod::builder
