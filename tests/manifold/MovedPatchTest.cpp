// SPDX-License-Identifier: GPL-3.0-or-later
// Which faces are handed to the clipper: none that would leave a polygon is missing, none beyond a plane is among them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "clod/manifold/MovedPatch.h"
#include "tests/query/Questions.h"

namespace clod::test
{
namespace
{
// By its definition, corner by corner.
bool isBeyondAPlane(const FacePrism& prism, double top, const Triangle& triangle)
{
	const auto all = [&](const auto& outside) { return std::all_of(triangle.begin(), triangle.end(), outside); };
	for (std::size_t i = 0; i < 3; ++i)
		if (all([&](const Vec3& p) { return dot(prism.side[i], p) > prism.sideOffset[i]; })) return true;
	return all([&](const Vec3& p) { return prism.heightOf(p) > top; }) ||
		   all([&](const Vec3& p) { return prism.heightOf(p) < prism.bottom; });
}

bool boxMeets(const Triangle& triangle, const Vec3& low, const Vec3& high)
{
	for (int axis = 0; axis < 3; ++axis)
	{
		const double x[3] = {triangle[0][axis], triangle[1][axis], triangle[2][axis]};
		if (*std::min_element(x, x + 3) > high[axis] || *std::max_element(x, x + 3) < low[axis]) return false;
	}
	return true;
}

struct Scene
{
	const Hierarchy &a, &b;
	Transform aFromB;
	RelativeMotion motion;
	double radius;
};

struct Counts
{
	int faces = 0, visited = 0, clipped = 0;
};

void comparePair(const Scene& scene, const Contact& contact, Random& random, Counts& counts)
{
	const Node &nodeA = scene.a.node(contact.nodeA), &nodeB = scene.b.node(contact.nodeB);
	MovedPatch patch;
	patch.move(scene.b, nodeB, scene.aFromB, scene.motion);
	const Vec3 middle = scene.a.hull(nodeA).vertex(0);
	const double half = uniform(random, 0.05, 1) * scene.radius;
	const Vec3 low = middle - Vec3{half, half, half}, high = middle + Vec3{half, half, half};
	std::set<std::uint32_t> near;
	for (std::uint32_t i = 0; i < nodeB.faceCount; ++i)
	{
		Triangle triangle = triangleOf(scene.b, nodeB, scene.b.faces(nodeB)[i]);
		for (Vec3& corner : triangle) corner = scene.aFromB * corner;
		if (boxMeets(triangle, low, high)) near.insert(i);
	}
	ASSERT_EQ(patch.keepNear(low, high), !near.empty());
	for (const Face& face : scene.a.faces(nodeA))
	{
		FacePrism prism = prismOf(scene.a, nodeA, face);
		prism.top = uniform(random, 0, 0.02) * scene.radius;
		const double arrivalTop = uniform(random, 0, 0.001) * scene.radius;
		const bool stepCounts = random() % 2 == 0;
		std::set<std::uint32_t> visited, expected;
		std::uint32_t last = 0;
		patch.visitMeeting(prism, stepCounts, arrivalTop,
						   [&](std::uint32_t i, const Triangle& triangle, const Triangle& carried)
						   {
							   EXPECT_TRUE(visited.empty() || i > last);
							   visited.insert(last = i);
							   for (std::size_t k = 0; k < 3; ++k)
								   EXPECT_EQ(carried[k],
											 triangle[k] + scene.motion.timeStep * scene.motion.velocity(triangle[k]));
						   });
		FacePrism arrival = prism;
		arrival.top = arrivalTop;
		for (const std::uint32_t i : near)
		{
			const Face& other = scene.b.faces(nodeB)[i];
			Triangle triangle = triangleOf(scene.b, nodeB, other);
			for (Vec3& corner : triangle) corner = scene.aFromB * corner;
			Triangle carried = triangle;
			for (Vec3& corner : carried) corner += scene.motion.timeStep * scene.motion.velocity(corner);
			const Vec3 normal =
				scene.aFromB.rotation * Vec3{double(other.normal[0]), double(other.normal[1]), double(other.normal[2])};
			if (dot(prism.normal, normal) >= kOpposingCosine) continue;
			const bool meets = !isBeyondAPlane(prism, prism.top, triangle) ||
							   (stepCounts && !isBeyondAPlane(prism, arrivalTop, carried));
			if (meets) expected.insert(i);
			const bool clips =
				clipToPrism(prism, triangle).count > 0 || (stepCounts && clipToPrism(arrival, carried).count > 0);
			EXPECT_TRUE(meets || !clips);
			counts.clipped += clips ? 1 : 0;
		}
		EXPECT_EQ(visited, expected);
		counts.faces += int(near.size());
		counts.visited += int(visited.size());
	}
}
}  // namespace

TEST(MovedPatch, VisitsTheFacesThatAreBeyondNoPlaneOfAPrism)
{
	Random random(17);
	Counts counts;
	for (const BodyPair& pair : pairs())
		for (int i = 0; i < 30; ++i)
		{
			const double radius = smallerRadius(pair.a, pair.b);
			const Transform pose = poseWithGap(random, pair.a, pair.b, stratifiedGap(random, 1 + i % 2));
			const double size = std::pow(10, uniform(random, -4, -1)) * radius;
			const RelativeMotion motion{size * randomDirection(random), size / radius * randomDirection(random), 1};
			const Scene scene{*pair.a.hierarchy, *pair.b.hierarchy, pose, motion, radius};
			GapCache cache;
			GapResult result;
			query(scene.a, scene.b, pose, exactSettings(0.02 * radius), cache, result);
			for (std::size_t k = 0; k < std::min<std::size_t>(40, result.contacts.size()); ++k)
				comparePair(scene, result.contacts[random() % result.contacts.size()], random, counts);
		}
	EXPECT_GT(counts.clipped, 1000);
	EXPECT_GT(counts.visited, counts.clipped);
	EXPECT_GT(counts.faces, 2 * counts.visited);
}

TEST(MovedPatch, FindsTheSameFacesOnAnyMachine)
{
	Random random(18);
	const auto some = [&] { return uniform(random, -1, 1); };
	int met = 0, near = 0;
	for (int i = 0; i < 20000; ++i)
	{
		FaceLanes group;
		double* const numbers = &group.corner[0][0][0];
		for (std::size_t k = 0; k < sizeof group / sizeof(double); ++k) numbers[k] = some();
		FacePrism prism;
		prism.normal = randomDirection(random);
		prism.offset = some();
		prism.top = uniform(random, 0, 1);
		prism.bottom = -uniform(random, 0, 1);
		for (std::size_t k = 0; k < 3; ++k)
		{
			prism.side[k] = randomDirection(random);
			prism.sideOffset[k] = some();
		}
		const auto faceOf = [](const double(&corner)[3][3][kFaceLanes], std::size_t lane)
		{
			Triangle triangle;
			for (std::size_t k = 0; k < 3; ++k)
				triangle[k] = {corner[k][0][lane], corner[k][1][lane], corner[k][2][lane]};
			return triangle;
		};
		// The innermost corner of one face just on a plane.
		double least = 1e9;
		for (const Vec3& corner : faceOf(group.corner, 2)) least = std::min(least, dot(prism.side[0], corner));
		prism.sideOffset[0] = least;
		const bool stepCounts = i % 2 == 0;
		const std::uint32_t meeting = meetingFaces(group, prism, stepCounts, 0.1);
		ASSERT_EQ(meeting, meetingFacesPlain(group, prism, stepCounts, 0.1));
		for (std::size_t lane = 0; lane < kFaceLanes; ++lane)
		{
			const Vec3 normal{group.normal[0][lane], group.normal[1][lane], group.normal[2][lane]};
			const bool meets = !isBeyondAPlane(prism, prism.top, faceOf(group.corner, lane)) ||
							   (stepCounts && !isBeyondAPlane(prism, 0.1, faceOf(group.carried, lane)));
			ASSERT_EQ((meeting >> lane & 1) != 0, meets && dot(prism.normal, normal) < kOpposingCosine);
		}
		const Vec3 low{some(), some(), some()}, high = low + Vec3{0.3, 0.3, group.corner[0][2][1] - low.z};
		const std::uint32_t around = nearFaces(group, low, high);
		ASSERT_EQ(around, nearFacesPlain(group, low, high));
		met += meeting != 0 ? 1 : 0;
		near += around != 0 ? 1 : 0;
	}
	EXPECT_GT(met, 1000);
	EXPECT_GT(near, 1000);
}
}  // namespace clod::test
