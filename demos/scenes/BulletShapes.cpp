// SPDX-License-Identifier: Zlib
#include "demos/scenes/BulletShapes.h"

#include <BulletCollision/Gimpact/btGImpactShape.h>

#include "demos/scenes/BulletPose.h"

namespace clod::demo
{
BulletMesh::BulletMesh(const ModelMesh& mesh, const Vec3& origin, double scale)
{
	for (const auto& triangle : mesh.triangles)
		for (const std::uint32_t index : triangle) m_indices.push_back(int(index));
	for (const Vec3& vertex : mesh.vertices)
	{
		const Vec3 v = scale * (vertex - origin);
		for (const double x : {v.x, v.y, v.z}) m_vertices.push_back(btScalar(x));
	}
	m_array.reset(new btTriangleIndexVertexArray(int(mesh.triangles.size()), m_indices.data(), 3 * int(sizeof(int)),
												 int(mesh.vertices.size()), m_vertices.data(),
												 3 * int(sizeof(btScalar))));
}

std::unique_ptr<btConvexHullShape> convexHull(const ModelMesh& mesh, const Vec3& origin, double scale, double margin)
{
	auto hull = std::make_unique<btConvexHullShape>();
	for (const Vec3& vertex : mesh.vertices) hull->addPoint(toBullet(vertex - origin, scale), false);
	hull->recalcLocalAabb();
	hull->setMargin(btScalar(scale * margin));
	return hull;
}

namespace
{
std::unique_ptr<btCollisionShape> solidOf(const SceneShape& shape, double scale)
{
	const btVector3 half = toBullet(shape.halfExtents, scale);
	if (shape.kind == SceneShape::Kind::box) return std::make_unique<btBoxShape>(half);
	if (shape.kind == SceneShape::Kind::sphere) return std::make_unique<btSphereShape>(half.x());
	if (shape.kind == SceneShape::Kind::capsule) return std::make_unique<btCapsuleShape>(half.x(), 2 * half.y());
	return std::make_unique<btCylinderShape>(half);
}
}  // namespace

PlainShape::PlainShape(const SceneShape& shape, const Vec3& origin, double scale)
{
	using Kind = SceneShape::Kind;
	if (shape.kind == Kind::clod) return;
	if (shape.kind != Kind::hulls && shape.kind != Kind::gimpact && shape.kind != Kind::bvh)
	{
		m_shape = solidOf(shape, scale);
		return;
	}
	if (shape.kind == Kind::bvh)
	{
		m_mesh = std::make_unique<BulletMesh>(shape.meshes.front(), origin, scale);
		m_shape = std::make_unique<btBvhTriangleMeshShape>(m_mesh->interface(), true);
		m_shape->setMargin(btScalar(scale * shape.margin));
		return;
	}
	if (shape.kind == Kind::gimpact)
	{
		m_mesh = std::make_unique<BulletMesh>(shape.meshes.front(), origin, scale);
		auto gimpact = std::make_unique<btGImpactMeshShape>(m_mesh->interface());
		gimpact->setMargin(btScalar(scale * shape.margin));
		gimpact->updateBound();
		m_shape = std::move(gimpact);
		return;
	}
	for (const ModelMesh& mesh : shape.meshes) m_hulls.push_back(convexHull(mesh, origin, scale, shape.margin));
	if (m_hulls.size() == 1)
	{
		m_shape = std::move(m_hulls.front());
		m_hulls.clear();
		return;
	}
	auto compound = std::make_unique<btCompoundShape>(true, int(m_hulls.size()));
	for (const auto& hull : m_hulls) compound->addChildShape(btTransform::getIdentity(), hull.get());
	m_shape = std::move(compound);
}

PlainShape::PlainShape(PlainShape&&) noexcept = default;
PlainShape::~PlainShape()
{
	m_shape.reset();  // before what it points at
}
}  // namespace clod::demo
