// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/BulletSubject.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <tuple>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/distance/SignedGap.h"
#include "clod/manifold/ContactPoints.h"
#include "tests/oracle/Meshes.h"

namespace clod::oracle
{
namespace
{
constexpr double kGImpactMargin = 0.0025;  // of each body, share of the smaller radius: how far GImpact looks ahead

btTransform toBullet(const Transform& t)
{
	const Vec3* row = t.rotation.row;
	const btMatrix3x3 basis(btScalar(row[0].x), btScalar(row[0].y), btScalar(row[0].z), btScalar(row[1].x),
							btScalar(row[1].y), btScalar(row[1].z), btScalar(row[2].x), btScalar(row[2].y),
							btScalar(row[2].z));
	return btTransform(basis, toBullet(t.translation));
}

double radiusOf(const TriangleMesh& mesh)
{
	double radius = 0;
	for (const Vec3& v : mesh.vertices) radius = std::max(radius, length(v));
	return radius;
}

double smallerRadius(const TriangleMesh& a, const TriangleMesh& b)
{
	return std::min(radiusOf(a), radiusOf(b));
}

std::vector<TriangleMesh> surfacesInUse(const Hierarchy& hierarchy, const ContactMetric& metric)
{
	std::vector<TriangleMesh> surfaces = levelSurfaces(hierarchy);
	if (metric.exact) surfaces.resize(1);
	return surfaces;
}

class ClodSubject : public BulletSubject
{
public:
	ClodSubject(const HierarchyPointer& a, const HierarchyPointer& b, const ContactMetric& metric)
		: ClodSubject(a, b, metric, kSkinShare * std::min(double(a->asset().radius), double(b->asset().radius)))
	{
	}

private:
	ClodSubject(const HierarchyPointer& a, const HierarchyPointer& b, const ContactMetric& metric, double skin)
		: BulletSubject(surfacesInUse(*a, metric), surfacesInUse(*b, metric), skin, skin)
	{
		m_context.worldMetric = metric;
		m_context.warn = nullptr;
		const Result<int> registered = btClodCollisionAlgorithm::registerAlgorithm(&dispatcher(), &m_context);
		if (!registered) throw std::runtime_error(registered.error());
		setShapes(std::make_unique<btClodShape>(a), std::make_unique<btClodShape>(b));
	}

	// Those of the points chosen, else of the nodes within the tolerance.
	void findSurfaces(Answer& answer) const override
	{
		answer.knowsSurfaces = false;
		std::uint32_t level[2] = {kNone, kNone};
		m_context.forEachPair(
			[&](const PairReport& report)
			{
				if (!report.hierarchyA || !report.hierarchyB || !report.clusters) return;
				const bool inOrder = report.objectA == &body(0);
				const auto see = [&](std::uint32_t nodeA, std::uint32_t nodeB)
				{
					std::uint32_t &a = level[inOrder ? 0 : 1], &b = level[inOrder ? 1 : 0];
					const std::uint32_t nowA = report.hierarchyA->node(nodeA).level,
										nowB = report.hierarchyB->node(nodeB).level;
					answer.isMixed |= (a != kNone && a != nowA) || (b != kNone && b != nowB);
					a = std::min(a, nowA);
					b = std::min(b, nowB);
				};
				for (const HeldPoint& held : report.clusters->points()) see(held.point.nodeA, held.point.nodeB);
				if (level[0] == kNone)
					for (const AcceptedPair& contact : report.result->pairs) see(contact.nodeA, contact.nodeB);
			});
		if (level[0] == kNone) return;
		answer.knowsSurfaces = true;
		answer.surfaceA = level[0];
		answer.surfaceB = level[1];
	}

	Context m_context;
};

class GImpactSubject : public BulletSubject
{
public:
	GImpactSubject(const TriangleMesh& a, const TriangleMesh& b)
		: BulletSubject({a}, {b}, kSkinShare * smallerRadius(a, b), 2 * kGImpactMargin * smallerRadius(a, b))
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher());
		std::unique_ptr<btCollisionShape> shapes[2];
		const TriangleMesh* meshes[2] = {&a, &b};
		for (std::size_t i = 0; i < 2; ++i)
		{
			for (const auto& t : meshes[i]->triangles)
				m_arrays[i].addTriangle(toBullet(meshes[i]->vertices[t[0]]), toBullet(meshes[i]->vertices[t[1]]),
										toBullet(meshes[i]->vertices[t[2]]));
			auto shape = std::make_unique<btGImpactMeshShape>(&m_arrays[i]);
			shape->setMargin(btScalar(kGImpactMargin * smallerRadius(a, b)));
			shape->updateBound();
			shapes[i] = std::move(shape);
		}
		setShapes(std::move(shapes[0]), std::move(shapes[1]));
	}

private:
	btTriangleMesh m_arrays[2];
};

