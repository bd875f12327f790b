// SPDX-License-Identifier: Zlib
// Clusters of contact points as Bullet manifolds, one a cluster. Points are placed by us (Bullet's own matching by the
// breaking threshold would merge fine teeth) but made by btManifoldResult::addContactPoint, so that friction, flags and
// the contact callbacks are Bullet's. Impulses follow the points the reducer linked. Where writing would change nothing
// the points stay and are only refreshed, as Bullet does for every pair.
#pragma once
#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "clod/bullet/SolverTerms.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
// How clusters become world points: body A and B, and A's pose with the unit's size in world lengths.
struct WorldFrame
{
	const btCollisionObjectWrapper* a = nullptr;
	const btCollisionObjectWrapper* b = nullptr;
	bool aIsFirst = true;  // Bullet's order of the pair, which is the manifolds'
	Transform worldFromA;  // translation in world lengths
	double scale = 1;      // world lengths a hierarchy unit
	double breakingThreshold = 0;  // world length
	double timeStep = 0;           // 0: points are for the poses as they are
	double pushSpeed = 0;           // at which an overlap is left at most, world lengths a second,
	double switchSpeed = 0;         // and one that came with a change of level,
	double slowOverlap = 0;         // which is at most so much (world length)
	double restingGap = 0;          // the skin, world length: where points carry, such gaps close slowly, by
	double closedShare = 1;         // this of them a step (SolverTerms.h)
	double carriedShare = 1;        // of last step's impulses that points start from
	const HeldClusters* points = nullptr;  // all that are written, of which a coarse surface
	double alike = 0;                    // may set some, by so much, above others that are met as soon (world length)
	bool isNearRest = false;        // do the bodies hardly move?
	bool rocks = false;             // one lies alone on the other (PointRules), but not still
};

class ManifoldSet
{
public:
	ManifoldSet(btDispatcher& dispatcher, btPersistentManifold* shared);
	~ManifoldSet();
	ManifoldSet(const ManifoldSet&) = delete;
	ManifoldSet& operator=(const ManifoldSet&) = delete;

	btDispatcher& dispatcher() const { return m_dispatcher; }
	// For the clusters that were written last, asked to be written again: does every manifold hold them as they were
	// left, and would the same be written? Then points age, are refreshed and seen by gContactProcessedCallback, their
	// impulses are copied into the set, and that is all. False, and nothing done, where anything differs: bodies,
	// poses, materials, a threshold, a point missing, moved or edited; and wherever gContactAddedCallback, stiffness,
	// damping, friction anchors or a result of the caller's own want points to be added.
	bool keep(HeldClusters& written, const WorldFrame& frame, btManifoldResult& out);
	// The same where bodies have moved by less than the points' places can tell: these stay on both bodies, their
	// distances are those between them, and what does not slip is held where it is (friction anchors).
	bool follow(HeldClusters& written, const WorldFrame& frame, btManifoldResult& out);
	bool isAsLeft(const WorldFrame& frame, const btManifoldResult& out) const;  // does nothing but the motion differ?
	// Has the solver given one of their points an impulse?
	bool carry() const;
	// The sum of what the last step gave them along their normals, Bullet's units and sign.
	Vec3 impulse() const;
	// Copies last step's impulses from the solver into the set that was written last.
	void readImpulses(HeldClusters& written) const;
	// The parts of A and B that Bullet is told of a point come from `partsOf`, called with it.
	using Parts = std::array<std::uint32_t, 2>;
	template <class PartsOf>
	void write(HeldClusters& clusters, const WorldFrame& frame, const PartsOf& partsOf, btManifoldResult& out)
	{
		const std::size_t slots = std::max(m_slots.size(), clusters.slots());
		beginWrite(clusters);
		for (std::size_t slot = 0; slot < slots; ++slot)
		{
			if (!openSlot(slot, clusters, frame, out)) continue;
			for (std::size_t i = 0; i < clusters.count(slot); ++i)
				writePoint(clusters.at(slot, i), partsOf(clusters.at(slot, i).point), frame, out);
			closeSlot(slot, out);
		}
		endWrite(clusters, frame, out);
	}
	void append(btManifoldArray& manifolds) const;
	// The farthest that the bodies, as solved, come beneath what any point requires of velocities (SolverTerms.h).
	double unmetWay(double timeStep) const
	{
		double most = 0;
		for (const btPersistentManifold* manifold : m_manifolds)
			if (manifold) most = std::max(most, clod::unmetWay(*manifold, timeStep));
		return most;
	}

