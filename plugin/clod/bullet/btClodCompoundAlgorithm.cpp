// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodCompoundAlgorithm.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btCompoundCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCompoundCompoundCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btQuickprof.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <array>
#include <new>
#include <vector>

#include "clod/bullet/BodyState.h"

namespace
{
using Wrapper = btCollisionObjectWrapper;

const btCompoundShape* compoundOf(const btCollisionShape& shape)
{
	return shape.isCompound() ? static_cast<const btCompoundShape*>(&shape) : nullptr;
}

bool hasClod(const btCollisionShape& shape)
{
	const btCompoundShape* compound = compoundOf(shape);
	if (!compound) return dynamic_cast<const btClodShape*>(&shape) != nullptr;
	for (int i = 0; i < compound->getNumChildShapes(); ++i)
		if (hasClod(*compound->getChildShape(i))) return true;
	return false;
}

struct CreateFunction : btCollisionAlgorithmCreateFunc
{
	btCollisionConfiguration& others;
	ebtDispatcherQueryType query;
	CreateFunction(btCollisionConfiguration& configuration, ebtDispatcherQueryType asked)
		: others(configuration), query(asked)
	{
	}
	btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const Wrapper* body0,
												   const Wrapper* body1) override
	{
		const btCollisionShape &shape0 = *body0->getCollisionShape(), &shape1 = *body1->getCollisionShape();
		const int type0 = shape0.getShapeType(), type1 = shape1.getShapeType();
		if (!hasClod(shape0) && !hasClod(shape1))
			return (query == BT_CONTACT_POINT_ALGORITHMS ? others.getCollisionAlgorithmCreateFunc(type0, type1)
														 : others.getClosestPointsAlgorithmCreateFunc(type0, type1))
				->CreateCollisionAlgorithm(info, body0, body1);
		void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btClodCompoundAlgorithm));
		return new (memory) btClodCompoundAlgorithm(info, body0, body1, query);
	}
};

struct Bounds
{
	btVector3 low, high;
	void add(const Bounds& other)
	{
		low.setMin(other.low);
		high.setMax(other.high);
	}
	bool meets(const Bounds& other) const { return TestAabbAgainstAabb2(low, high, other.low, other.high); }
};

btScalar turnBetween(const btTransform& from, const btTransform& to)
{
	btVector3 axis;
	btScalar angle = 0;
	btTransformUtil::calculateDiffAxisAngle(from, to, axis, angle);
	return angle;
}

