// SPDX-License-Identifier: Zlib
// All state of one Bullet pair, behind one pointer of the (tiny) collision algorithm. A dispatch is three steps that hand
// values on: pose (PairPose.h), query (accepted node pairs), points (clusters); then they are written as manifolds, and
// reported. What lasts from dispatch to dispatch: the query's caches, last step's clusters, and the question they answer.
#pragma once
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clod/bullet/Manifolds.h"
#include "clod/bullet/PairMetric.h"
#include "clod/bullet/PairPose.h"
#include "clod/schedule/StepBudget.h"
#include "clod/distance/SignedGap.h"
#include "clod/query/BackOff.h"
#include "clod/manifold/FacetContacts.h"
#include "clod/manifold/PartnerContacts.h"

namespace clod
{
class PairState
{
public:
	// A pair made for contactTest and the like predicts nothing: it answers for the poses as they are. budget: of the
	// steps that the pair takes part in; null: answers in full, whatever the budget.
	PairState(Context& context, btDispatcher& dispatcher, btPersistentManifold* shared, bool isClosestPoints,
			  StepBudget* budget, const btCollisionObject& object0, const btCollisionObject& object1);
	~PairState();
	void loseContext() { m_hasContext = false; }  // it is destroyed before the pair, which may then only be destroyed, too
	PairState(const PairState&) = delete;
	PairState& operator=(const PairState&) = delete;

	// False, and no contacts, where the two are no pair of ours.
	bool process(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				 const btDispatcherInfo& info, btManifoldResult& out);
	// What the points may miss of the motion as solved, being found for another; in skins.
	double surprise() const;
	// How far the solver has left them beneath what its points require, as its iterations were too few; in skins.
	double unmet() const;
	// The parts of the coming process() that concern nothing but this pair: its question and, under a budget, what the
	// coarsest answer takes, which is held back then; and the answer, up to its points, before they are written. Other pairs
	// may be at it at the same time.
	void outline(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				 const btDispatcherInfo& info);
	void prepare(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				 const btDispatcherInfo& info);
	// Of one prepared, where it lies still: by which factor it misses its metric. None: it needs nothing. And what a step's
	// budget leaves is spent on it.
	std::optional<double> want() const;
	void refine();
	// What a coarsest answer will take in a step that begins, as far as it is not known: what it took last.
	void expect(StepBudget& budget);
	// TimeOfImpact.cpp has these two.
	double timeOfImpact(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info);
	// With the bodies at the end of the way from their last dispatch: the share of it at which there was an impact that
	// only the levels see which are asked for now, or 1. The levels of that dispatch are held then, see PairMetric.
	double timeOfSwitch(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info);
	// The world goes back to that share of the way only: a switch later on it is not to be held yet.
	void dropSwitchesAfter(double share) { m_metric.dropAfter(share); }
	bool isOf(const btDispatcher& dispatcher) const { return &m_manifolds.dispatcher() == &dispatcher; }
	void append(btManifoldArray& manifolds) const { m_manifolds.append(manifolds); }
	const PairReport& lastReport() const { return m_report; }

