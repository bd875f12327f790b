// SPDX-License-Identifier: GPL-3.0-or-later
// The geometric pieces of the builder against exact arithmetic or brute force.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polyhedron_3.h>
#include <CGAL/convex_hull_3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "builder/patches/BoxTree.h"
#include "builder/patches/Clip.h"
#include "builder/patches/HalfSpaceProgram.h"
#include "builder/patches/Hinge.h"
#include "builder/patches/Quadric.h"
#include "builder/patches/Remainder.h"
#include "builder/patches/SmallHull.h"

namespace clod::builder
{
namespace
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

struct Random
{
	std::mt19937 engine{7};
	double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
	Vec3 point(double size = 1) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
	// On a coarse grid, so that coplanar and collinear sets are common.
	Vec3 gridPoint(int cells)
	{
		std::uniform_int_distribution<int> cell(0, cells);
		return roundedToFloat(0.1 * Vec3{double(cell(engine)), double(cell(engine)), double(cell(engine))});
	}
};

Kernel::Point_3 exact(const Vec3& p)
{
	return {p.x, p.y, p.z};
}

TEST(Orientation, AgreesWithExactArithmetic)
{
	Random random;
	int zeros = 0;
	for (int i = 0; i < 20000; ++i)
	{
		Vec3 p[4];
		for (Vec3& q : p) q = i % 2 ? random.gridPoint(3) : roundedToFloat(random.point());
		if (i % 4 == 0) p[3] = roundedToFloat(p[0] + random(0, 1) * (p[1] - p[0]) + random(0, 1) * (p[2] - p[0]));
		const int expected = int(CGAL::orientation(exact(p[0]), exact(p[1]), exact(p[2]), exact(p[3])));
		ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), expected) << i;
		zeros += expected == 0;
	}
	EXPECT_GT(zeros, 1000);
}

TEST(Orientation, SeesTheLastBit)
{
	const double step = std::ldexp(1.0, -40);
	EXPECT_EQ(orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e3, 1e3, step}), 1);
	EXPECT_EQ(orientation({0, 0, 1e3}, {1, 0, 1e3}, {0, 1, 1e3}, {1e3, 1e3, 1e3}), 0);
}

// Compilers have optimised the rounding away.
TEST(Orientation, RoundingToFloatReallyRounds)
{
	Random random;
	for (int i = 0; i < 100; ++i)
	{
		const Vec3 p = roundedToFloat(random.point() + random.point());
		for (int k = 0; k < 3; ++k)
		{
			const volatile float stored = float(p[k]);
			ASSERT_EQ(p[k], double(stored));
		}
	}
}

double volumeOf(const SmallHull& hull)
{
	double volume = 0;
	for (const auto& t : hull.triangles())
		volume += dot(hull.points()[t[0]], cross(hull.points()[t[1]], hull.points()[t[2]])) / 6;
	return volume;
}

TEST(SmallHull, EqualsTheExactHull)
{
	Random random;
	for (int round = 0; round < 400; ++round)
	{
		SmallHull hull;
		std::vector<Kernel::Point_3> points;
		const int count = 4 + round % 60;
		for (int i = 0; i < count; ++i)
		{
			const Vec3 p = round % 2 ? random.gridPoint(3) : roundedToFloat(random.point());
			hull.add(p);
			points.push_back(exact(p));
		}
		if (hull.isFlat()) continue;
		for (const auto& t : hull.triangles())
			for (const Vec3& p : hull.points())
				ASSERT_LE(orientation(hull.points()[t[0]], hull.points()[t[1]], hull.points()[t[2]], p), 0);
		CGAL::Polyhedron_3<Kernel> expected;
		CGAL::convex_hull_3(points.begin(), points.end(), expected);
		double volume = 0;
		for (auto f = expected.facets_begin(); f != expected.facets_end(); ++f)
		{
			auto h = f->facet_begin();
			const auto a = h++->vertex()->point();
			for (auto b = h++; h != f->facet_begin(); b = h++)
				volume += CGAL::to_double(
					CGAL::volume(Kernel::Point_3(0, 0, 0), a, b->vertex()->point(), h->vertex()->point()));
		}
		ASSERT_NEAR(volumeOf(hull), volume, 1e-12) << round;
	}
}