// A body of the pair, and where the step carries it.
class Side
{
public:
	Side(const Wrapper& body, btScalar timeStep, btScalar reach)
		: m_body(body), m_reach(reach, reach, reach), m_compound(compoundOf(*body.getCollisionShape()))
	{
		const btCollisionObject& object = *body.getCollisionObject();
		m_moves = timeStep > 0 && !clod::isFixed(object);
		if (!m_moves) return;
		btTransform then = object.getInterpolationWorldTransform();
		if (object.isKinematicObject())
			btTransformUtil::integrateTransform(object.getWorldTransform(), object.getInterpolationLinearVelocity(),
												object.getInterpolationAngularVelocity(), timeStep, then);
		m_then = body.m_parent ? then * (object.getWorldTransform().inverse() * body.getWorldTransform()) : then;
		m_bend = 1 - btCos(btScalar(0.5) * turnBetween(body.getWorldTransform(), m_then));
	}
	const Wrapper& body() const { return m_body; }
	const btCompoundShape* compound() const { return m_compound; }
	// Changes whenever the compound's children do.
	int revision() const { return m_compound ? m_compound->getUpdateRevision() : 0; }
	const btCollisionShape& shapeOf(int child) const
	{
		return m_compound ? *m_compound->getChildShape(child) : *m_body.getCollisionShape();
	}
	btTransform poseOf(int child) const
	{
		return m_compound ? m_body.getWorldTransform() * m_compound->getChildTransform(child) : m_body.getWorldTransform();
	}
	// The wrapper keeps a reference to the pose. A body that is no compound counts as its own only child.
	Wrapper childAt(const btTransform& pose, int child) const
	{
		if (!m_compound)
			return {m_body.m_parent, m_body.m_shape, m_body.getCollisionObject(), pose, m_body.m_partId, m_body.m_index};
		return {&m_body, m_compound->getChildShape(child), m_body.getCollisionObject(), pose, -1, child};
	}
	Bounds whole() const { return over(*m_body.getCollisionShape(), btTransform::getIdentity()); }
	Bounds boundsOf(int child) const
	{
		return over(shapeOf(child), m_compound ? m_compound->getChildTransform(child) : btTransform::getIdentity());
	}
	// Lists the children that may come into the bounds, in ascending order.
	void list(const Bounds& other, std::vector<int>& children) const
	{
		children.clear();
		if (!m_compound)
			children.push_back(0);
		else if (const btDbvt* tree = m_compound->getDynamicAabbTree())
		{
			struct Collect : btDbvt::ICollide
			{
				std::vector<int>& found;
				explicit Collect(std::vector<int>& f) : found(f) {}
				void Process(const btDbvtNode* leaf) override { found.push_back(leaf->dataAsInt); }
			} collect(children);
			Bounds local = inFrame(other, m_body.getWorldTransform());
			if (m_moves) local.add(inFrame(other, m_then));
			const btDbvtVolume volume = btDbvtVolume::FromMM(local.low, local.high);
			tree->collideTV(tree->m_root, volume, collect);
			std::sort(children.begin(), children.end());
		}
		else
			for (int i = 0; i < m_compound->getNumChildShapes(); ++i) children.push_back(i);
	}

private:
	static Bounds inFrame(const Bounds& bounds, const btTransform& frame)
	{
		Bounds local;
		btTransformAabb(bounds.low, bounds.high, 0, frame.inverse(), local.low, local.high);
		return local;
	}
	Bounds at(const btCollisionShape& shape, const btTransform& pose) const
	{
		Bounds bounds;
		shape.getAabb(pose, bounds.low, bounds.high);
		return {bounds.low - m_reach, bounds.high + m_reach};
	}
	// Bounds over the way of the step. Between its ends the way of a turning body bulges by the sagitta of the farthest
	// point's arc.
	Bounds over(const btCollisionShape& shape, const btTransform& child) const
	{
		Bounds bounds = at(shape, m_body.getWorldTransform() * child);
		if (!m_moves) return bounds;
		bounds.add(at(shape, m_then * child));
		btVector3 center;
		btScalar radius = 0;
		shape.getBoundingSphere(center, radius);
		const btScalar bend = m_bend * ((child * center).length() + radius);
		return {bounds.low - btVector3(bend, bend, bend), bounds.high + btVector3(bend, bend, bend)};
	}
	const Wrapper& m_body;
	btVector3 m_reach;
	const btCompoundShape* m_compound;
	btTransform m_then;
	btScalar m_bend = 0;  // of a way, a share of its radius
	bool m_moves = false;
};

// Does the program's own filter for children of compounds (Bullet's gCompoundChildShapePairCallback) let these two
// meet?
bool isLetThrough(const Side& side0, const Side& side1, int child0, int child1)
{
	const btCollisionShape &shape0 = side0.shapeOf(child0), &shape1 = side1.shapeOf(child1);
	if (side0.compound() && side1.compound())
		return !gCompoundCompoundChildShapePairCallback || gCompoundCompoundChildShapePairCallback(&shape0, &shape1);
	if (!gCompoundChildShapePairCallback) return true;
	return side0.compound() ? gCompoundChildShapePairCallback(&shape0, &shape1)
							: gCompoundChildShapePairCallback(&shape1, &shape0);
}

