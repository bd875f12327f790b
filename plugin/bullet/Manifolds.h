// SPDX-License-Identifier: Zlib
// Clusters of contact points as Bullet manifolds, one a cluster. Points are placed by us (Bullet's own matching by the
// breaking threshold would merge fine teeth) but made by btManifoldResult::addContactPoint, so that friction, flags and
// the contact callbacks are Bullet's. Impulses follow the points the reducer linked.
#pragma once
#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <array>

#include "clod/query/ContactClusters.h"

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
	std::uint32_t levelA = 0, levelB = 0;
	double breakingThreshold = 0;  // world length
};

class ManifoldSet
{
public:
	ManifoldSet(btDispatcher& dispatcher, btPersistentManifold* shared);
	~ManifoldSet();
	ManifoldSet(const ManifoldSet&) = delete;
	ManifoldSet& operator=(const ManifoldSet&) = delete;

	// Copies last step's impulses from the solver into the set that was written last.
	void readImpulses(ClusterSet& written);
	// Levels of a point's nodes come from `levelOf`, called with the point.
	template <class LevelOf>
	void write(const ClusterSet& clusters, const WorldFrame& frame, const LevelOf& levelOf, btManifoldResult& out)
	{
		beginWrite(clusters);
		for (int slot = 0; slot < kMaxClusters; ++slot)
		{
			const ContactCluster& cluster = clusters.slots[std::size_t(slot)];
			if (!openSlot(slot, cluster, frame, out)) continue;
			for (int i = 0; i < cluster.count; ++i)
			{
				WorldFrame named = frame;
				levelOf(cluster.points[std::size_t(i)].point, named.levelA, named.levelB);
				writePoint(cluster.points[std::size_t(i)], named, out);
			}
			closeSlot(slot, out);
		}
	}
	void append(btManifoldArray& manifolds) const;

private:
	struct Slot
	{
		btPersistentManifold* manifold = nullptr;
		int count = 0;
		std::array<btVector3, kClusterPoints> localPointA;  // as written: finds the points again
	};
	void beginWrite(const ClusterSet& clusters);
	bool openSlot(int slot, const ContactCluster& cluster, const WorldFrame& frame, btManifoldResult& out);
	void writePoint(const ClusterPoint& point, const WorldFrame& frame, btManifoldResult& out);
	void closeSlot(int slot, btManifoldResult& out);

	btDispatcher& m_dispatcher;
	btPersistentManifold* m_shared;
	std::array<Slot, kMaxClusters> m_slots;
	std::array<btManifoldPoint, kMaxClusters * kClusterPoints> m_old;  // what readImpulses found
	std::array<bool, kMaxClusters * kClusterPoints> m_found{};
	// The slot being written.
	std::array<btManifoldPoint, kClusterPoints> m_fresh;
	int m_freshCount = 0;
	bool m_wasEmpty = true;
	btPersistentManifold* m_target = nullptr;
};
}  // namespace clod
