// SPDX-License-Identifier: Zlib
// Dispatch times of our shape and of btGImpactMeshShape, on the same meshes and poses in one run.
#include "demos/runner/DispatchBench.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>
#include <clod/bullet/Context.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodShape.h>
#include <clod/query/ContactPoints.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>

#include "demos/cli/Program.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/BulletPose.h"

namespace clod::demo
{
namespace
{
// Bullet's constants are absolute; tableware in metres is scaled to centimetres, as in the scenes.
constexpr double kWorldScale = 100;

// The input surface as indexed triangles in Bullet's memory, scaled; body frame.
class BulletMesh
{
public:
	explicit BulletMesh(const Hierarchy& hierarchy)
	{
		std::map<std::array<float, 3>, int> indexOf;
		const Level& level = hierarchy.levels()[0];
		for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
		{
			const HullView hull = hierarchy.hull(hierarchy.node(n));
			for (const Face& face : hierarchy.faces(hierarchy.node(n)))
				for (const std::uint16_t v : face.vertex)
					m_indices.push_back(
						indexOf.insert({{hull.x[v], hull.y[v], hull.z[v]}, int(indexOf.size())}).first->second);
		}
		m_vertices.resize(3 * indexOf.size());
		for (const auto& [position, index] : indexOf)
			for (int i = 0; i < 3; ++i) m_vertices[3 * index + i] = btScalar(kWorldScale * double(position[i]));
		m_array.reset(new btTriangleIndexVertexArray(int(m_indices.size() / 3), m_indices.data(), 3 * int(sizeof(int)),
													 int(indexOf.size()), m_vertices.data(),
													 3 * int(sizeof(btScalar))));
	}
	btStridingMeshInterface* interface() const { return m_array.get(); }

private:
	std::vector<int> m_indices;
	std::vector<btScalar> m_vertices;
	std::unique_ptr<btTriangleIndexVertexArray> m_array;
};

// Two collision objects in a world of their own, with persistent algorithms, as a simulation would have them.
class DispatchWorld
{
public:
	DispatchWorld(btCollisionShape& a, btCollisionShape& b)
		: m_dispatcher(&m_configuration), m_world(&m_dispatcher, &m_broadphase, &m_configuration)
	{
		btCollisionShape* shapes[2] = {&a, &b};
		for (int i = 0; i < 2; ++i)
		{
			m_bodies[i].setCollisionShape(shapes[i]);
			m_bodies[i].setCollisionFlags(0);
		}
	}
	~DispatchWorld()
	{
		for (btCollisionObject& body : m_bodies)
			if (body.getBroadphaseHandle()) m_world.removeCollisionObject(&body);
	}
	DispatchWorld(const DispatchWorld&) = delete;
	DispatchWorld& operator=(const DispatchWorld&) = delete;
	btCollisionDispatcher& dispatcher() { return m_dispatcher; }
	// After every algorithm is registered.
	void addBodies()
	{
		for (btCollisionObject& body : m_bodies) m_world.addCollisionObject(&body);
	}
	// Microseconds of one whole dispatch.
	double dispatch(const btTransform& a, const btTransform& b, double dt)
	{
		m_bodies[0].setWorldTransform(a);
		m_bodies[1].setWorldTransform(b);
		m_world.updateAabbs();
		m_world.computeOverlappingPairs();
		btDispatcherInfo& info = m_world.getDispatchInfo();
		info.m_timeStep = btScalar(dt);
		const auto start = std::chrono::steady_clock::now();
		m_dispatcher.dispatchAllCollisionPairs(m_broadphase.getOverlappingPairCache(), info, &m_dispatcher);
		return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
	}
	int points() const
	{
		int count = 0;
		for (int i = 0; i < m_dispatcher.getNumManifolds(); ++i)
			count += m_dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
		return count;
	}

private:
	btDefaultCollisionConfiguration m_configuration;
	mutable btCollisionDispatcher m_dispatcher;
	btDbvtBroadphase m_broadphase;
	btCollisionWorld m_world;
	btCollisionObject m_bodies[2];
};

struct DispatchRows
{
	std::vector<double> microseconds, points;
};

using Register = std::function<void(DispatchWorld&)>;

DispatchRows measure(btCollisionShape& a, btCollisionShape& b, const Register& registerAlgorithms,
					 const std::vector<std::array<btTransform, 2>>& poses, const ReplayOptions& options)
{
	DispatchRows rows;
	for (int pass = 0; pass < options.repeat; ++pass)
	{
		DispatchWorld world(a, b);
		registerAlgorithms(world);
		world.addBodies();
		for (std::size_t i = 0; i < poses.size(); ++i)
		{
			const double time = world.dispatch(poses[i][0], poses[i][1], options.dt);
			if (pass == 0)
				rows.microseconds.push_back(time), rows.points.push_back(world.points());
			else
				rows.microseconds[i] = std::min(rows.microseconds[i], time);
		}
	}
	return rows;
}

DispatchRows measureGimpact(const Hierarchy& a, const Hierarchy& b,
							const std::vector<std::array<btTransform, 2>>& poses, const ReplayOptions& options)
{
	const BulletMesh meshA(a), meshB(b);
	btGImpactMeshShape shapeA(meshA.interface()), shapeB(meshB.interface());
	// Each margin is half the tolerance: contacts appear at the same gap as ours.
	for (btGImpactMeshShape* shape : {&shapeA, &shapeB})
	{
		shape->setMargin(btScalar(kWorldScale * options.settings.tolerance / 2));
		shape->updateBound();
	}
	const auto registerGimpact = [](DispatchWorld& world)
	{ btGImpactCollisionAlgorithm::registerAlgorithm(&world.dispatcher()); };
	return measure(shapeA, shapeB, registerGimpact, poses, options);
}

ContactMetric contactMetric(const Metric& metric)
{
	ContactMetric result;
	result.exact = metric.exact;
	result.weightedDeviation = metric.weightedDeviation;
	result.maxError = metric.maxError;
	return result;
}

DispatchRows measureClod(const HierarchyPointer& a, const HierarchyPointer& b,
						 const std::vector<std::array<btTransform, 2>>& poses, const ReplayOptions& options)
{
	Context context;  // outlives the worlds that measure makes
	context.worldMetric = contactMetric(options.settings.metric);
	context.warn = nullptr;
	btClodShape shapeA(a), shapeB(b);
	const btScalar scale = btScalar(kWorldScale);
	// Both margins and the plugin's resting height together are the tolerance.
	const double resting = kRestingShare * smallerRadius(*a, *b);
	const double margin = std::max(0.0, (options.settings.tolerance - resting) / 2);
	for (btClodShape* shape : {&shapeA, &shapeB})
	{
		shape->setLocalScaling({scale, scale, scale});
		shape->setMargin(btScalar(kWorldScale * margin));
	}
	const auto registerClod = [&](DispatchWorld& world)
	{
		const Result<int> registered = btClodCollisionAlgorithm::registerAlgorithm(&world.dispatcher(), &context);
		if (!registered) throw cli::Failure(cli::ExitCode::failure, registered.error());
	};
	return measure(shapeA, shapeB, registerClod, poses, options);
}

std::vector<double> select(const std::vector<double>& values, const std::vector<bool>& chosen)
{
	std::vector<double> result;
	for (std::size_t i = 0; i < values.size(); ++i)
		if (chosen[i]) result.push_back(values[i]);
	return result;
}

nlohmann::ordered_json compare(const std::vector<bool>& chosen, const std::vector<ReplayRow>& rows,
							   const DispatchRows& ours, const DispatchRows& peer)
{
	std::vector<double> queries;
	for (const ReplayRow& row : rows) queries.push_back(row.queryMicroseconds);
	const std::vector<double> query = select(queries, chosen), dispatch = select(ours.microseconds, chosen),
							  gimpact = select(peer.microseconds, chosen);
	if (query.empty()) return {{"rows", 0}};
	std::vector<double> ratios;
	for (std::size_t i = 0; i < dispatch.size(); ++i) ratios.push_back(dispatch[i] / gimpact[i]);
	return {{"rows", query.size()},
			{"query_us", spread(query)},
			{"clod_dispatch_us", spread(dispatch)},
			{"gimpact_dispatch_us", spread(gimpact)},
			{"clod_points", spread(select(ours.points, chosen))},
			{"gimpact_points", spread(select(peer.points, chosen))},
			{"ratio_of_medians", quantile(dispatch, 0.5) / quantile(gimpact, 0.5)},
			{"row_ratio", spread(ratios)}};
}
}  // namespace

nlohmann::ordered_json comparePeer(const HierarchyPointer& a, const HierarchyPointer& b,
								   const std::vector<PoseRow>& poses, const std::vector<ReplayRow>& rows,
								   const ReplayOptions& options)
{
	std::vector<std::array<btTransform, 2>> transforms;
	for (const PoseRow& row : poses)
		transforms.push_back(
			{bodyTransform(row.a, meshFromBody(*a), kWorldScale), bodyTransform(row.b, meshFromBody(*b), kWorldScale)});
	const DispatchRows ours = measureClod(a, b, transforms, options);
	const DispatchRows peer = measureGimpact(*a, *b, transforms, options);
	std::vector<bool> all(rows.size(), true), moving;
	for (const ReplayRow& row : rows)
		moving.push_back(row.contact(options.settings.tolerance) && row.motion() == Motion::moving);
	return {{"peer", "btGImpactMeshShape"},
			{"world_scale", kWorldScale},
			{"gimpact_margin", options.settings.tolerance / 2},
			{"all_rows", compare(all, rows, ours, peer)},
			{"moving_contact_rows", compare(moving, rows, ours, peer)}};
}

void printPeer(const nlohmann::ordered_json& peer)
{
	fmt::print(
		"\nwhole dispatches of Bullet, {} against itself on the same meshes, median "
		"us\n{:<22}{:>8}{:>12}{:>12}{:>10}{:>12}\n",
		peer["peer"].get<std::string>(), "rows", "count", "clod", "peer", "ratio", "query alone");
	for (const char* name : {"all_rows", "moving_contact_rows"})
	{
		const auto& figures = peer[name];
		if (figures["rows"] == 0) continue;
		fmt::print("{:<22}{:>8}{:>12.1f}{:>12.1f}{:>10.2f}{:>12.1f}\n", name, figures["rows"].get<std::size_t>(),
				   figures["clod_dispatch_us"]["median"].get<double>(),
				   figures["gimpact_dispatch_us"]["median"].get<double>(), figures["ratio_of_medians"].get<double>(),
				   figures["query_us"]["median"].get<double>());
	}
}
}  // namespace clod::demo
