// SPDX-License-Identifier: GPL-3.0-or-later
// Hull distance against exact arithmetic: separated pairs by CGAL's exact quadratic program, overlap by the same (exact
// distance zero). Shapes: round, slab, flat, needle, box; scales 1e-4 to 1e4. CLOD_HULL_PAIRS sets the number of pairs.
#include "clod/collide/HullDistance.h"

#include <CGAL/Cartesian_d.h>
#include <CGAL/Gmpzf.h>
#include <CGAL/Polytope_distance_d.h>
#include <CGAL/Polytope_distance_d_traits_3.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace
{
using namespace clod;
using Kernel = CGAL::Simple_cartesian<double>;
using ExactTraits = CGAL::Polytope_distance_d_traits_3<Kernel, CGAL::Gmpzf, double>;
using ExactDistance = CGAL::Polytope_distance_d<ExactTraits>;

// Hull coordinates as a file holds them: floats, padded by repeating the last vertex.
struct HullData
{
	std::vector<float> x, y, z;
	std::uint32_t count = 0;
	Vec3 sweep;

	void finish()
	{
		count = std::uint32_t(x.size());
		while (x.size() % kVertexLanes != 0)
		{
			x.push_back(x.back());
			y.push_back(y.back());
			z.push_back(z.back());
		}
	}
	void add(const Vec3& p)
	{
		x.push_back(float(p.x));
		y.push_back(float(p.y));
		z.push_back(float(p.z));
	}
	ConvexHull hull() const { return {{x.data(), y.data(), z.data(), count, std::uint32_t(x.size())}, sweep}; }
	double radius() const
	{
		double r = 0;
		for (std::uint32_t i = 0; i < count; ++i) r = std::max(r, length(hull().vertices.vertex(i)) + length(sweep));
		return r;
	}
	std::vector<Kernel::Point_3> points(const Transform& t) const
	{
		std::vector<Kernel::Point_3> result;
		for (std::uint32_t i = 0; i < count; ++i)
			for (int swept = 0; swept < (sweep == Vec3{} ? 1 : 2); ++swept)
			{
				const Vec3 p = t * (hull().vertices.vertex(i) + double(swept) * sweep);
				result.emplace_back(p.x, p.y, p.z);
			}
		return result;
	}
};

using Random = std::mt19937_64;
double uniform(Random& random, double low, double high)
{
	return low + (high - low) * double(random() >> 11) * 0x1p-53;
}
Vec3 direction(Random& random)
{
	for (;;)
	{
		const Vec3 v{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
		const double squared = lengthSquared(v);
		if (squared > 1e-3 && squared < 1) return normalized(v);
	}
}
Mat3 rotation(Random& random)
{
	const Vec3 axis = direction(random);
	const double half = uniform(random, 0, 3.14159);
	return rotationFromQuaternion(std::sin(half) * axis.x, std::sin(half) * axis.y, std::sin(half) * axis.z,
								  std::cos(half));
}

enum class Family
{
	kRound,
	kSlab,
	kFlat,
	kNeedle,
	kBox,
	kTriangle,
	kCount
};

// A hull of size about 1 times scale, rotated so that its thin directions are generic.
HullData makeHull(Random& random, Family family, double scale)
{
	HullData data;
	const Mat3 turn = rotation(random);
	const double thin = std::pow(10, uniform(random, -4, -1));
	const int count = family == Family::kTriangle ? 3 : 4 + int(random() % 28);
	for (int i = 0; i < count; ++i)
	{
		Vec3 p = direction(random);
		if (family == Family::kSlab) p.z *= thin;
		if (family == Family::kFlat) p.z = 0;
		if (family == Family::kNeedle) p = {p.x, p.y * thin, p.z * thin};
		if (family == Family::kBox) p = {i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? thin : -thin};
		data.add(scale * (family == Family::kBox && random() % 2 ? p : turn * p));
	}
	data.finish();
	if (random() % 2)
	{
		const Vec3 way = direction(random);  // two draws in one expression come in the order that the compiler likes
		data.sweep = scale * uniform(random, 0, 0.2) * way;
	}
	return data;
}

struct Pair
{
	HullData a, b;
	Transform aFromB;
	double size = 0;
};

// The gap is steered to be generic, tiny or negative by moving b along the direction that separates the pair.
Pair makePair(Random& random)
{
	Pair pair;
	const double scale = std::pow(10, uniform(random, -4, 4));
	const double ratio = random() % 4 ? 1 : std::pow(10, uniform(random, -3, 0));
	pair.a = makeHull(random, Family(random() % int(Family::kCount)), scale);
	pair.b = makeHull(random, Family(random() % int(Family::kCount)), scale * ratio);
	if (random() % 3) pair.aFromB.rotation = rotation(random);
	const Vec3 way = direction(random);
	pair.aFromB.translation = scale * uniform(random, 0, 3) * way;
	if (random() % 3 == 0) return pair;
	const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
	const HullDistance now = hullDistance(pair.a.hull(), pair.b.hull(), pose, -pair.aFromB.translation, 1e300);
	const double kGaps[] = {0, 1e-9, -1e-9, 1e-6, -1e-6, 1e-4, -1e-4, 1e-2, -1e-2, 0.3, -0.3};
	pair.aFromB.translation += (now.upper - scale * kGaps[random() % 11]) * now.normal;
	return pair;
}

double extent(const std::vector<Kernel::Point_3>& p, const std::vector<Kernel::Point_3>& q)
{
	double size = 0;
	for (const auto& a : p)
		for (const auto& b : q) size = std::max(size, std::sqrt((a - b).squared_length()));
	for (const auto& a : p) size = std::max(size, std::sqrt((a - p[0]).squared_length()));
	for (const auto& b : q) size = std::max(size, std::sqrt((b - q[0]).squared_length()));
	return size;
}

struct Verdict
{
	double error = 0, width = 0;  // of the pair's size
	bool bracketHolds = true, signRight = true, overlapping = false;
};

Verdict judge(const Pair& pair, const RelativePose& pose, const HullDistance& ours)
{
	const auto p = pair.a.points(Transform{}), q = pair.b.points(pair.aFromB);
	ExactDistance exact(p.begin(), p.end(), q.begin(), q.end());
	const double squared =
		CGAL::to_double(exact.squared_distance_numerator()) / CGAL::to_double(exact.squared_distance_denominator());
	const double truth = std::sqrt(std::max(0.0, squared)), size = extent(p, q);
	Verdict verdict;
	verdict.overlapping = truth == 0;
	verdict.error = std::abs(ours.upper - truth) / size;
	verdict.width = (ours.upper - ours.lower) / size;
	const double rounding = 2 * pose.rounding;
	verdict.bracketHolds = ours.lower <= truth + rounding && truth <= ours.upper + rounding;
	verdict.signRight = truth > 1e-5 * size ? !ours.overlap : truth > 0 || ours.overlap || ours.upper < 1e-9 * size;
	return verdict;
}

int pairCount()
{
	const char* text = std::getenv("CLOD_HULL_PAIRS");
	return text ? std::atoi(text) : 2000;
}

TEST(HullDistance, AgreesWithExactArithmetic)
{
	Random random(1);
	double worst = 0, widest = 0;
	int overlapping = 0, mostIterations = 0;
	const int pairs = pairCount();
	for (int i = 0; i < pairs; ++i)
	{
		const Pair pair = makePair(random);
		const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
		const HullDistance ours = hullDistance(pair.a.hull(), pair.b.hull(), pose, -pair.aFromB.translation, 1e300);
		const Verdict verdict = judge(pair, pose, ours);
		EXPECT_LE(verdict.error, 2e-5) << "pair " << i;
		EXPECT_LE(verdict.width, kHullDistanceAccuracy)
			<< "pair " << i << " upper " << ours.upper << " n " << ours.iterations;
		EXPECT_TRUE(verdict.bracketHolds) << "pair " << i;
		EXPECT_TRUE(verdict.signRight) << "pair " << i;
		worst = std::max(worst, verdict.error);
		widest = std::max(widest, verdict.width);
		overlapping += verdict.overlapping;
		mostIterations = std::max(mostIterations, ours.iterations);
	}
	EXPECT_GT(overlapping, pairs / 8);
	EXPECT_LT(overlapping, pairs * 7 / 8);
	std::printf("worst error %.2g, widest bracket %.2g of the size; %d of %d overlap; at most %d iterations\n", worst,
				widest, overlapping, pairs, mostIterations);
}

TEST(HullDistance, TheOracleSeesPlantedFaults)
{
	Random random(2);
	int missed = 0, wrongSign = 0, loose = 0, tried = 0;
	for (int i = 0; i < 200; ++i)
	{
		const Pair pair = makePair(random);
		const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
		HullDistance ours = hullDistance(pair.a.hull(), pair.b.hull(), pose, -pair.aFromB.translation, 1e300);
		if (ours.overlap || ours.upper < 1e-3 * pair.a.radius()) continue;
		++tried;
		HullDistance fault = ours;
		fault.upper = 1.001 * ours.upper;
		missed += judge(pair, pose, fault).error < 1e-9;
		fault.upper = fault.lower = 0;
		fault.overlap = true;
		wrongSign += judge(pair, pose, fault).signRight;
		fault = ours;
		fault.lower = 1.0001 * ours.upper;
		loose += judge(pair, pose, fault).bracketHolds;
	}
	EXPECT_GT(tried, 50);
	EXPECT_EQ(missed + wrongSign + loose, 0);
}

TEST(HullDistance, StopsEarlyOnlyWithProof)
{
	Random random(3);
	for (int i = 0; i < 2000; ++i)
	{
		const Pair pair = makePair(random);
		const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
		const Vec3 start = -pair.aFromB.translation;
		const HullDistance full = hullDistance(pair.a.hull(), pair.b.hull(), pose, start, 1e300);
		const double limit = uniform(random, 0, 2) * full.upper;
		const HullDistance stopped = hullDistance(pair.a.hull(), pair.b.hull(), pose, start, limit);
		EXPECT_EQ(stopped.lower > limit, full.lower > limit);
		EXPECT_LE(stopped.lower, full.upper);
		EXPECT_LE(separationAlong(pair.a.hull(), pair.b.hull(), pose, direction(random)), full.upper);
		EXPECT_TRUE(full.lower > limit || stopped.upper == full.upper);
	}
}

TEST(HullDistance, ScalesExactlyByPowersOfTwo)
{
	Random random(4);
	for (int i = 0; i < 500; ++i)
	{
		Pair pair = makePair(random);
		const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
		const Vec3 start = -pair.aFromB.translation;
		const HullDistance one = hullDistance(pair.a.hull(), pair.b.hull(), pose, start, 1e300);
		for (HullData* data : {&pair.a, &pair.b})
		{
			for (auto* axis : {&data->x, &data->y, &data->z})
				for (float& value : *axis) value *= 1024;
			data->sweep = 1024 * data->sweep;
		}
		pair.aFromB.translation = 1024 * pair.aFromB.translation;
		const RelativePose larger(pair.aFromB, 1024 * std::max(pair.a.radius(), pair.b.radius()) / 1024);
		const HullDistance two = hullDistance(pair.a.hull(), pair.b.hull(), larger, 1024 * start, 1e300);
		EXPECT_EQ(1024 * one.lower, two.lower);
		EXPECT_EQ(1024 * one.upper, two.upper);
		EXPECT_EQ(one.iterations, two.iterations);
	}
}

bool sameBits(const HullDistance& l, const HullDistance& r)
{
	return l.lower == r.lower && l.upper == r.upper && l.pointOnA == r.pointOnA && l.pointOnB == r.pointOnB &&
		   l.normal == r.normal && l.overlap == r.overlap && l.iterations == r.iterations;
}

TEST(HullDistance, IsTheSameOnAnyMachine)
{
	Random random(5);
	for (int i = 0; i < 5000; ++i)
	{
		const Pair pair = makePair(random);
		const RelativePose pose(pair.aFromB, std::max(pair.a.radius(), pair.b.radius()));
		const Vec3 start = -pair.aFromB.translation, move = i % 3 ? Vec3{} : 0.1 * length(start) * direction(random);
		const HullDistance chosen = hullDistance(pair.a.hull(), pair.b.hull(), pose, start, 1e300, move);
		const HullDistance plain = hullDistancePlain(pair.a.hull(), pair.b.hull(), pose, start, 1e300, move);
		ASSERT_TRUE(sameBits(chosen, plain)) << "pair " << i;
	}
}

// What a witness is made of bounds the distance at any pose, and is the distance where it was found.
TEST(HullDistance, CornersOfAWitnessBoundItAtAnyPose)
{
	Random random(11);
	int known = 0;
	for (int i = 0; i < 4000; ++i)
	{
		const Pair pair = makePair(random);
		const ConvexHull a = pair.a.hull(), b = pair.b.hull();
		const double radius = std::max(pair.a.radius(), pair.b.radius()), size = radius + length(pair.aFromB.translation);
		const RelativePose pose(pair.aFromB, radius);
		const Vec3 start = -pair.aFromB.translation, way = direction(random);
		const Vec3 move = i % 2 ? uniform(random, 0, 0.2) * size * way : Vec3{};
		const HullDistance found = hullDistance(a, b, pose, start, 1e300, move);
		if (found.corners.count() == 0) continue;
		++known;
		EXPECT_NEAR(length(betweenCorners(a, b, pose, found.corners, move)), found.upper, 1e-9 * size);
		Transform other{rotation(random) * pair.aFromB.rotation, pair.aFromB.translation};
		const Vec3 aside = direction(random);
		other.translation += uniform(random, 0, 1) * size * aside;
		const RelativePose there(other, radius);
		const double least = hullDistance(a, b, there, start, 1e300, move).lower;
		EXPECT_GE(length(betweenCorners(a, b, there, found.corners, move)) + there.rounding, least);
	}
	EXPECT_GT(known, 3000);
}

// A corner that slides under a face is as near as before, though the two points that were nearest are not.
TEST(HullDistance, CornersOfAWitnessStayNearWhereHullsSlide)
{
	HullData floor, box;
	for (const Vec3& p : {Vec3{-0.3, 0, -0.2}, Vec3{0.4, 0, -0.1}, Vec3{0.1, 0, 0.5}}) floor.add(p);
	for (int i = 0; i < 8; ++i) box.add({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
	floor.finish();
	box.finish();
	const double apart = 0.015625;
	const ConvexHull a = floor.hull(), b = box.hull();
	const auto poseAt = [&](double x, double z) { return RelativePose(Transform{Mat3{}, {x, 1 + apart, z}}, 2); };
	const HullDistance found = hullDistance(a, b, poseAt(0.1, 0), {0, -1, 0}, 1e300);
	EXPECT_NEAR(found.upper, apart, 1e-12);
	ASSERT_GT(found.corners.count(), 0);
	EXPECT_NEAR(length(betweenCorners(a, b, poseAt(0.2, 0.1), found.corners)), apart, 1e-12);
	EXPECT_GT(length(betweenCorners(a, b, poseAt(2.1, 0.1), found.corners)), apart);
}

// The corner that a loop over all of them finds farthest along a direction, in the order of the vertices.
double farthest(const HullData& data, const Vec3& along)
{
	double best = -1e300;
	for (std::uint32_t i = 0; i < data.count; ++i) best = std::max(best, dot(data.hull().vertices.vertex(i), along));
	return best;
}
TEST(HullDistance, SeparationIsThatOfALoopOverAllVertices)
{
	Random random(6);
	for (int i = 0; i < 20000; ++i)
	{
		HullData a = makeHull(random, Family(random() % int(Family::kCount)), 1);
		HullData b = makeHull(random, Family(random() % int(Family::kCount)), 1);
		a.sweep = b.sweep = Vec3{};
		const RelativePose pose(Transform{}, std::max(a.radius(), b.radius()));
		const Vec3 along = random() % 8 ? direction(random) : Vec3{0, 0, random() % 2 ? 1. : -1.};
		const double expected = -farthest(a, -along) - farthest(b, along);
		ASSERT_NEAR(separationAlong(a.hull(), b.hull(), pose, along), expected, 2 * pose.rounding) << "pair " << i;
	}
}
}  // namespace