// While it lives, contacts are reported with the index of a compound's child.
class ToldOf
{
public:
	ToldOf(btManifoldResult& out, const Side& side, const Wrapper& child, int index)
		: m_out(out), m_isFirst(out.getBody0Internal() == side.body().getCollisionObject()), m_is(side.compound() != nullptr)
	{
		if (!m_is) return;
		m_before = m_isFirst ? out.getBody0Wrap() : out.getBody1Wrap();
		set(&child);
		m_isFirst ? out.setShapeIdentifiersA(-1, index) : out.setShapeIdentifiersB(-1, index);
	}
	~ToldOf()
	{
		if (m_is) set(m_before);
	}
	ToldOf(const ToldOf&) = delete;
	ToldOf& operator=(const ToldOf&) = delete;

private:
	void set(const Wrapper* wrapper) { m_isFirst ? m_out.setBody0Wrap(wrapper) : m_out.setBody1Wrap(wrapper); }
	btManifoldResult& m_out;
	const Wrapper* m_before = nullptr;
	bool m_isFirst, m_is;
};
}  // namespace

struct btClodCompoundAlgorithm::Children
{
	struct Pair
	{
		int child0, child1;
		const btCollisionShape *shape0, *shape1;  // now,
		const btCollisionShape *asked0, *asked1;  // and those that the algorithm is of
		btCollisionAlgorithm* algorithm;
		bool isNear;
		bool isOf(int c0, int c1) const { return child0 == c0 && child1 == c1; }
		bool isBefore(int c0, int c1) const { return child0 != c0 ? child0 < c0 : child1 < c1; }
	};
	btDispatcher& dispatcher;
	btPersistentManifold* shared;
	const ebtDispatcherQueryType query;
	std::vector<Pair> pairs;  // sorted by children
	std::vector<int> list0, list1;
	std::array<int, 2> revisions{};

	Pair& pairOf(int child0, int child1)
	{
		const auto at = std::lower_bound(pairs.begin(), pairs.end(), 0,
										 [&](const Pair& pair, int) { return pair.isBefore(child0, child1); });
		if (at != pairs.end() && at->isOf(child0, child1)) return *at;
		return *pairs.insert(at, {child0, child1, nullptr, nullptr, nullptr, nullptr, nullptr, false});
	}
	void release(Pair& pair)
	{
		if (!pair.algorithm) return;
		pair.algorithm->~btCollisionAlgorithm();
		dispatcher.freeCollisionAlgorithm(pair.algorithm);
		pair.algorithm = nullptr;
	}
	void listNear(const Side& side0, const Side& side1)
	{
		const std::array<int, 2> now{side0.revision(), side1.revision()};
		for (Pair& pair : pairs)
		{
			pair.isNear = false;
			if (now != revisions) pair.asked0 = nullptr;
		}
		revisions = now;
		side0.list(side1.whole(), list0);
		side1.list(side0.whole(), list1);
		for (const int child0 : list0)
		{
			const Bounds bounds = side0.boundsOf(child0);
			for (const int child1 : list1)
			{
				if (!bounds.meets(side1.boundsOf(child1)) || !isLetThrough(side0, side1, child0, child1)) continue;
				Pair& pair = pairOf(child0, child1);
				pair.isNear = true;
				pair.shape0 = &side0.shapeOf(child0);
				pair.shape1 = &side1.shapeOf(child1);
			}
		}
	}
	// Releases the pairs of children that are no longer near or have other shapes by now. This happens where Bullet's
	// own algorithm would do so, because the order of manifolds, on which a solver's result depends, follows from it.
	void releaseOthers()
	{
		for (Pair& pair : pairs)
			if (!pair.isNear || pair.shape0 != pair.asked0 || pair.shape1 != pair.asked1) release(pair);
		pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const Pair& pair) { return !pair.isNear; }), pairs.end());
	}
	// visit(pair, body0, body1) gets the children as bodies; a body that is no compound is handed on as it is.
	template <class Visit>
	void forEachNear(const Side& side0, const Side& side1, Visit visit)
	{
		for (Pair& pair : pairs)
		{
			if (!pair.isNear || (pair.algorithm && (pair.shape0 != pair.asked0 || pair.shape1 != pair.asked1))) continue;
			const btTransform pose0 = side0.poseOf(pair.child0), pose1 = side1.poseOf(pair.child1);
			const Wrapper child0 = side0.childAt(pose0, pair.child0), child1 = side1.childAt(pose1, pair.child1);
			if (!pair.algorithm)
			{
				pair.algorithm = dispatcher.findAlgorithm(&child0, &child1, shared, query);
				pair.asked0 = pair.shape0;
				pair.asked1 = pair.shape1;
			}
			visit(pair, child0, child1);
		}
	}
};