	// All that is kept of them, as it is between two steps; a program's data at points are not.
	struct Saved;
	Saved save() const;
	// Drops what is there, and the program's data with it.
	void restore(const Saved& saved);

private:
	// A point as it was written: finds it again, and tells whether anybody has changed it.
	struct Written
	{
		btVector3 localPointA, localPointB, normal;
		btScalar distance = 0, erp = 0, restitution = 0;  // what is set besides what place and materials make of it
		int flags = 0;
		Written() = default;
		explicit Written(const btManifoldPoint& p);
		// A refresh changes none of these. One vertex over two faces is two points.
		bool isOf(const btManifoldPoint& point) const
		{
			return point.m_localPointA == localPointA && point.m_localPointB == localPointB &&
				   point.m_normalWorldOnB == normal;
		}
		bool isEqual(const Written& other) const
		{
			return other.localPointA == localPointA && other.localPointB == localPointB && other.normal == normal;
		}
		bool isUnchanged(const btManifoldPoint& point) const
		{
			return isOf(point) && point.m_combinedRestitution == restitution && point.m_contactPointFlags == flags &&
				   point.m_contactERP == erp;
		}
	};
	// As a manifold was left.
	struct Slot
	{
		int count = 0;
		btScalar breakingThreshold = 0;
		btScalar restitution = 0;  // of the two materials
		std::array<Written, kClusterPoints> points;
	};
	static void setDistances(btPersistentManifold& manifold, const Slot& slot);
	// The point of the last write, if it is still there. Of equal ones, as a corner is that two levels have in common, each is
	// its own.
	static btManifoldPoint* find(btPersistentManifold& manifold, const Slot& slot, std::size_t j);
	// What points are made from besides clusters and materials.
	struct Ground
	{
		const btCollisionObject *a = nullptr, *b = nullptr;
		btTransform poseA, poseB;
		int childA = -1, childB = -1;  // of a compound
		bool aIsFirst = true;
		Transform worldFromA;
		double scale = 1, breakingThreshold = 0;
	};
	static bool isOf(const Ground& ground, const WorldFrame& frame);
	static bool isOn(const Ground& ground, const WorldFrame& frame);
	bool slip() const;  // did friction give all it could in the last step?
	void refresh(std::size_t slot, HeldClusters& written, btManifoldResult& out);
	static void letDown(const WorldFrame& frame, HeldPoint& held, ContactPoint& now);
	bool mayKeep(const WorldFrame& frame, const btManifoldResult& out) const;
	void beginWrite(const HeldClusters& clusters);
	btPersistentManifold* newManifold(std::size_t index, const btCollisionObject& first, const btCollisionObject& second);
	bool openSlot(std::size_t index, HeldClusters& clusters, const WorldFrame& frame, btManifoldResult& out);
	void standIn(const btVector3& onBody0, btManifoldPoint& before);
	void writePoint(const HeldPoint& held, const Parts& parts, const WorldFrame& frame, btManifoldResult& out);
	void closeSlot(std::size_t index, btManifoldResult& out);
	void endWrite(const HeldClusters& clusters, const WorldFrame& frame, const btManifoldResult& out);
	void balance(const WorldFrame& frame);

	btDispatcher& m_dispatcher;
	btPersistentManifold* m_shared;
	std::array<btPersistentManifold*, kMaxClusters> m_manifolds{};
	std::vector<Slot> m_slots;       // up to the last that is written
	std::optional<Ground> m_ground;  // of the last write, where its points may stay
	// The slot being written.
	int m_freshCount = 0;
	bool m_wasEmpty = true;
	btPersistentManifold* m_target = nullptr;
};
struct ManifoldSet::Saved
{
	struct One
	{
		const btCollisionObject *body0 = nullptr, *body1 = nullptr;  // none: there was no manifold
		btScalar breakingThreshold = 0;
		std::vector<btManifoldPoint> points;
	};
	std::array<One, kMaxClusters> manifolds;
	bool areAny() const
	{
		return std::any_of(manifolds.begin(), manifolds.end(), [](const One& one) { return one.body0 != nullptr; });
	}
	std::vector<Slot> slots;
	std::optional<Ground> ground;
};
// The child of a compound that the wrapper is of, else -1.
int childOf(const btCollisionObjectWrapper& wrapper);
}  // namespace clod
