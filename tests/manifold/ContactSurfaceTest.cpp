// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh is to contacts: polygons, edges and corners of solids whose features are known, sheets and half spaces.
#include <gtest/gtest.h>

#include <cmath>

#include "clod/collide/Triangle.h"
#include "clod/hierarchy/InputSurface.h"
#include "clod/manifold/ContactSurface.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
namespace
{
std::size_t corners(const ContactSurface& surface)
{
	std::size_t count = 0;
	for (std::uint32_t v = 0; v < surface.vertices().size(); ++v) count += surface.isCorner(v) ? 1 : 0;
	return count;
}

// A flat grid of cells in the plane z = 0; every second triangle is wound the other way round if asked.
std::vector<Triangle> grid(int cells, bool isMixed)
{
	std::vector<Triangle> triangles;
	for (int i = 0; i < cells; ++i)
		for (int j = 0; j < cells; ++j)
		{
			const Vec3 a{double(i), double(j), 0}, x{1, 0, 0}, y{0, 1, 0};
			triangles.push_back({a, a + x, a + x + y});
			triangles.push_back(isMixed ? Triangle{a, a + y, a + x + y} : Triangle{a, a + x + y, a + y});
		}
	return triangles;
}
}  // namespace

TEST(ContactSurface, OfACubeHasItsFeaturesHoweverItIsCut)
{
	for (const int cells : {1, 2, 5})
		for (const int patches : {1, 2})
		{
			const auto cube = patchHierarchy(boxMesh({2, 2, 2}, {cells, cells, cells}, patches));
			const ContactSurface surface(*cube, 0);
			EXPECT_EQ(corners(surface), 8u) << cells;
			ASSERT_EQ(surface.edges().size(), 12u) << cells;
			for (const SurfaceEdge& edge : surface.edges())
			{
				EXPECT_NEAR(edge.length, 2, 1e-6);
				EXPECT_NEAR(dot(edge.normal[0], edge.normal[1]), 0, 1e-6);
			}
			std::uint32_t polygons = 0;
			for (const SurfaceFace& face : surface.faces()) polygons = std::max(polygons, face.polygon + 1);
			EXPECT_EQ(polygons, 6u) << cells;
		}
}

TEST(ContactSurface, ReflexEdgesAndFlatVerticesAreNoFeatures)
{
	const auto torus = body("torus", 900).hierarchy;
	const ContactSurface ring(*torus, 0);
	for (const SurfaceEdge& edge : ring.edges()) EXPECT_LT(dot(edge.normal[0], edge.inward[1]), 0);
	const auto box = patchHierarchy(boxMesh({2, 1, 1}, {2, 1, 1}, 1));
	EXPECT_EQ(corners(ContactSurface(*box, 0)), 8u);
}

TEST(ContactSurface, KnowsInsideFromOutside)
{
	const auto torus = body("torus", 900).hierarchy;
	const ContactSurface surface(*torus, 0);
	Random random(5);
	int inside = 0;
	const double radius = double(torus->asset().radius);
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 p{uniform(random, -radius, radius), uniform(random, -radius, radius), uniform(random, -radius, radius)};
		std::uint32_t visited = 0;
		const SignedDistance truth = distanceToInput(*torus, p, visited);
		const ContactSurface::Nearest near = surface.nearest(p, 10 * radius);
		EXPECT_NEAR(near.distance, truth.distance, 1e-6 * radius);
		EXPECT_EQ(surface.isInside(p), truth.distance < 0);
		inside += truth.distance < 0;
	}
	EXPECT_GT(inside, 50);
}

TEST(ContactSurface, APointBesideAPolygonKnowsHowFar)
{
	const auto cube = patchHierarchy(boxMesh({2, 2, 2}, {4, 4, 4}, 1));
	const ContactSurface surface(*cube, 0);
	Random random(6);
	for (int i = 0; i < 500; ++i)
	{
		const Vec3 p{uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -3, 3)};
		for (std::uint32_t polygon = 0; polygon < 6; ++polygon)
		{
			const Vec3 n = surface.planeOf(polygon).normal;
			double expected = 0;
			for (int k = 0; k < 3; ++k)
				if (std::abs(n[k]) < 0.5) expected += std::pow(std::max(0.0, std::abs(p[k]) - 1), 2);
			EXPECT_NEAR(surface.squaredBeside(polygon, p), expected, 1e-6);
		}
	}
}

// A flat ring of many sides, inside and outside: against all of its triangles, one by one.
TEST(ContactSurface, APointBesideAPolygonOfManySidesKnowsHowFar)
{
	constexpr int kParts = 60;
	std::vector<Triangle> ring;
	const auto at = [](double radius, int part) -> Vec3
	{
		const double angle = 2 * std::acos(-1) * (part % kParts) / kParts;
		return {radius * std::cos(angle), radius * std::sin(angle), 0};
	};
	for (int i = 0; i < kParts; ++i)
	{
		ring.push_back({at(0.5, i), at(1, i), at(1, i + 1)});
		ring.push_back({at(0.5, i), at(1, i + 1), at(0.5, i + 1)});
	}
	const ContactSurface surface(ring, 1);
	ASSERT_EQ(surface.polygonCount(), 2u);
	Random random(8);
	int over = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 foot{uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), 0};
		double expected = 10;
		for (const Triangle& triangle : ring) expected = std::min(expected, nearestOnTriangle(triangle, foot).squared);
		const Vec3 point = foot + Vec3{0, 0, uniform(random, -1, 1)};
		const double slack = uniform(random, 0, 0.4);
		EXPECT_NEAR(surface.squaredBeside(0, point), expected, 1e-12);
		EXPECT_EQ(surface.isOver(0, point, slack), expected <= slack * slack) << foot.x << " " << foot.y;
		over += expected <= slack * slack ? 1 : 0;
	}
	EXPECT_GT(over, 500);
	EXPECT_LT(over, 1500);
}

