// SPDX-License-Identifier: GPL-3.0-or-later
// Stretched and mirrored hierarchies: sound as files are, their surface that of the scaled triangles, their certified gaps
// true of it by brute force.
#include "clod/hierarchy/ScaledHierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/query/Bodies.h"
#include "tests/query/Questions.h"
#include "tests/query/TriangleGap.h"

namespace clod::test
{
namespace
{
const Vec3 kScales[] = {{2, 2, 2}, {1.01, 1.01, 1.01}, {0.1, 0.1, 0.1}, {1, 2, 0.5}, {-1, 1, 1}, {-0.3, -2, 5}, {-3, -3, -3}, {1, 100, 1}, {0.01, 1, 1}};

Vec3 times(const Vec3& s, const Vec3& v)
{
	return {s.x * v.x, s.y * v.y, s.z * v.z};
}
Body scaledBody(const Body& from, const Vec3& scale)
{
	const auto result = scaledHierarchy(*from.hierarchy, scale);
	if (!result)
	{
		ADD_FAILURE() << result.error();
		return from;
	}
	return bodyOf(from.name, result.value());
}
}  // namespace

TEST(ScaledHierarchy, SurfaceIsThatOfTheScaledTriangles)
{
	for (const char* name : {"torus-900", "cup-3000", "number8-600"})
		for (const Vec3& scale : kScales)
		{
			const Body &from = body(name), to = scaledBody(from, scale);
			EXPECT_EQ(validate(*to.hierarchy), "") << name << " " << scale.x << " " << scale.y << " " << scale.z;
			const double rounding = 1e-6 * double(to.hierarchy->asset().radius);
			ASSERT_EQ(to.triangles.size(), from.triangles.size());
			double volume = 0;
			for (std::size_t t = 0; t < to.triangles.size(); ++t)
			{
				const bool isMirrored = scale.x * scale.y * scale.z < 0;
				for (std::size_t i = 0; i < 3; ++i)
					EXPECT_LT(length(to.triangles[t][isMirrored ? (3 - i) % 3 : i] - times(scale, from.triangles[t][i])),
							  rounding);
				volume += dot(to.triangles[t][0], cross(to.triangles[t][1], to.triangles[t][2])) / 6;
			}
			EXPECT_NEAR(volume, to.hierarchy->asset().volume, 1e-4 * volume) << name;
			EXPECT_GT(volume, 0);
		}
}

TEST(ScaledHierarchy, InertiaIsThatOfTheScaledSolid)
{
	const Body& from = body("number8-600");
	for (const Vec3& scale : kScales)
	{
		const Body to = scaledBody(from, scale);
		double second[3] = {}, mixed[3] = {};
		for (const auto& p : to.triangles)
		{
			const double v = dot(p[0], cross(p[1], p[2])) / 6;
			const Vec3 sum = p[0] + p[1] + p[2];
			const auto moment = [&](int i, int j)
			{
				double s = sum[i] * sum[j];
				for (const Vec3& q : p) s += q[i] * q[j];
				return v / 20 * s;
			};
			for (int i = 0; i < 3; ++i)
			{
				second[i] += moment(i, i);
				mixed[i] -= moment(i == 2 ? 1 : 0, i == 0 ? 1 : 2);
			}
		}
		const Asset& asset = to.hierarchy->asset();
		const double size = second[0] + second[1] + second[2];
		for (int i = 0; i < 3; ++i)
		{
			EXPECT_NEAR(asset.inertia[i], size - second[i], 1e-4 * size);
			EXPECT_NEAR(asset.inertia[3 + i], mixed[i], 1e-4 * size);
		}
		// In the principal frame nothing is mixed.
		const double* q = asset.principal;
		const double* t = asset.inertia;
		const Mat3 turn = rotationFromQuaternion(q[0], q[1], q[2], q[3]);
		const Mat3 tensor = {{{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}}};
		for (int i = 0; i < 3; ++i)
			EXPECT_NEAR(dot(turn.column(i), tensor * turn.column((i + 1) % 3)), 0, 1e-4 * size);
	}
}

// No linear map makes a distance grow by more than its largest factor, nor shrink by more than its smallest.
TEST(ScaledHierarchy, BoundsAreNoLessThanProvedAndHardlyMore)
{
	for (const Vec3& scale : kScales)
	{
		const Hierarchy& from = *body("cup-3000").hierarchy;
		const auto to = scaledHierarchy(from, scale).value();
		const double factors[3] = {std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)};
		const double largest = *std::max_element(factors, factors + 3), smallest = *std::min_element(factors, factors + 3);
		const double rounding = 1e-6 * double(to->asset().radius);
		for (std::uint32_t i = 0; i < from.nodes().size; ++i)
		{
			const Node &a = from.node(i), &b = to->node(i);
			const std::pair<float, float> bounds[] = {
				{a.cover, b.cover}, {a.reach, b.reach}, {a.protrude, b.protrude}, {a.surf, b.surf}, {a.hausdorff, b.hausdorff}};
			for (const auto& [before, after] : bounds)
			{
				EXPECT_GE(double(after), largest * double(before));
				EXPECT_LE(double(after), 1.001 * largest * double(before) + rounding);
			}
			EXPECT_LE(double(b.thickness), largest * double(a.thickness));
			EXPECT_GE(double(b.thickness), 0.999 * smallest * double(a.thickness) - rounding);
			// A wall behind a face is known where nothing is stretched.
			for (std::uint32_t f = 0; f < a.faceCount; ++f)
				EXPECT_NEAR(double(to->faces(b)[f].thickness),
							smallest == largest ? largest * double(from.faces(a)[f].thickness) : 0,
							1e-3 * largest * double(from.faces(a)[f].thickness));
			// Nor is a box larger than the image of the one before.
			const auto &boxBefore = from.cullBox(i).half, &boxAfter = to->cullBox(i).half;
			for (int k = 0; smallest == largest && k < 3; ++k)
				EXPECT_LE(double(boxAfter[k]), 1.001 * largest * double(boxBefore[k]) + 100 * rounding);
		}
	}
}

