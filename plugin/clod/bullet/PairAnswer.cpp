// SPDX-License-Identifier: Zlib
// The second and third step of a dispatch: the query, and the points of what it accepted. Two bodies that stay where they
// are cost what writing their manifolds costs.
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <algorithm>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"

namespace clod
{
namespace
{
constexpr int kLeakRounds = 3;          // reductions after dropping leaking points
constexpr double kTestsPerPending = 8;  // what a pair that was not refined would have taken

// Hands an engine mesh's triangles to the clipper, in A's frame and unit.
struct TriangleSink : btTriangleCallback
{
	ForeignClipper& clipper;
	const PairPose& pose;
	const Metric& metric;
	std::vector<ContactPoint>& points;
	ForeignStats& stats;
	TriangleSink(ForeignClipper& c, const PairPose& p, const Metric& m, std::vector<ContactPoint>& out, ForeignStats& s)
		: clipper(c), pose(p), metric(m), points(out), stats(s)
	{
	}
	void processTriangle(btVector3* corners, int part, int index) override
	{
		Triangle triangle;
		for (std::size_t i = 0; i < 3; ++i) triangle[i] = pose.aFromB * ((1 / pose.scale()) * toVec3(corners[i]));
		clipper.clipTriangle(pose.hierarchyA(), triangle, std::uint32_t(part), std::uint32_t(index), metric, pose.rules,
							 points, stats);
	}
};
}  // namespace

// The gap besides the contacts only where it is asked for: it costs a search of the input surfaces.
void PairState::ask(const PairPose& pose, const Question& question)
{
	GapSettings settings = question.settings;
	settings.budget = chooseBudget(pose);
	if (question.withGap)
		signedGap(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache, m_result);
	else
	{
		contacts(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, settings, m_cache.pair, m_result);
		m_result.minDistance = m_result.errorBound = std::numeric_limits<double>::infinity();
	}
	if (!settings.budget.isLimited()) return;
	const QueryStats& stats = m_result.stats;
	const double tests = double(stats.boxTests) + stats.hullTests + m_report.searchTests;
	m_context.setDemand(m_report, tests + kTestsPerPending * stats.pending);
}

// Planes and meshes have no hierarchy: their points are found on the way.
void PairState::askForeign(const PairPose& pose)
{
	m_result.clear();
	m_foreignStats = {};
	std::vector<ContactPoint>& points = m_pool.startWithPoints();
	if (pose.partner == Partner::kPlane)
	{
		const auto& plane = static_cast<const btStaticPlaneShape&>(*pose.b->getCollisionShape());
		const Vec3 local = toVec3(plane.getPlaneNormal());
		const Vec3 onPlane = pose.aFromB * ((double(plane.getPlaneConstant()) / pose.scale()) * local);
		const Vec3 normal = normalized(pose.aFromB.rotation * local);
		m_foreign.clipPlane(pose.hierarchyA(), normal, dot(normal, onPlane), m_report.metric, pose.rules, points,
							m_foreignStats);
	}
	else
	{
		const auto& concave = static_cast<const btConcaveShape&>(*pose.b->getCollisionShape());
		TriangleSink sink(m_foreign, pose, m_report.metric, points, m_foreignStats);
		const btTransform bFromA = pose.b->getWorldTransform().inverse() * pose.a->getWorldTransform();
		btVector3 low, high;
		pose.shapeA->getAabb(bFromA, low, high);
		const btScalar grow = btScalar(pose.tolerance * pose.scale());
		concave.processAllTriangles(&sink, low - btVector3(grow, grow, grow), high + btVector3(grow, grow, grow));
	}
	m_result.errorBound = m_foreignStats.errorBound;
	m_result.stats.boxTests = m_foreignStats.boxTests;
	m_result.stats.finestLevel = m_foreignStats.nodes ? m_foreignStats.finestLevel : 0;
	m_result.stats.coarsestLevel = m_foreignStats.coarsestLevel;
	for (const ContactPoint& point : points)
		m_result.minDistance = std::min(m_result.minDistance, point.height + pose.rules.margin);
}

// A pair that was apart and is costs no more than it must: nothing is copied, and the clock not read again.
void PairState::answer(const PairPose& pose, const Question& question)
{
	const Clock::time_point start = Clock::now();
	Clock::time_point asked = start;
	if (pose.isOfTwo())
	{
		ask(pose, question);
		asked = Clock::now();
		m_pool.start(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, m_result.contacts, pose.rules);
	}
	else
		askForeign(pose);
	m_report.queryMicroseconds = microsecondsBetween(start, asked);
	m_report.leaks = 0;
	const bool staysEmpty = m_pool.isEmpty() && m_clusters.pointCount() == 0;
	if (!staysEmpty) makePoints(pose);
	m_oldAFromB = pose.aFromB;
	report(pose, depthKnown(pose));
	m_report.contactMicroseconds = staysEmpty ? 0 : microsecondsSince(asked);
	// What a budget cut short answers only under that budget: the next dispatch asks anew, with what it may cost then.
	m_answered.reset();
	if (!(m_result.excess > 0)) m_answered = question;
}

void PairState::makePoints(const PairPose& pose)
{
	ClusterRules rules;
	rules.length = pose.rules.length;
	rules.margin = pose.rules.margin;
	rules.tolerance = pose.rules.resting / pose.rules.length;
	m_previous = m_clusters;
	carryWithB(m_previous, pose.aFromB * inverse(m_oldAFromB));
	m_reducer.reduce(m_pool, m_previous, rules, m_clusters);
	if (pose.isOfTwo() && !m_pool.points().empty()) dropLeaks(pose, rules);
}

// Chosen points that turn out to be leaks are dropped and the choice made again.
void PairState::dropLeaks(const PairPose& pose, const ClusterRules& rules)
{
	m_leakCheck.start(m_result.contacts);
	for (int round = 0; round < kLeakRounds; ++round)
	{
		std::uint32_t leaks = 0;
		for (int slot = 0; slot < kMaxClusters; ++slot)
			for (int i = 0; i < m_clusters.slots[std::size_t(slot)].count; ++i)
			{
				const ContactPoint& point = m_clusters.slots[std::size_t(slot)].points[std::size_t(i)].point;
				if (!m_leakCheck.leaks(pose.hierarchyA(), pose.hierarchyB(), pose.aFromB, point, pose.rules.margin))
					continue;
				m_pool.drop(m_reducer.candidateOf(slot, i));
				++leaks;
			}
		if (leaks == 0) return;
		m_report.leaks += leaks;
		m_reducer.reduce(m_pool, m_previous, rules, m_clusters);
	}
}

// Every point continues the one in its place.
void PairState::linkToThemselves()
{
	for (std::uint32_t slot = 0; slot < kMaxClusters; ++slot)
		for (std::uint32_t i = 0; i < kClusterPoints; ++i)
			m_clusters.slots[slot].points[i].previous = slot * kClusterPoints + i;
}
}  // namespace clod