// Its border counts, not how it is cut into triangles.
TEST(ContactSurface, APolygonHoldsTheDiscsThatItsBorderLeaves)
{
	for (const int cells : {1, 4})
	{
		const ContactSurface surface(*patchHierarchy(boxMesh({2, 2, 2}, {cells, cells, cells}, 1)), 0);
		const std::uint32_t top = surface.polygonIn({0, 0, 1}, {0, 0, 1}, 1);
		ASSERT_NE(top, kNone);
		Random random(7);
		for (int i = 0; i < 200; ++i)
		{
			const Vec3 p{uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2), 1.3};
			const double free = 1 - std::max(std::abs(p.x), std::abs(p.y)), radius = uniform(random, 0.01, 1);
			if (std::abs(free - radius) < 1e-6) continue;
			EXPECT_EQ(surface.isAround(top, p, radius), free > radius) << p.x << " " << p.y;
		}
	}
}

TEST(ContactSurface, ASheetHasTwoSidesAndNoSeams)
{
	for (const bool isMixed : {false, true})
	{
		const ContactSurface sheet(grid(4, isMixed), 1);
		EXPECT_EQ(corners(sheet), 4u);        // of the border only
		EXPECT_EQ(sheet.edges().size(), 4u);  // likewise, whole sides
		for (const SurfaceEdge& edge : sheet.edges()) EXPECT_NEAR(edge.length, 4, 1e-9);
		EXPECT_FALSE(sheet.isInside({2, 2, 0}));
		EXPECT_FALSE(sheet.isClosed());
	}
	// Folded like a roof: the ridge is an edge of one side, the valley of none.
	const std::vector<Triangle> roof = {{Vec3{0, 0, 1}, {1, 0, 0}, {0, 1, 1}}, {Vec3{1, 0, 0}, {1, 1, 0}, {0, 1, 1}},
										{Vec3{0, 0, 1}, {0, 1, 1}, {-1, 0, 0}}, {Vec3{-1, 0, 0}, {0, 1, 1}, {-1, 1, 0}}};
	const ContactSurface folded(roof, 1);
	int ridges = 0;
	for (const SurfaceEdge& edge : folded.edges())
		ridges += std::abs(dot(edge.normal[0], edge.normal[1])) < 0.5 ? 1 : 0;
	EXPECT_EQ(ridges, 1);
}

TEST(ContactSurface, AHalfSpaceIsOneFaceWithoutEnd)
{
	const Vec3 normal = normalized(Vec3{1, 2, -3});
	const ContactSurface space(normal, 0.7, {5, 5, 5}, 2);
	EXPECT_TRUE(space.isInside(0.6 * normal));
	EXPECT_FALSE(space.isInside(0.8 * normal + cross(normal, {40, 0, 3})));
	EXPECT_LT(space.squaredBeside(0, Vec3{100, -200, 30}), 1e-12);
	EXPECT_EQ(corners(space), 0u);
}

// Of a polygon of few triangles or many, one by one or through the tree: what looking at all of them says.
// Of faces that lie in one plane but for rounding, and of those the one that is largest says how it lies.
TEST(ContactSurface, APolygonIsOnePlane)
{
	for (const char* name : {"cup-3000", "plate", "number8-600"})
	{
		const ContactSurface& surface = body(name).hierarchy->derived<ContactSurfaces>().level(0);
		std::size_t several = 0;
		for (std::uint32_t polygon = 0; polygon < surface.polygonCount(); ++polygon)
			for (const std::uint32_t face : surface.facesOf(polygon))
			{
				EXPECT_EQ(surface.faces()[face].normal, surface.planeOf(polygon).normal) << name;
				EXPECT_EQ(surface.faces()[face].offset, surface.planeOf(polygon).offset) << name;
				several += face != surface.facesOf(polygon)[0];
			}
		EXPECT_GT(several, 5u) << name;
	}
}

TEST(ContactSurface, TheNearestTriangleOfAPolygonIsFoundAmongMany)
{
	Random random(9);
	for (const int cells : {2, 30})
	{
		const auto box = patchHierarchy(boxMesh({20, 1, 20}, {cells, 1, cells}, 2));
		const ContactSurface& surface = box->derived<ContactSurfaces>().level(0);
		for (int i = 0; i < 300; ++i)
		{
			const std::uint32_t polygon = surface.faces()[random() % surface.faces().size()].polygon;
			const Vec3 point{uniform(random, -11, 11), uniform(random, -1, 1), uniform(random, -11, 11)};
			double best = std::numeric_limits<double>::infinity();
			std::uint32_t expected = kNone;
			for (std::uint32_t f = 0; f < surface.faces().size(); ++f)
			{
				const SurfaceFace& face = surface.faces()[f];
				if (face.polygon != polygon) continue;
				const Triangle t{surface.vertices()[face.vertex[0]], surface.vertices()[face.vertex[1]],
								 surface.vertices()[face.vertex[2]]};
				const double squared = nearestOnTriangle(t, point).squared;
				if (squared >= best) continue;
				best = squared;
				expected = f;
			}
			EXPECT_EQ(surface.nearestFaceOf(polygon, point), expected) << cells;
		}
	}
}
}  // namespace clod::test