	// All that later steps depend on, as it is between two steps; caches are not, nor what budgets have learned. Of one
	// that lasts no longer than a question nothing is saved.
	struct Saved;
	std::optional<Saved> save() const;
	bool isOf(const Saved& saved) const;
	// Goes on from there, or from nothing.
	void restore(const Saved& saved);

private:
	static constexpr std::uint32_t kMostRefused = 15;  // dispatches until a finer answer is tried again, at most
	// Which shape a body has. Shapes change under a live pair, and others are made in their place.
	struct Seen
	{
		const btCollisionShape* shape = nullptr;
		std::uint64_t contentHash = 0;  // of the hierarchy, where it has one,
		int revision = -1;              // and that of a shape of ours
		bool operator==(const Seen& other) const
		{
			return shape == other.shape && contentHash == other.contentHash && revision == other.revision;
		}
	};
	// The step as the pair's points alone would have it, and what they were found for.
	struct Foreseen
	{
		Transform worldFromA;
		double scale = 1, timeStep = 0, tolerance = 0;
		double skin = 1, radius = 0;  // of the smaller body,
		Vec3 center;                  // frame A
		RelativeMotion motion;        // of A's geometry relative to B's,
		bool bIsPoint = false;        // (PairBody)
		double spare = 0;             // and by how much another may differ before it meets what was looked at and given up
		double missed = 0;            // how deep this one leads though a solver meets all rows
	};
	// What a dispatch asks of two shapes of ours: equal questions have equal answers.
	struct Question
	{
		Transform aFromB;
		GapSettings settings;
		PointRules rules;
		bool withGap = false;
		std::array<double, 4> plane{};  // what B is, where it is one
		double way = 0;                 // of the step, as the bodies move, forces apart
	};
	struct Prepared
	{
		PairPose pose;
		Question question;
		bool aIsFirst = true, isAnswered = false;
		bool isKept = false;  // the answer of the dispatch before is this one's,
		bool isStill = false;  // or its points are, as bodies hardly move
		bool isOutlined = false;
		double carriedShare = 1;
		// Bullet's live no longer than the call they are given to: those of the last one serve.
		void holdWrappers(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1)
		{
			(aIsFirst ? pose.a : pose.b) = &body0;
			(aIsFirst ? pose.b : pose.a) = &body1;
		}
	};
	// A body of the two as it was when points were written, for other pairs to which a joined one belongs: of what does
	// not move freely, or a compound's child.
	struct Side
	{
		const btCollisionObject* object = nullptr;
		int child = -1;
		Transform objectFromSide;  // world lengths
		std::shared_ptr<const Hierarchy> hierarchy;
		std::shared_ptr<const ContactSurface> surface;  // where it has none
		double unit = 1, radius = 0;
		std::uint32_t level = 0;
	};
	using Sides = std::array<std::optional<Side>, 2>;  // A, B
	// In a dispatch others are told what held before it, whichever pair is asked first.
	struct Told
	{
		Sides now, before;
		std::uint64_t dispatch = 0;  // that `now` is of; 0: one before all
	};
	void noteSides(const PairPose& pose);
	void tell(Sides sides);
	const Sides& told() const;
	void addJoined(const PairPose& pose, std::size_t side, std::vector<JoinedBody>& joined) const;
	const JoinedBodies& joinedBodies(const PairPose& pose) const;
	WorldFrame worldFrame(const Prepared& prepared, double closestPoints) const;
	static Seen seenA(const PairPose& pose);
	static Seen seenB(const PairPose& pose);
	static bool same(const Question& l, const Question& r);
	static double carriedShare(const PointRules& then, const PointRules& now);
	void noteAnswered(Question& question);
	bool isStill(const PairPose& pose, const Question& question) const;

	bool staysOverPlane(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
						const btDispatcherInfo& info);
	Prepared& ahead(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
					const btDispatcherInfo& info);
	void open(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, const btDispatcherInfo& info,
			  double closestPoints, Prepared& next);
	void complete(Prepared& prepared);
	void outline(Prepared& prepared);
	std::uint32_t ofCoarsest() const;
	std::optional<double> want(const Prepared& prepared) const;
	void refine(Prepared& prepared);
	bool isRefinable(const PairPose& pose, const Question& question) const;
	double finerCoarsening() const;
	// Pose.
	Metric metricFor(const PairPose& pose);
	PairPose begin(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
				   const btDispatcherInfo& info, double closestPoints);
	void noticeShapes(const PairPose& pose);
	bool liesAlone(const PairPose& pose) const;
	double shoveOf(const PairPose& pose) const;
	Question questionOf(const PairPose& pose);
	// Query.
	void ask(const PairPose& pose, const Question& question, bool isAsked = false);  // asked: the result is at hand
	void askAside(const PairPose& pose, Question& question, bool isAsked);
	void query(const PairPose& pose, const Question& question);  // outlined, if there is a budget
	void take(const Question& question);
	bool askIfAllowed(const PairPose& pose, const Question& question);
	// Within the settings' budget; no gap. Tells the tests, and whether they were enough: if not, they were in vain.
	bool attempt(const PairPose& pose, ContactSettings& settings, std::uint32_t& tests);
	void askPartner(const PairPose& pose);
	void answerPartner(const PairPose& pose);
	// Points.
	void answer(const PairPose& pose, Question& question, bool isAsked = false);
	void foresee(const PairPose& pose);
	void findPoints(const PairPose& pose, Question& question, bool goesOn);
	bool isSweptThrough(const PairPose& pose) const;
	ContactBody bodyB(const PairPose& pose) const;
	bool refineHeld(const PairPose& pose, Question& question);
	void namePartnerFace(const PairPose& pose, ContactPoint& point);
	bool follow(const PairPose& pose, const WorldFrame& frame, btManifoldResult& out);
	void write(const PairPose& pose, WorldFrame& frame, btManifoldResult& out);
	// Report.
	void report(const PairPose& pose);
	bool isDeep() const;
	double errorOfContacts(const PairPose& pose) const;
	void forget();
	void sayOnce(unsigned cause, const std::string& message);
	std::string bodies() const;
	void warnOnce(bool now, unsigned cause, const char* what);