// At coarse levels, too.
TEST(ScaledHierarchy, CertifiedGapsHoldByBruteForce)
{
	Random random(11);
	int proved = 0;
	for (const Vec3& scale : kScales)
	{
		const Body a = scaledBody(body("cup-3000"), scale), b = scaledBody(body("torus-900"), {1, 0.7, 1.2});
		for (int i = 0; i < 12; ++i)
		{
			const double radius = smallerRadius(a, b);
			const Transform pose = poseWithGap(random, a, b, uniform(random, -0.02, 0.1));
			Settings settings;
			settings.tolerance = 0.2 * radius;
			settings.metric.maxError = (i % 3) * 0.02 * radius;
			settings.metric.exact = i % 3 == 0;
			GapCache cache;
			GapResult result;
			query(*a.hierarchy, *b.hierarchy, pose, settings, cache, result);
			const GapInterval truth = triangleGap(a.triangles, b.triangles, pose, 1e-3 * radius);
			EXPECT_EQ(broken(result, truth, settings.tolerance), "") << scale.x << " " << scale.y << " " << scale.z;
			proved += std::isfinite(result.errorBound);
		}
	}
	EXPECT_GT(proved, 70);
}

TEST(ScaledHierarchy, RefusesWithAReason)
{
	const Hierarchy& from = *body("torus-900").hierarchy;
	const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
	for (const Vec3& bad : {Vec3{0, 1, 1}, Vec3{1, 1, nan}, Vec3{infinity, 1, 1}, Vec3{1e20, 1, 1}, Vec3{1e-20, 1e-20, 1e-20}})
		EXPECT_NE(scaledHierarchy(from, bad).error(), "");
}
}  // namespace clod::test