TEST(SmallHull, FlatSetsHaveNoTriangles)
{
	SmallHull hull;
	for (int i = 0; i < 5; ++i)
		for (int j = 0; j < 5; ++j) hull.add(roundedToFloat({0.1 * i, 0.1 * j, 0.3}));
	EXPECT_TRUE(hull.isFlat());
	hull.add({0, 0, 0.5});
	EXPECT_FALSE(hull.isFlat());
	EXPECT_NEAR(volumeOf(hull), 0.16 * 0.2 / 3, 1e-7);
}

// Whether a dense sample of the triangle has a point below all planes.
bool sampledInside(const TrianglePoints& t, const std::vector<Plane>& planes, double depth)
{
	const int n = 200;
	for (int i = 0; i <= n; ++i)
		for (int j = 0; i + j <= n; ++j)
		{
			const Vec3 p = t[0] + (double(i) / n) * (t[1] - t[0]) + (double(j) / n) * (t[2] - t[0]);
			bool inside = true;
			for (const Plane& plane : planes) inside = inside && plane.height(p) < -depth;
			if (inside) return true;
		}
	return false;
}

TEST(Clip, EntersHullAgreesWithSamples)
{
	Random random;
	int entering = 0;
	for (int round = 0; round < 300; ++round)
	{
		SmallHull hull;
		for (int i = 0; i < 12; ++i) hull.add(random.point());
		std::vector<Plane> planes;
		hull.planes(1e-9, planes);
		const TrianglePoints t = {random.point(2), random.point(2), random.point(2)};
		const bool sampled = sampledInside(t, planes, 0.05);
		ASSERT_TRUE(!sampled || entersHull(t, planes, 0.05));
		ASSERT_TRUE(sampled || !entersHull(t, planes, 0.08)) << round;  // room for what falls between samples
		entering += sampled;
	}
	EXPECT_GT(entering, 50);
	EXPECT_LT(entering, 250);
}