	Context& m_context;
	Context::Shared& m_shared;  // of the dispatcher
	ManifoldSet m_manifolds;
	const bool m_isClosestPoints;
	std::array<const btCollisionObject*, 2> m_objects;
	std::array<const std::vector<PairState*>*, 2> m_pairsOf{};  // by body; none of a pair that does not last
	std::unique_ptr<Told> m_told;  // none where there was never anything to tell
	PairMetric m_metric;
	double m_grown = 0;  // by which surfaces count as touching, after an impact between levels
	// From dispatch to dispatch.
	Seen m_seenA, m_seenB;
	std::array<int, 2> m_children{-1, -1};  // of compounds, that A and B are
	std::shared_ptr<const ConvexPartner> m_convex;
	HierarchyPair m_asked;
	GapCache m_cache;
	std::unique_ptr<Question> m_answered;  // what the clusters answer; none where there are none
	std::uint32_t m_followed = 0;        // dispatches whose points are those of an earlier pose, nearly the same
	Foreseen m_foreseen;
	HeldClusters m_clusters;
	PairReport m_report;
	unsigned m_warned = 0;
	std::vector<std::pair<unsigned, std::string>> m_toSay;  // by cause
	bool m_hasContext = true;
	StepBudget* const m_budget;
	std::uint64_t m_lastOrder = 0;      // that this pair was asked in
	std::uint64_t m_step = 0;           // of the budget, that this pair was last in,
	Work m_held;                        // what is held back of it for this pair
	std::uint32_t m_points = 0, m_ofCoarsest = 0;  // what its last points were worth, and those of its coarsest answer
	BackOff m_refining{kMostRefused};   // of finer answers, where they cost too much
	double m_heldError = kOff;          // that contacts may have since a body was found jammed (isJammedBetween)
	Outline m_outline;                  // of the coming process(), or the last
	std::unique_ptr<Prepared> m_ahead;  // for the coming process(), if m_isAhead; none where nothing was ever prepared
	bool m_isAhead = false;
	FacetMemory m_facets;
	HeldResult m_result;
	PartnerStats m_partnerStats;
	std::unique_ptr<NearMesh> m_mesh;  // where B is one,
	std::shared_ptr<const ContactSurface> m_partnerSurface;  // and its surface in there; or that of a plane
};

struct PairState::Saved
{
	std::array<const btCollisionObject*, 2> objects{};
	std::array<int, 2> children{-1, -1};
	Seen seenA, seenB;
	std::optional<Question> answered;
	std::uint32_t followed = 0;
	std::uint64_t lastOrder = 0;
	Foreseen foreseen;
	HeldClusters clusters;
	PairReport report;
	double heldError = kOff;
	FacetMemory facets;
	HeldResult result;
	PartnerStats partnerStats;
	std::optional<NearMesh::Gathered> mesh;
	Sides sides;
	ManifoldSet::Saved manifolds;
	void addTo(std::vector<double>& numbers) const;  // if it has points: all that tells it from another but addresses
};

struct SavedContacts
{
	std::uint64_t order = 0;
	std::vector<PairState::Saved> pairs;
};
}  // namespace clod
