// SPDX-License-Identifier: Zlib
// Shapes of Bullet and of ours, dispatched at recorded poses.
#include "demos/peers/BulletPeers.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <clod/bullet/Context.h>
#include <clod/bullet/btClodCollisionAlgorithm.h>
#include <clod/bullet/btClodShape.h>
#include <clod/manifold/ContactPoints.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>

#include "cli/Failure.h"
#include "demos/peers/DispatchWorld.h"
#include "demos/runner/Replay.h"
#include "demos/scenes/BulletPose.h"
#include "demos/scenes/BulletShapes.h"

namespace clod::demo
{
namespace
{
double secondsSince(std::chrono::steady_clock::time_point start)
{
	return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// By more than they hold: what was in them has to come from memory again.
void emptyProcessorCaches()
{
	static std::vector<unsigned char> other(std::size_t(64) << 20);
	for (std::size_t i = 0; i < other.size(); i += 64) ++other[i];
}

// Runs two shapes over a sample. `raise` is what has to be added to manifold distances to give those of the surfaces.
class DispatchPeer : public Peer
{
public:
	std::vector<PeerAnswer> pass(const PoseSample& sample) override
	{
		const auto newWorld = [this]
		{
			return std::make_unique<DispatchWorld>(*m_shapes[0], *m_shapes[1],
												   [this](btCollisionDispatcher& d) { addAlgorithms(d); });
		};
		std::unique_ptr<DispatchWorld> world = newWorld();
		std::vector<PeerAnswer> answers;
		for (const PoseSample::Row& row : sample.rows)
		{
			prepare(row.poses);
			if (sample.isCold)
			{
				world.reset();
				world = newWorld();
				emptyProcessorCaches();
			}
			const double time =
				world->dispatch(placed(row.before.a, row.poses.a, m_frame.originA, row.seconds),
							   placed(row.before.b, row.poses.b, m_frame.originB, row.seconds), sample.dt);
			if (!row.measured) continue;
			answers.push_back(read(*world, inverse(toTransform(row.poses.a))));
			answers.back().microseconds = time;
			answers.back().bytes = world->pairBytes();
		}
		return answers;
	}

protected:
	DispatchPeer(PeerInfo info, const PairFrame& frame, double raise)
		: Peer(std::move(info)), m_frame(frame), m_raise(raise)
	{
		m_info.timed = Timed::dispatch;
	}
	virtual void addAlgorithms(btCollisionDispatcher&) {}
	virtual void prepare(const PoseRow&) {}  // before a row's dispatch
	virtual double promisedBound() const { return std::numeric_limits<double>::quiet_NaN(); }
	void setShape(int index, std::unique_ptr<btCollisionShape> shape) { m_shapes[index] = std::move(shape); }

	const PairFrame m_frame;

private:
	PlacedBody placed(const Pose& before, const Pose& now, const Vec3& origin, double seconds) const
	{
		const BodyVelocity velocity = velocityBetween(before, now, origin, seconds);
		return {bodyTransform(now, origin, m_frame.worldScale), toBullet(velocity.linear, m_frame.worldScale),
				toBullet(velocity.angular)};
	}
	PeerAnswer read(const DispatchWorld& world, const Transform& meshAFromWorld) const
	{
		PeerAnswer answer;
		const double bound = promisedBound();
		const auto add = [&](const btVector3& onB, const btVector3& normal, btScalar distance)
		{
			const btVector3 middle = onB + btScalar(0.5) * distance * normal;
			const PeerContact contact{meshAFromWorld * fromBullet(middle, m_frame.worldScale),
									  meshAFromWorld.rotation * fromBullet(normal),
									  double(distance) / m_frame.worldScale + m_raise, bound};
			answer.gap = std::min(answer.gap, contact.distance);
			answer.contacts.push_back(contact);
		};
		world.forEachPoint(add);
		return answer;
	}
	double m_raise;
	std::unique_ptr<btCollisionShape> m_shapes[2];
};

// Margins, the skin and the plugin's resting height together are the tolerance.
double clodMargin(const Hierarchy& a, const Hierarchy& b, double tolerance)
{
	return std::max(0.0, (tolerance - (kRestingShare + kSkinShare) * smallerRadius(a, b)) / 2);
}

class ClodDispatchPeer : public DispatchPeer
{
public:
	ClodDispatchPeer(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b, const Threshold& threshold,
					 const PairFrame& frame)
		: DispatchPeer(std::move(info), frame,
					   2 * clodMargin(*a, *b, frame.tolerance) + kSkinShare * smallerRadius(*a, *b)),
		  m_camera(threshold.camera)
	{
		m_context.worldMetric = threshold.metric;
		m_context.budget = threshold.budget;
		m_context.warn = nullptr;
		const double scaledMargin = frame.worldScale * clodMargin(*a, *b, frame.tolerance);
		int index = 0;
		for (const HierarchyPointer& hierarchy : {a, b})
		{
			auto shape = std::make_unique<btClodShape>(hierarchy);
			const btScalar scale = btScalar(frame.worldScale);
			shape->setLocalScaling({scale, scale, scale});
			shape->setMargin(btScalar(scaledMargin));
			setShape(index++, std::move(shape));
		}
		m_info.bytes = a->bytes().size() + b->bytes().size();
	}

private:
	void addAlgorithms(btCollisionDispatcher& dispatcher) override
	{
		const Result<int> registered = btClodCollisionAlgorithm::registerAlgorithm(&dispatcher, &m_context);
		if (!registered) throw cli::Failure(cli::ExitCode::failure, registered.error());
	}
	// Of a depth nothing is promised; an exact contact lies no farther from ours than this all the same.
	double promisedBound() const override
	{
		double bound = std::numeric_limits<double>::quiet_NaN();
		m_context.forEachPair([&](const PairReport& report) { bound = report.contactError; });
		return bound;
	}
	void prepare(const PoseRow& poses) override
	{
		if (m_camera) m_context.camera = scaled(m_camera->at(poses.step), m_frame.worldScale);
	}
	std::optional<CameraPath> m_camera;
	Context m_context;  // outlives the worlds that pass() makes
};

class MeshPeer : public DispatchPeer
{
public:
	MeshPeer(PeerInfo info, const ModelMesh& a, const ModelMesh& b, bool staticA, const PairFrame& frame)
		: DispatchPeer(std::move(info), frame, 2 * marginOf(frame, staticA)),
		  m_margin(btScalar(frame.worldScale * marginOf(frame, staticA))),
		  m_meshA(a, frame.originA, frame.worldScale),
		  m_meshB(b, frame.originB, frame.worldScale)
	{
		const auto start = std::chrono::steady_clock::now();
		m_info.bytes = m_meshA.bytes() + m_meshB.bytes();
		if (staticA)
			addStatic();
		else
			addMoving(0, m_meshA);
		addMoving(1, m_meshB);
		m_info.buildSeconds = secondsSince(start);
		m_info.sizeA = a.triangles.size();
		m_info.sizeB = b.triangles.size();
	}

private:
	// A static mesh meets a GImpact mesh only within one margin, two GImpact meshes within the sum of both.
	static double marginOf(const PairFrame& frame, bool staticA)
	{
		return staticA ? frame.tolerance : frame.tolerance / 2;
	}
	void addMoving(int index, const BulletMesh& mesh)
	{
		auto shape = std::make_unique<btGImpactMeshShape>(mesh.interface());
		shape->setMargin(m_margin);
		shape->updateBound();
		for (int part = 0; part < shape->getMeshPartCount(); ++part)
			m_info.bytes +=
				std::size_t(shape->getMeshPart(part)->getBoxSet()->getNodeCount()) * sizeof(BT_QUANTIZED_BVH_NODE);
		setShape(index, std::move(shape));
	}
	void addStatic()
	{
		auto shape = std::make_unique<btBvhTriangleMeshShape>(m_meshA.interface(), true);
		shape->setMargin(m_margin);
		m_info.bytes += shape->getOptimizedBvh()->calculateSerializeBufferSize();
		setShape(0, std::move(shape));
	}
	void addAlgorithms(btCollisionDispatcher& dispatcher) override
	{
		btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
	}
	btScalar m_margin;
	BulletMesh m_meshA, m_meshB;
};

// Contacts appear at the tolerance: each body has half of it as margin.
std::unique_ptr<btConvexHullShape> hullOf(const ModelMesh& piece, const Vec3& origin, const PairFrame& frame)
{
	return convexHull(piece, origin, frame.worldScale, frame.tolerance / 2);
}

class HullPeer : public DispatchPeer
{
public:
	HullPeer(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame)
		: DispatchPeer(std::move(info), frame, frame.tolerance)
	{
		setShape(0, hullOf(a, frame.originA, frame));
		setShape(1, hullOf(b, frame.originB, frame));
	}
};

class CompoundPeer : public DispatchPeer
{
public:
	CompoundPeer(PeerInfo info, const std::vector<ModelMesh>& a, const std::vector<ModelMesh>& b,
				 const PairFrame& frame)
		: DispatchPeer(std::move(info), frame, frame.tolerance)
	{
		add(0, a, frame.originA);
		add(1, b, frame.originB);
		m_info.sizeA = a.size();
		m_info.sizeB = b.size();
	}

private:
	void add(int index, const std::vector<ModelMesh>& pieces, const Vec3& origin)
	{
		auto compound = std::make_unique<btCompoundShape>(true, int(pieces.size()));
		for (const ModelMesh& piece : pieces)
		{
			std::unique_ptr<btConvexHullShape> hull = hullOf(piece, origin, m_frame);
			compound->addChildShape(btTransform::getIdentity(), hull.get());
			m_info.bytes += piece.vertices.size() * sizeof(btVector3) + sizeof(btConvexHullShape) +
							sizeof(btCompoundShapeChild) + 2 * sizeof(btDbvtNode);
			m_hulls.push_back(std::move(hull));
		}
		setShape(index, std::move(compound));
	}
	std::vector<std::unique_ptr<btConvexHullShape>> m_hulls;
};
}  // namespace

PairFrame pairFrame(const Hierarchy& a, const Hierarchy& b, double worldScale, double tolerance)
{
	return {meshFromBody(a), meshFromBody(b), worldScale, tolerance};
}

PeerPointer clodDispatch(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b,
						 const Threshold& threshold, const PairFrame& frame)
{
	return std::make_unique<ClodDispatchPeer>(std::move(info), a, b, threshold, frame);
}

PeerPointer gimpact(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame)
{
	return std::make_unique<MeshPeer>(std::move(info), a, b, false, frame);
}

PeerPointer bvhGimpact(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame)
{
	return std::make_unique<MeshPeer>(std::move(info), a, b, true, frame);
}

PeerPointer convexHulls(PeerInfo info, const ModelMesh& a, const ModelMesh& b, const PairFrame& frame)
{
	return std::make_unique<HullPeer>(std::move(info), a, b, frame);
}

PeerPointer compounds(PeerInfo info, const std::vector<ModelMesh>& a, const std::vector<ModelMesh>& b,
					  const PairFrame& frame)
{
	return std::make_unique<CompoundPeer>(std::move(info), a, b, frame);
}
}  // namespace clod::demo