TEST(Clip, TrianglesCross)
{
	const TrianglePoints floor = {Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
	EXPECT_TRUE(trianglesCross(floor, {Vec3{0.2, 0.2, -1}, {0.3, 0.2, 1}, {0.2, 0.3, 1}}));
	EXPECT_FALSE(trianglesCross(floor, {Vec3{0.2, 0.2, 0.1}, {0.3, 0.2, 1}, {0.2, 0.3, 1}}));
	EXPECT_FALSE(trianglesCross(floor, {Vec3{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}));  // a shared edge
	EXPECT_FALSE(trianglesCross(floor, {Vec3{0, 0, 0.1}, {1, 0, 0.1}, {0, 1, 0.1}}));
}

TEST(Clip, SquaredDistanceAgreesWithSamples)
{
	Random random;
	for (int round = 0; round < 500; ++round)
	{
		const TrianglePoints t = {random.point(), random.point(), random.point()};
		const Vec3 p = random.point(2);
		double nearest = 1e300;
		const int n = 100;
		for (int i = 0; i <= n; ++i)
			for (int j = 0; i + j <= n; ++j)
				nearest = std::min(
					nearest, length(p - t[0] - (double(i) / n) * (t[1] - t[0]) - (double(j) / n) * (t[2] - t[0])));
		const double d = std::sqrt(squaredDistance(p, t));
		ASSERT_LE(d, nearest + 1e-12);
		ASSERT_GE(d, nearest - 0.03);
	}
}

TEST(Clip, PlanarHullAndClip)
{
	const std::vector<Point2> square = convexHull({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0.5, 0}, {1, 0.5}});
	ASSERT_EQ(square.size(), 4u);
	EXPECT_DOUBLE_EQ(areaOf(square), 1);
	EXPECT_DOUBLE_EQ(perimeterOf(square), 4);
	EXPECT_NEAR(areaOf(clipped({{0.5, 0.5}, {2, 0.5}, {0.5, 2}}, square)), 0.25, 1e-15);
	EXPECT_TRUE(clipped({{2, 2}, {3, 2}, {2, 3}}, square).size() < 3);
}

// All active sets of up to three rows: the nearest feasible projection.
std::optional<Vec3> bruteForce(const Vec3& target, const std::vector<Plane>& rows, double tolerance)
{
	std::optional<Vec3> best;
	const auto offer = [&](const Vec3& x)
	{
		for (const Plane& row : rows)
			if (dot(row.normal, x) < row.offset - tolerance) return;
		if (!best || lengthSquared(x - target) < lengthSquared(*best - target)) best = x;
	};
	offer(target);
	for (std::size_t i = 0; i < rows.size(); ++i)
	{
		const Plane& a = rows[i];
		offer(target + (a.offset - dot(a.normal, target)) * a.normal);
		for (std::size_t j = 0; j < i; ++j)
		{
			const Plane& b = rows[j];
			const Vec3 line = cross(a.normal, b.normal);
			const double s = lengthSquared(line);
			if (s < 1e-16) continue;
			const double ra = a.offset - dot(a.normal, target), rb = b.offset - dot(b.normal, target);
			const double c = dot(a.normal, b.normal);
			offer(target + ((ra - c * rb) / s) * a.normal + ((rb - c * ra) / s) * b.normal);
			for (std::size_t k = 0; k < j; ++k)
			{
				const Plane& d = rows[k];
				const double volume = dot(line, d.normal);
				if (std::fabs(volume) < 1e-9) continue;
				offer((1 / volume) *
					  (a.offset * cross(b.normal, d.normal) + b.offset * cross(d.normal, a.normal) + d.offset * line));
			}
		}
	}
	return best;
}

TEST(HalfSpaceProgram, AgreesWithAllActiveSets)
{
	Random random;
	int feasible = 0;
	for (int round = 0; round < 4000; ++round)
	{
		std::vector<Plane> rows;
		const int count = 4 + round % 16;
		for (int i = 0; i < count; ++i) rows.push_back({normalized(random.point()), random(-1, 0.3)});
		const Vec3 target = random.point(2);
		const auto expected = bruteForce(target, rows, 1e-9);
		const auto found = nearestInside(target, rows, 1e-9, 1);
		ASSERT_EQ(bool(found), bool(expected)) << round;
		if (!found) continue;
		++feasible;
		for (const Plane& row : rows) ASSERT_GE(dot(row.normal, *found), row.offset - 2e-9);
		ASSERT_NEAR(length(*found - target), length(*expected - target), 1e-7);
		const auto other = nearestInside(target, rows, 1e-9, 99);
		ASSERT_TRUE(other);
		ASSERT_LT(length(*other - *found), 1e-5);
	}
	EXPECT_GT(feasible, 1000);
	EXPECT_LT(feasible, 3900);
}

TEST(Hinge, SumsToZeroAndVanishesOnLinearFunctions)
{
	Random random;
	for (int round = 0; round < 10000; ++round)
	{
		// Unfolded in a plane: the two far corners lie on opposite sides of the edge.
		const Vec3 j{0, 0, 0}, k{random(0.5, 2), 0, 0}, l1{random(-1, 2), random(0.2, 1), 0},
			l2{random(-1, 2), random(-1, -0.2), 0};
		const auto c = hingeWeights(j, k, l1, l2, 1e-9);
		ASSERT_TRUE(c);
		ASSERT_NEAR(c->l1 + c->l2 + c->j + c->k, 0, 1e-12);
		ASSERT_LT(length(c->l1 * l1 + c->l2 * l2 + c->j * j + c->k * k), 1e-12);
	}
	EXPECT_FALSE(hingeWeights({}, {1, 0, 0}, {0.5, 0, 0}, {0.5, 1, 0}, 1e-9));
}

TEST(Hinge, AFlatStarStaysFlat)
{
	Random random;
	Star star;
	for (int i = 0; i < 6; ++i)
	{
		const double a = i * 1.0471975511965976;
		star.ring.push_back({std::cos(a), std::sin(a), 0});
		star.beyond.push_back({1.8 * std::cos(a + 0.52), 1.8 * std::sin(a + 0.52), 0});
	}
	const Vec3 moved = filteredPosition({0.1, 0.2, 0}, star, 1e-9);
	EXPECT_EQ(moved.z, 0);
	EXPECT_LT(length(filteredPosition({0, 0, 0.5}, star, 1e-9)), 0.05);  // the spike is filtered away
}

TEST(Quadric, FindsTheCornerOfThreePlanesAndStaysPutOnOne)
{
	Quadric corner, plane;
	corner.addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
	corner.addTriangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
	corner.addTriangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0});
	EXPECT_LT(length(corner.minimiser({0.3, 0.2, 0.1})), 1e-12);
	EXPECT_NEAR(corner.at({1, 2, 3}), 0.5 * (1 + 4 + 9), 1e-12);
	plane.addTriangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
	EXPECT_LT(length(plane.minimiser({0.3, 0.2, 0.1}) - Vec3{0.3, 0.2, 1}), 1e-12);
}

