// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that peers place at recorded poses: they carry the velocities of the recording, their times fit the thread's
// own clock, and enough rows stand behind a median.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <gtest/gtest.h>

#include <cmath>

#include "demos/peers/BulletPeers.h"
#include "demos/peers/ClodPeer.h"
#include "demos/peers/DispatchWorld.h"
#include "demos/peers/PeerShapes.h"
#include "demos/runner/InputSurface.h"
#include "tests/demos/BuiltBody.h"

namespace
{
using namespace clod;
using namespace clod::demo;

Pose turned(const Vec3& position, double angle)
{
	return {position, {0, 0, std::sin(angle / 2), std::cos(angle / 2)}};  // about z
}

TEST(PlacedBodies, VelocitiesAreThoseBetweenTwoPoses)
{
	const double dt = 0.01, angle = 0.3;
	const BodyVelocity line = velocityBetween(turned({1, 2, 3}, 0.7), turned({1, 2, 3.5}, 0.7), {5, 6, 7}, dt);
	EXPECT_LT(length(line.linear - Vec3{0, 0, 50}), 1e-9);
	EXPECT_LT(length(line.angular), 1e-9);
	// Round the mesh's origin; the body's own lies one unit along its x.
	const BodyVelocity turn = velocityBetween(turned({}, 0), turned({}, angle), {1, 0, 0}, dt);
	EXPECT_LT(length(turn.angular - Vec3{0, 0, angle / dt}), 1e-9);
	EXPECT_LT(length(turn.linear - (1 / dt) * Vec3{std::cos(angle) - 1, std::sin(angle), 0}), 1e-9);
}

TEST(PeerShapes, AreToldOfInWords)
{
	EXPECT_EQ(describePeerShape("gimpact"), "btGImpactMeshShape, full meshes");
	EXPECT_EQ(describePeerShape("vhacd:7"), "btCompoundShape of at most 7 hulls a mesh");
	EXPECT_EQ(describePeerShape("coacd"), "btCompoundShape of hulls, concavity 0.05");
	EXPECT_EQ(describePeerShape("bvh-hull"), "btConvexHullShape, one a mesh; btBvhTriangleMeshShape for what stands still");
}

TEST(PlacedBodies, RowsComeFromTheRowBefore)
{
	std::vector<PoseRow> poses(3);
	poses[0].step = 4, poses[1].step = 5, poses[2].step = 9;
	poses[1].b.position = {1, 0, 0};
	const RowClock everyRow{0.5}, bySteps{0.5, true};
	EXPECT_EQ(recordedRow(poses, 0, everyRow).before.step, 4);
	EXPECT_EQ(recordedRow(poses, 1, everyRow).before.step, 4);
	EXPECT_EQ(recordedRow(poses, 2, everyRow).seconds, 0.5);
	EXPECT_EQ(recordedRow(poses, 2, bySteps).seconds, 2);
	PoseSample sample;
	sample.rows.push_back(recordedRow(poses, 1, everyRow));
	EXPECT_EQ(sample.rows[0].before.b.position, Vec3{});
	EXPECT_EQ(sample.atRest().rows[0].before.b.position, (Vec3{1, 0, 0}));
}

// What the dispatch finds in the world, by Bullet's own hook.
TEST(PlacedBodies, TheWorldsObjectsHaveTheirVelocities)
{
	btBoxShape box(btVector3(1, 1, 1));
	static std::vector<btVector3> seen;
	seen.clear();
	const auto look = [](btBroadphasePair& pair, btCollisionDispatcher&, const btDispatcherInfo&)
	{
		for (const btBroadphaseProxy* proxy : {pair.m_pProxy0, pair.m_pProxy1})
		{
			const auto& object = *static_cast<const btCollisionObject*>(proxy->m_clientObject);
			seen.push_back(object.getInterpolationLinearVelocity());
			seen.push_back(object.getInterpolationAngularVelocity());
		}
	};
	DispatchWorld world(box, box, [&](btCollisionDispatcher& dispatcher) { dispatcher.setNearCallback(look); });
	const PlacedBody a{btTransform::getIdentity(), {1, 2, 3}, {4, 5, 6}},
		b{btTransform::getIdentity(), {-1, 0, 0}, {0, 7, 0}};
	world.dispatch(a, b, 0.01);
	ASSERT_EQ(seen.size(), 4u);
	const std::size_t first = seen[0] == a.linear ? 0 : 2;
	EXPECT_TRUE(seen[first] == a.linear && seen[first + 1] == a.angular);
	EXPECT_TRUE(seen[2 - first] == b.linear && seen[3 - first] == b.angular);
}

// B slides along A's flank, so near that they touch.
struct Slide
{
	HierarchyPointer torus = test::builtBody("torus", 300).hierarchy;
	PoseSample sample;
	PairFrame frame;
	explicit Slide(std::size_t rows, double metresPerSecond = 0.5)
	{
		sample.tolerance = 0.001;
		frame = pairFrame(*torus, *torus, 100, sample.tolerance);
		std::vector<PoseRow> poses(rows);
		for (std::size_t i = 0; i < rows; ++i)
		{
			const double along = metresPerSecond * sample.dt * double(i % 8);
			poses[i].b.position = {along, 0.0121, 0};
			sample.rows.push_back(recordedRow(poses, i, {sample.dt}));
		}
	}
	std::vector<PeerPointer> ours(const ContactMetric& metric) const
	{
		demo::Threshold threshold;
		threshold.metric = metric;
		std::vector<PeerPointer> peers;
		peers.push_back(clodDispatch({}, torus, torus, threshold, frame));
		peers.push_back(clodQuery({}, torus, torus, threshold, ClodQuestion::contacts));
		return peers;
	}
};

double largestBound(const std::vector<PeerAnswer>& answers)
{
	double bound = 0;
	for (const PeerAnswer& answer : answers)
		for (const PeerContact& contact : answer.contacts) bound = std::max(bound, contact.bound);
	return bound;
}

// The velocity metric shows what a dispatch and a query know of the motion.
TEST(PlacedBodies, MovingOnesAreAnsweredMoreCoarselyWhereVelocityCounts)
{
	const Slide slide(8);
	for (const PeerPointer& peer : slide.ours(ContactMetric::velocityFactor(1)))
	{
		const double moving = largestBound(peer->pass(slide.sample)),
					 still = largestBound(peer->pass(slide.sample.atRest()));
		EXPECT_GT(moving, 1.2 * still) << name(peer->info().timed);
		EXPECT_GT(still, 0);
	}
}

TEST(PlacedBodies, TimesFitTheThreadsOwnClock)
{
	const Slide slide(40);
	std::vector<PeerPointer> peers = slide.ours(ContactMetric::exactly());
	const ModelMesh mesh = inputSurface(*slide.torus);
	peers.push_back(gimpact({}, mesh, mesh, slide.frame));
	for (const PeerPointer& peer : peers)
	{
		const std::clock_t start = std::clock();  // of the process
		double sum = 0;
		for (const PeerAnswer& answer : peer->pass(slide.sample)) sum += answer.microseconds;
		const double spent = 1e6 * double(std::clock() - start) / CLOCKS_PER_SEC;
		EXPECT_LT(sum, spent + 1000) << name(peer->info().timed);
		EXPECT_GT(sum, spent / 50) << name(peer->info().timed);
	}
}

// Four cubes in a row, a fifth that comes to each and between them.
TEST(PlacedBodies, EveryPieceOfACompoundIsThere)
{
	const auto cube = [](double x)
	{
		ModelMesh mesh;
		for (int i = 0; i < 8; ++i)
			mesh.vertices.push_back({x + 0.01 * (i & 1), 0.01 * (i >> 1 & 1), 0.01 * (i >> 2)});
		return mesh;
	};
	PairFrame frame;
	frame.tolerance = 0.001;
	const PeerPointer peer = compounds({}, {cube(0), cube(0.1), cube(0.2), cube(0.3)}, {cube(0)}, frame);
	EXPECT_EQ(peer->info().sizeA, 4u);
	PoseSample sample;
	sample.tolerance = frame.tolerance;
	std::vector<PoseRow> poses(7);
	for (std::size_t i = 0; i < poses.size(); ++i)
	{
		poses[i].b.position = {0.05 * double(i), 0.0105, 0};
		sample.rows.push_back(recordedRow(poses, i, {sample.dt}));
	}
	const std::vector<PeerAnswer> answers = peer->pass(sample.atRest());
	ASSERT_EQ(answers.size(), poses.size());
	for (std::size_t i = 0; i < answers.size(); ++i)
		if (i % 2 == 0)
			EXPECT_NEAR(answers[i].gap, 0.0005, 1e-4) << i;
		else
			EXPECT_TRUE(answers[i].contacts.empty()) << i;
}

TEST(PlacedBodies, AsManyRowsAreMeasuredAsThereAreUpToThoseAskedFor)
{
	const HierarchyPointer box = test::builtBody("box", 12).hierarchy;
	const auto rowsOf = [&](std::size_t touching, int stride, int most)
	{
		std::vector<PoseRow> poses;
		for (std::size_t i = 0; i < 3 * touching; ++i)
		{
			poses.emplace_back();
			poses.back().step = std::int64_t(i);
			// Of three rows one touches; all move.
			poses.back().b.position = {i % 3 == 1 ? 0.0201 : 0.021, 0.001 * double(i % 2), 0};
		}
		SampleRules rules;
		rules.tolerance = 0.0002;
		rules.stride = stride;
		rules.mostRows = most;
		const ExactSample sample = takeSample(box, box, poses, rules, [](double) {});
		EXPECT_EQ(sample.sample.measured(), sample.exact.size());
		for (const ExactRow& row : sample.exact) EXPECT_LE(row.gap, rules.tolerance);
		return sample.exact.size();
	};
	EXPECT_EQ(SampleRules().mostRows, 100);
	EXPECT_EQ(rowsOf(150, 0, 100), 100u);
	EXPECT_EQ(rowsOf(100, 0, 100), 100u);
	EXPECT_EQ(rowsOf(30, 0, 100), 30u);
	EXPECT_EQ(rowsOf(30, 7, 100), 5u);
}
}  // namespace
