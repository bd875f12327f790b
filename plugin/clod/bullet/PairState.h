// SPDX-License-Identifier: Zlib
// All state of one Bullet pair, behind one pointer of the (tiny) collision algorithm: the query's caches, last step's
// clusters and their manifolds, and the report the context reads. Life of a contact: update = poses in double, query,
// candidate points, clusters; write = manifolds.
#pragma once
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <optional>

#include "clod/bullet/Manifolds.h"
#include "clod/bullet/btClodCollisionAlgorithm.h"
#include "clod/bullet/btClodShape.h"
#include "clod/distance/SignedGap.h"
#include "clod/manifold/ContactClusters.h"
#include "clod/manifold/ContactPointsForeign.h"
#include "clod/manifold/ContactPointsSurface.h"
#include "clod/query/Clock.h"

class btConcaveShape;

namespace clod
{
inline constexpr Budget kSpent = {0, kOff};  // of a query whose budget somebody else has spent

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
	enum class Partner
	{
		Clod,
		Plane,
		Concave,
		None
	};
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
	static Seen seen(const btCollisionShape& shape, const btClodShape* ours);
	bool prepare(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				 const btDispatcherInfo& info, double closestPoints);
	bool chooseBodies(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1);
	void chooseMetric();
	GapSettings querySettings() const;
	void ask(const GapSettings& settings);
	bool checkBudget();
	Budget chooseBudget();
	double searchDepth();
	void searchAhead();
	void setMotion(double timeStep, double closestPoints);
	Sweep sweepOfStep() const;
	bool answersAgain() const;
	void answer();
	void linkToThemselves();
	Clock::time_point findPoints();
	void clipForeign();
	void reduce();
	void judge();
	bool deeperThanPoints();
	bool isUnanswered() const;
	double errorOfContacts() const;
	WorldFrame worldFrame(bool aIsFirst, double closestPoints) const;
	std::string whatIsNotFinite(double timeStep) const;
	void forget();
	void sayOnce(unsigned bit, const std::string& message);
	void warnOnce(bool now, unsigned bit, const char* cause);

	Context& m_context;
	ManifoldSet m_manifolds;
	bool m_isClosestPoints;
	// This dispatch.
	Partner m_partner = Partner::None;
	const btCollisionObjectWrapper* m_a = nullptr;
	const btCollisionObjectWrapper* m_b = nullptr;
	const btClodShape* m_shapeA = nullptr;
	const btClodShape* m_shapeB =
		nullptr;             // null where B is no shape of ours; of another scale than A: Partner::Concave
	Transform m_worldFromA;  // world lengths
	Transform m_aFromB;      // hierarchy unit
	PointRules m_rules;
	MetricFrame m_frame;
	std::shared_ptr<const ContactThreshold> m_ownThreshold;  // of the user's metric
	OwnThreshold m_own;                                      // the same as the query calls it
	bool m_hasBudget = false;                                // see checkBudget
	// From dispatch to dispatch.
	Seen m_seenA, m_seenB;
	Transform m_oldAFromB;
	GapCache m_cache;
	GapResult m_result, m_searched;
	ForeignStats m_foreignStats;
	ClusterSet m_clusters, m_previous;
	PairReport m_report;
	// What the clusters answer.
	struct Question
	{
		Transform aFromB;
		GapSettings settings;
		PointRules rules;
		bool withGap = false;
	};
	Question m_question;
	bool m_hasQuestion = false;
	unsigned m_warned = 0;
	bool m_hasPlan = false;         // made by plan(), for the coming process()
	bool m_wasUnanswered = false;   // hulls overlapped in the last dispatch, and no point answered
	std::optional<double> m_depth;  // searched under a budget, for this dispatch's pose
	// Buffers.
	CandidatePool m_pool;
	ForeignClipper m_foreign;
	LeakCheck m_leakCheck;
	ContactReducer m_reducer;
};
}  // namespace clod
