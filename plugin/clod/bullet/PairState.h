// SPDX-License-Identifier: Zlib
// All state of one Bullet pair, behind one pointer of the (tiny) collision algorithm. A dispatch is three steps that hand
// values on: pose (PairPose.h), query (accepted node pairs), points (clusters); then they are written as manifolds, and
// reported. What lasts from dispatch to dispatch: the query's caches, last step's clusters, and the question they answer.
#pragma once
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <optional>

#include "clod/bullet/Manifolds.h"
#include "clod/bullet/PairMetric.h"
#include "clod/bullet/PairPlan.h"
#include "clod/bullet/PairPose.h"
#include "clod/distance/SignedGap.h"
#include "clod/manifold/ContactClusters.h"
#include "clod/manifold/ContactPointsForeign.h"
#include "clod/manifold/ContactPointsSurface.h"
#include "clod/query/Clock.h"

namespace clod
{
class PairState
{
public:
	// A pair made for contactTest and the like predicts nothing: it answers for the poses as they are.
	PairState(Context& context, btDispatcher& dispatcher, btPersistentManifold* shared, bool isClosestPoints);
	~PairState();
	PairState(const PairState&) = delete;
	PairState& operator=(const PairState&) = delete;

	void process(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				 const btDispatcherInfo& info, btManifoldResult& out);
	// The first part of the coming process() under a budget over many pairs; empty where there is nothing to plan.
	std::optional<PairPlan> plan(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
								 const btDispatcherInfo& info);
	void append(btManifoldArray& manifolds) const { m_manifolds.append(manifolds); }

private:
	// Which shape a body has. Shapes change under a live pair, and others are made in their place.
	struct Seen
	{
		const btCollisionShape* shape = nullptr;
		std::uint64_t contentHash = 0;  // of the hierarchy, where it is one of ours,
		int revision = -1;              // and the shape's
		bool operator==(const Seen& other) const
		{
			return shape == other.shape && contentHash == other.contentHash && revision == other.revision;
		}
	};
	// What a dispatch asks of two shapes of ours: equal questions have equal answers.
	struct Question
	{
		Transform aFromB;
		GapSettings settings;
		PointRules rules;
		bool withGap = false;
	};
	static Seen seen(const btCollisionShape& shape, const btClodShape* ours);
	static bool same(const Question& l, const Question& r);

	// Pose.
	PairPose begin(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				   const btDispatcherInfo& info, double closestPoints);
	void noticeShapes(const PairPose& pose);
	Question questionOf(const PairPose& pose) const;
	// Query.
	void ask(const PairPose& pose, const Question& question);
	void askForeign(const PairPose& pose);
	bool checkBudget();
	Budget chooseBudget(const PairPose& pose);
	double searchDepth(const PairPose& pose);
	void searchAhead(const PairPose& pose);
	// Points.
	void answer(const PairPose& pose, const Question& question);
	void makePoints(const PairPose& pose);
	void dropLeaks(const PairPose& pose, const ClusterRules& rules);
	void linkToThemselves();
	void write(const PairPose& pose, const WorldFrame& frame, btManifoldResult& out);
	// Report.
	double depthKnown(const PairPose& pose);
	void report(const PairPose& pose, double depth);
	bool hasUnanswered(const PairPose& pose) const;
	bool deeperThanPoints(double depth) const;
	double errorOfContacts(const PairPose& pose) const;
	void forget();
	void sayOnce(unsigned cause, const std::string& message);
	void warnOnce(bool now, unsigned cause, const char* what);

	Context& m_context;
	ManifoldSet m_manifolds;
	const bool m_isClosestPoints;
	PairMetric m_metric;
	// From dispatch to dispatch.
	Seen m_seenA, m_seenB;
	Transform m_oldAFromB;
	GapCache m_cache;
	std::optional<Question> m_answered;  // what the clusters answer
	ClusterSet m_clusters, m_previous;
	PairReport m_report;
	unsigned m_warned = 0;
	bool m_hasPlan = false;         // made by plan(), for the coming process()
	bool m_wasUnanswered = false;   // hulls overlapped in the last dispatch, and no point answered
	bool m_hasBudget = false;       // see checkBudget
	std::optional<double> m_depth;  // searched under a budget, for this dispatch's pose
	// Buffers.
	GapResult m_result, m_searched;
	ForeignStats m_foreignStats;
	CandidatePool m_pool;
	ForeignClipper m_foreign;
	LeakCheck m_leakCheck;
	ContactReducer m_reducer;
};
}  // namespace clod
