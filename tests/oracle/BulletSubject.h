// SPDX-License-Identifier: GPL-3.0-or-later
// What Bullet gets of a pair: two rigid bodies in a world without gravity, A with the motion asked for and B at rest,
// one dispatch of pairs made anew, the manifolds read back.
#pragma once
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>

#include "clod/bullet/btClodShape.h"
#include "tests/oracle/Subject.h"

namespace clod::oracle
{
// Every contact level of a hierarchy as a mesh, vertices of the same place made one.
std::vector<TriangleMesh> levelSurfaces(const Hierarchy& hierarchy);

class BulletSubject : public Subject
{
public:
	const std::vector<TriangleMesh>& surfacesA() const override { return m_surfaces[0]; }
	const std::vector<TriangleMesh>& surfacesB() const override { return m_surfaces[1]; }
	Answer answer(const Transform& aFromB, const RelativeMotion& motion) override;
	double skin() const override { return m_skin; }

protected:
	// raise: what has to be added to distances of manifolds to give those of the surfaces.
	BulletSubject(std::vector<TriangleMesh> a, std::vector<TriangleMesh> b, double skin, double raise);
	void setShapes(std::unique_ptr<btCollisionShape> a, std::unique_ptr<btCollisionShape> b);
	btCollisionDispatcher& dispatcher() { return m_dispatcher; }
	const btRigidBody& body(std::size_t i) const { return *m_bodies[i]; }
	virtual void findSurfaces(Answer&) const {}

private:
	std::vector<TriangleMesh> m_surfaces[2];
	double m_skin, m_raise;
	btDefaultCollisionConfiguration m_configuration;
	btCollisionDispatcher m_dispatcher{&m_configuration};
	btDbvtBroadphase m_broadphase;
	btCollisionWorld m_world{&m_dispatcher, &m_broadphase, &m_configuration};
	std::unique_ptr<btCollisionShape> m_shapes[2];
	std::unique_ptr<btRigidBody> m_bodies[2];
};

using HierarchyPointer = std::shared_ptr<const Hierarchy>;
std::unique_ptr<Subject> clodSubject(const HierarchyPointer& a, const HierarchyPointer& b, const ContactMetric& metric);
// Those of others are judged by our skin.
std::unique_ptr<Subject> gimpactSubject(const TriangleMesh& a, const TriangleMesh& b);
// Bullet's own boxes.
std::unique_ptr<Subject> boxSubject(const Vec3& halfOfA, const Vec3& halfOfB);
}  // namespace clod::oracle