class BoxSubject : public BulletSubject
{
public:
	BoxSubject(const Vec3& halfOfA, const Vec3& halfOfB) : BulletSubject({box(halfOfA)}, {box(halfOfB)},
						kSkinShare * std::min(length(halfOfA), length(halfOfB)), 0)
	{
		setShapes(std::make_unique<btBoxShape>(toBullet(halfOfA)), std::make_unique<btBoxShape>(toBullet(halfOfB)));
	}
};
}  // namespace

std::vector<TriangleMesh> levelSurfaces(const Hierarchy& hierarchy)
{
	std::vector<TriangleMesh> surfaces;
	for (const Level& level : hierarchy.levels())
	{
		if (!(level.flags & kClodNode) || level.faceCount == 0) break;
		TriangleMesh mesh;
		std::map<std::tuple<double, double, double>, std::uint32_t> indexOf;
		for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
		{
			const HullView hull = hierarchy.hull(hierarchy.node(n));
			for (const Face& face : hierarchy.faces(hierarchy.node(n)))
			{
				std::array<std::uint32_t, 3> triangle;
				for (std::size_t i = 0; i < 3; ++i)
				{
					const Vec3 v = hull.vertex(face.vertex[i]);
					const auto found = indexOf.insert({{v.x, v.y, v.z}, std::uint32_t(mesh.vertices.size())});
					if (found.second) mesh.vertices.push_back(v);
					triangle[i] = found.first->second;
				}
				mesh.triangles.push_back(triangle);
			}
		}
		surfaces.push_back(std::move(mesh));
	}
	return surfaces;
}

BulletSubject::BulletSubject(std::vector<TriangleMesh> a, std::vector<TriangleMesh> b, double skin, double raise)
	: m_surfaces{std::move(a), std::move(b)}, m_skin(skin), m_raise(raise)
{
	m_world.getDispatchInfo().m_deterministicOverlappingPairs = true;
}

void BulletSubject::setShapes(std::unique_ptr<btCollisionShape> a, std::unique_ptr<btCollisionShape> b)
{
	m_shapes[0] = std::move(a);
	m_shapes[1] = std::move(b);
	for (std::size_t i = 0; i < 2; ++i)
		m_bodies[i] = std::make_unique<btRigidBody>(1, nullptr, m_shapes[i].get(), btVector3(1, 1, 1));
}

Answer BulletSubject::answer(const Transform& aFromB, const RelativeMotion& motion)
{
	m_bodies[0]->setLinearVelocity(toBullet(motion.linear));
	m_bodies[0]->setAngularVelocity(toBullet(motion.angular));
	m_bodies[1]->setWorldTransform(toBullet(aFromB));
	const btScalar dt = btScalar(motion.timeStep);
	for (const auto& body : m_bodies)
	{
		btTransform predicted;
		body->predictIntegratedTransform(dt, predicted);
		body->setInterpolationWorldTransform(predicted);
		body->setInterpolationLinearVelocity(body->getLinearVelocity());
		body->setInterpolationAngularVelocity(body->getAngularVelocity());
		m_world.addCollisionObject(body.get());
	}
	m_world.getDispatchInfo().m_timeStep = dt;
	m_world.performDiscreteCollisionDetection();
	Answer answer;
	for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
	{
		const btPersistentManifold& manifold = *m_dispatcher.getManifoldByIndexInternal(i);
		const bool inOrder = manifold.getBody0() == m_bodies[0].get();
		for (int k = 0; k < manifold.getNumContacts(); ++k)
		{
			const btManifoldPoint& point = manifold.getContactPoint(k);
			const btVector3& onA = inOrder ? point.getPositionWorldOnA() : point.getPositionWorldOnB();
			const Vec3 n = toVec3(point.m_normalWorldOnB);
			// The row asks velocities for more than the height where a turning body's path bends away; what it asks to
			// part stands as a token overlap times an ERP above 1 (clod/bullet/SolverTerms.h).
			const double row = double(point.getDistance()) * std::max(1.0, double(point.m_contactERP));
			const double height = double((point.getPositionWorldOnA() - point.getPositionWorldOnB()).dot(point.m_normalWorldOnB));
			answer.constraints.push_back(
				{toVec3(onA), normalized(inOrder ? n : -n), height + m_raise, row - height});
		}
	}
	findSurfaces(answer);
	for (const auto& body : m_bodies) m_world.removeCollisionObject(body.get());
	return answer;
}

std::unique_ptr<Subject> clodSubject(const HierarchyPointer& a, const HierarchyPointer& b, const ContactMetric& metric)
{
	return std::make_unique<ClodSubject>(a, b, metric);
}

std::unique_ptr<Subject> gimpactSubject(const TriangleMesh& a, const TriangleMesh& b)
{
	return std::make_unique<GImpactSubject>(a, b);
}

std::unique_ptr<Subject> boxSubject(const Vec3& halfOfA, const Vec3& halfOfB)
{
	return std::make_unique<BoxSubject>(halfOfA, halfOfB);
}
}  // namespace clod::oracle