std::unique_ptr<btCollisionAlgorithmCreateFunc> btClodCompoundAlgorithm::createFunction(
	btCollisionDispatcher& dispatcher, ebtDispatcherQueryType query)
{
	return std::make_unique<CreateFunction>(*dispatcher.getCollisionConfiguration(), query);
}

btClodCompoundAlgorithm::btClodCompoundAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const Wrapper* body0,
												 const Wrapper* body1, ebtDispatcherQueryType query)
	: btClodPairAlgorithm(info, body0, body1),
	  m_children(new Children{*info.m_dispatcher1, info.m_manifold, query, {}, {}, {}, {}})
{
}

btClodCompoundAlgorithm::~btClodCompoundAlgorithm()
{
	for (Children::Pair& pair : m_children->pairs) m_children->release(pair);
}

void btClodCompoundAlgorithm::processCollision(const Wrapper* body0, const Wrapper* body1, const btDispatcherInfo& info,
											   btManifoldResult* out)
{
	BT_PROFILE("btClodCompoundAlgorithm::processCollision");
	const btScalar timeStep = m_children->query == BT_CONTACT_POINT_ALGORITHMS ? info.m_timeStep : 0;
	const Side side0(*body0, timeStep, out->m_closestPointDistanceThreshold), side1(*body1, timeStep, 0);
	m_children->listNear(side0, side1);
	m_children->releaseOthers();
	m_children->forEachNear(side0, side1,
							[&](const Children::Pair& pair, const Wrapper& child0, const Wrapper& child1)
							{
								const ToldOf told0(*out, side0, child0, pair.child0), told1(*out, side1, child1, pair.child1);
								pair.algorithm->processCollision(&child0, &child1, info, out);
							});
}

btScalar btClodCompoundAlgorithm::timeOfImpact(const Wrapper& body0, const Wrapper& body1, const btDispatcherInfo& info)
{
	return earliest(&btClodPairAlgorithm::timeOfImpact, body0, body1, info);
}

btScalar btClodCompoundAlgorithm::timeOfSwitch(const Wrapper& body0, const Wrapper& body1, const btDispatcherInfo& info)
{
	return earliest(&btClodPairAlgorithm::timeOfSwitch, body0, body1, info);
}

btScalar btClodCompoundAlgorithm::earliest(Time time, const Wrapper& body0, const Wrapper& body1,
										   const btDispatcherInfo& info)
{
	const Side side0(body0, info.m_timeStep, 0), side1(body1, info.m_timeStep, 0);
	btScalar first = 1;
	m_children->listNear(side0, side1);
	m_children->forEachNear(side0, side1,
							[&](const Children::Pair& pair, const Wrapper& child0, const Wrapper& child1)
							{
								if (auto* ours = dynamic_cast<btClodPairAlgorithm*>(pair.algorithm))
									first = btMin(first, (ours->*time)(child0, child1, info));
							});
	return first;
}

void btClodCompoundAlgorithm::open(const Wrapper& body0, const Wrapper& body1, const btDispatcherInfo& info,
								   const Visit& visit)
{
	const Side side0(body0, info.m_timeStep, 0), side1(body1, info.m_timeStep, 0);
	m_children->listNear(side0, side1);
	m_children->releaseOthers();
	m_children->forEachNear(side0, side1,
							[&](const Children::Pair& pair, const Wrapper& child0, const Wrapper& child1)
							{
								if (auto* compound = dynamic_cast<btClodCompoundAlgorithm*>(pair.algorithm))
									compound->open(child0, child1, info, visit);
								else
									visit(*pair.algorithm, child0, child1);
							});
}

void btClodCompoundAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
	for (const Children::Pair& pair : m_children->pairs)
		if (pair.algorithm) pair.algorithm->getAllContactManifolds(manifolds);
}