// Expected value over the eight normals a standard deviation off in every component: exact, as it is a quadratic.
TEST(Quadric, UncertainNormalsGiveTheExpectedError)
{
	const Vec3 a{0.2, 1, 3}, b{1.5, 0.7, 2}, c{0.4, -1, 2.5}, x{0.3, 0.9, -0.4};
	const Vec3 scaled = cross(b - a, c - a), normal = normalized(scaled), middle = (1.0 / 3) * (a + b + c);
	const double area = 0.5 * length(scaled), deviation = 0.1;
	double expected = 0;
	for (int i = 0; i < 8; ++i)
	{
		const Vec3 off{i & 1 ? deviation : -deviation, i & 2 ? deviation : -deviation, i & 4 ? deviation : -deviation};
		const double distance = dot(normal + off, x - middle);
		expected += area / 8 * distance * distance;
	}
	Quadric uncertain, certain;
	uncertain.addTriangle(a, b, c, deviation * deviation);
	certain.addTriangle(a, b, c);
	EXPECT_NEAR(uncertain.at(x), expected, 1e-12 * expected);
	EXPECT_LT(certain.at(x), 0.99 * expected);
	EXPECT_LT(length(uncertain.minimiser(x) - middle), 1e-12);
}

TEST(BoxTree, FindsWhatBruteForceFindsAfterUpdates)
{
	Random random;
	std::vector<Box> boxes(500);
	const auto randomBox = [&]
	{
		Box box;
		const Vec3 centre = random.point(10);
		box.include(centre);
		box.include(centre + random.point());
		return box;
	};
	for (Box& box : boxes) box = randomBox();
	BoxTree tree;
	tree.build(boxes);
	for (int round = 0; round < 500; ++round)
	{
		const std::size_t changed = std::size_t(round * 7 % 500);
		boxes[changed] = round % 3 ? randomBox() : Box{};
		tree.update(std::uint32_t(changed), boxes[changed]);
		const Box query = randomBox().grownBy(1);
		std::vector<char> found(boxes.size(), 0);
		tree.search(query, [&](std::uint32_t i) { return found[i] = 1; });
		for (std::size_t i = 0; i < boxes.size(); ++i)
			ASSERT_EQ(bool(found[i]), !boxes[i].isEmpty() && boxes[i].meets(query)) << round;
	}
}

// Whatever overlaps what, and however it is wound: as long as pieces meet at right angles areas are exact.
TEST(Remainder, IsWhatNoneOfThePolygonsTakes)
{
	const auto box = [](double x, double y, double width, double height)
	{ return std::vector<Point2>{{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}}; };
	Remainder remainder(box(0, 0, 4, 4), 0, 0);
	EXPECT_EQ(remainder.openArea(), 16);
	remainder.take(box(1, 1, 2, 2));
	EXPECT_EQ(remainder.openArea(), 12);
	std::vector<Point2> other = box(2, 0, 1, 4);
	std::reverse(other.begin(), other.end());
	remainder.take(other);
	EXPECT_EQ(remainder.openArea(), 10) << "two of its four are gone already";
	remainder.take(box(5, 5, 1, 1));
	EXPECT_EQ(remainder.openArea(), 10);
	remainder.count(box(0, 0, 1, 1), 1);
	EXPECT_EQ(remainder.openArea(), 9) << "inside";
	remainder.count(box(0, 0, 1, 4), -1);
	EXPECT_EQ(remainder.openArea(), 10) << "out again";
	EXPECT_EQ(Remainder(box(0, 0, 4, 4), 0.5, 0).openArea(), 9) << "but for a border";
}
}  // namespace
}  // namespace clod::builder
