// SPDX-License-Identifier: Zlib
// Collision shapes that users of Bullet make of a mesh: triangles for GImpact or a static tree, a convex hull, a
// compound of hulls; and Bullet's own solids in its place.
// Compiled once per Bullet precision. Lengths are the meshes' unit; vertices are moved by -origin, then scaled.
#pragma once
#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "demos/models/Models.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
// Indexed triangles as Bullet's mesh shapes read them; outlives the shapes.
class BulletMesh
{
public:
	BulletMesh(const ModelMesh& mesh, const Vec3& origin, double scale);
	btStridingMeshInterface* interface() const { return m_array.get(); }
	std::size_t bytes() const { return m_indices.size() * sizeof(int) + m_vertices.size() * sizeof(btScalar); }

private:
	std::vector<int> m_indices;
	std::vector<btScalar> m_vertices;
	std::unique_ptr<btTriangleIndexVertexArray> m_array;
};

// The vertices are one btConvexHullShape.
std::unique_ptr<btConvexHullShape> convexHull(const ModelMesh& mesh, const Vec3& origin, double scale, double margin);

// A shape of any kind but clod, with all that it points at; of clod none.
class PlainShape
{
public:
	PlainShape(const SceneShape& shape, const Vec3& origin, double scale);
	PlainShape(PlainShape&&) noexcept;
	~PlainShape();
	btCollisionShape& shape() const { return *m_shape; }

private:
	std::unique_ptr<BulletMesh> m_mesh;
	std::vector<std::unique_ptr<btConvexHullShape>> m_hulls;
	std::unique_ptr<btCollisionShape> m_shape;
};
}  // namespace clod::demo
