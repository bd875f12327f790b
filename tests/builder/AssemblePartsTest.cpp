// SPDX-License-Identifier: GPL-3.0-or-later
// What a hierarchy is assembled of, each against closed forms or samples: mass, spheres, distances, areas, protrusions,
// walls, covers.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "builder/assemble/BoundingSphere.h"
#include "builder/assemble/Certify.h"
#include "builder/assemble/ContactArea.h"
#include "builder/assemble/ConvexDistance.h"
#include "builder/assemble/MassProperties.h"
#include "builder/assemble/NearestPatches.h"
#include "builder/assemble/Protrusion.h"
#include "builder/assemble/Walls.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
using namespace clod::builder;
const double kPi = std::acos(-1.0);

TEST(AssembleMass, BoxAndTorusMatchClosedForms)
{
	const MassProperties box = massProperties(boxMesh({1, 2, 3}, 2));
	EXPECT_NEAR(box.volume, 48, 1e-12);
	EXPECT_NEAR(box.inertia[0], 48.0 / 3 * (4 + 9), 1e-10);
	EXPECT_NEAR(box.moments[0], 48.0 / 3 * (1 + 4), 1e-10);
	EXPECT_NEAR(length(box.center), 0, 1e-12);
	const MassProperties ring = massProperties(torusMesh(1, 0.25, 400, 200));
	const double volume = 2 * kPi * kPi * 0.0625;
	EXPECT_NEAR(ring.volume / volume, 1, 5e-4);
	EXPECT_NEAR(ring.inertia[1] / (volume * (1 + 0.75 * 0.0625)), 1, 1e-3);
	const Mat3 axes =
		rotationFromQuaternion(ring.principal[0], ring.principal[1], ring.principal[2], ring.principal[3]);
	EXPECT_NEAR(std::fabs(axes.column(2).y), 1, 1e-9);
}

TEST(AssembleSphere, ContainsAllAndIsTightOnABox)
{
	const Sphere s = boundingSphere(boxMesh({1, 2, 3}, 3).vertices);
	EXPECT_NEAR(s.radius, std::sqrt(14.0), 1e-6);
	EXPECT_NEAR(length(s.center), 0, 1e-5);
}

TEST(AssembleSphere, ContainsEveryPointToTheLastBit)
{
	std::mt19937_64 random(1);
	std::uniform_real_distribution<double> where(-1, 1);
	for (int cloud = 0; cloud < 2000; ++cloud)
	{
		std::vector<Vec3> points;
		for (int i = 0; i < 30; ++i)
		{
			const double x = where(random), y = where(random);
			points.push_back(normalized({x, y, where(random)}));
		}
		const Sphere s = boundingSphere(points);
		for (const Vec3& p : points) ASSERT_LE(length(p - s.center), s.radius) << cloud;
	}
}

// From its centre every way leads away from some point of it: there is none smaller (the largest distance is convex).
TEST(AssembleSphere, IsTheSmallest)
{
	std::mt19937_64 random(2);
	std::uniform_real_distribution<double> where(-1, 1);
	const auto drawn = [&]
	{
		const double x = where(random), y = where(random);
		return Vec3{x, y, where(random)};
	};
	for (int cloud = 0; cloud < 200; ++cloud)
	{
		std::vector<Vec3> points;
		for (int i = 0; i < 4 + cloud % 20; ++i) points.push_back(drawn());
		const Sphere s = boundingSphere(points);
		for (int way = 0; way < 100; ++way)
		{
			const Vec3 center = s.center + 1e-3 * normalized(drawn());
			double farthest = 0;
			for (const Vec3& p : points) farthest = std::max(farthest, length(p - center));
			ASSERT_GT(farthest, s.radius * (1 - 1e-6)) << cloud;
		}
	}
}

// What lies in a thin wall goes to the side that is turned its way, though the other is nearer; but not to one more than
// twice as far.
TEST(AssembleNearest, AFaceGoesToThePatchTurnedItsWay)
{
	Lod wall;
	wall.mesh = boxMesh({1, 0.05, 1}, 1);
	wall.patchCount = 3;  // top, bottom, sides
	for (const auto& t : wall.mesh.triangles)
	{
		const auto& at = wall.mesh.vertices;
		const double up = normalized(cross(at[t[1]] - at[t[0]], at[t[2]] - at[t[0]])).y;
		wall.patchOfTriangle.push_back(up > 0.5 ? 0 : up < -0.5 ? 1 : 2);
	}
	const NearestPatches nearest(wall);
	const Lookup top = nearest.at({0.2, -0.01, 0.1}, {0, 1, 0}), bottom = nearest.at({0.2, 0.01, 0.1}, {0, -1, 0});
	EXPECT_EQ(top.patch, 0u);
	EXPECT_NEAR(top.distance, 0.06, 1e-8);  // floats
	EXPECT_EQ(bottom.patch, 1u);
	EXPECT_EQ(nearest.at({0.2, -0.04, 0.1}, {0, 1, 0}).patch, 1u);
	// A patch that no face is nearest to is given a piece at its middle, on its own side.
	Vec3 normal;
	EXPECT_LT(length(nearest.middleOf(0, normal) - Vec3{0, 0.05, 0}), 0.2);  // middles are those of balls round faces
	EXPECT_LT(length(normalized(normal) - Vec3{0, 1, 0}), 1e-6);
}

TEST(AssembleDistance, AgreesWithABoxAndNeverUnderestimates)
{
	const std::vector<Vec3> points = boxMesh({1, 2, 3}, 1).vertices;
	const ConvexSet set{points.data(), points.size(), {}};
	std::mt19937_64 random(1);
	std::uniform_real_distribution<double> where(-6, 6);
	for (int i = 0; i < 20000; ++i)
	{
		const Vec3 p{where(random), where(random), where(random)};
		double exact = 0;
		for (int k = 0; k < 3; ++k) exact += std::pow(std::max(std::fabs(p[k]) - (k + 1), 0.0), 2);
		exact = std::sqrt(exact);
		const double d = distanceBound(p, set);
		ASSERT_GE(d, exact * (1 - 1e-12) - 1e-12);
		ASSERT_LE(d, exact * 1.001 + 1e-9);
	}
}

TEST(AssembleArea, PlaneIsTheCappedDiscAndSphereIsTheCap)
{
	const Mesh slab = boxMesh({1, 0.2, 1}, 40);
	const ContactArea onPlane(slab, 0.01, 0.25);
	const TriangleTree tree(slab);
	const auto top = tree.nearest({0.011, 0.2, 0.007});
	EXPECT_NEAR(onPlane.at(top.triangle, {0, double(0.2f), 0}, {0, 1, 0}) / (kPi * 0.0625), 1, 1e-3);
	const Mesh ball = sphereMesh(1, 200, 100);
	const ContactArea onSphere(ball, 0.01, 0.5);
	const TriangleTree ballTree(ball);
	const Vec3 origin = centroid(ballTree.triangle(10000));
	EXPECT_NEAR(onSphere.at(10000, origin, normalized(origin)) / (2 * kPi * 0.01), 1, 0.05);
}

// Face by face, clipped to the slab alone: the cap of the compared areas is wider than the mesh.
double floodedArea(const Mesh& mesh, std::uint32_t start, const Vec3& origin, const Vec3& normal, double delta)
{
	const auto neighbours = triangleNeighbours(mesh);
	std::vector<bool> seen(mesh.triangles.size(), false);
	std::vector<std::uint32_t> open{start};
	double area = 0;
	seen[start] = true;
	while (!open.empty())
	{
		const std::uint32_t face = open.back();
		open.pop_back();
		std::vector<Vec3> polygon;
		for (const std::uint32_t v : mesh.triangles[face]) polygon.push_back(mesh.vertices[v] - origin);
		for (const double side : {1.0, -1.0})
		{
			std::vector<Vec3> rest;
			for (std::size_t i = 0; i < polygon.size(); ++i)
			{
				const Vec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
				const double a = side * dot(normal, p) - delta, b = side * dot(normal, q) - delta;
				if (a <= 0) rest.push_back(p);
				if ((a <= 0) != (b <= 0)) rest.push_back(p + (a / (a - b)) * (q - p));
			}
			polygon = rest;
		}
		if (polygon.empty()) continue;
		Vec3 sum;
		for (std::size_t i = 2; i < polygon.size(); ++i)
			sum += 0.5 * cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
		area += std::max(0.0, dot(sum, normal));
		for (const std::uint32_t next : neighbours[face])
		{
			const auto& t = mesh.triangles[next];
			const builder::Triangle other{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
			if (seen[next] || dot(normalized(areaVector(other)), normal) <= 0.2) continue;
			seen[next] = true;
			open.push_back(next);
		}
	}
	return std::max(area, 4 * delta * delta);
}

TEST(AssembleArea, ClustersAreMetAsTheirFacesAre)
{
	const Mesh mesh = wrinkledTorusMesh(1, 0.4, 0.05, 12, 192, 96);
	const TriangleTree tree(mesh);
	for (const double delta : {0.02, 0.1, 0.3})
	{
		const ContactArea areas(mesh, delta, 100);
		std::mt19937_64 random(7);
		for (int i = 0; i < 40; ++i)
		{
			const std::uint32_t face = std::uint32_t(random() % mesh.triangles.size());
			const Vec3 origin = centroid(tree.triangle(face)), normal = normalized(areaVector(tree.triangle(face)));
			const double expected = floodedArea(mesh, face, origin, normal, delta);
			ASSERT_NEAR(areas.at(face, origin, normal) / expected, 1, 1e-9) << "face " << face << ", delta " << delta;
		}
	}
}

TEST(AssembleProtrusion, BoxAboveAPlateIsBoundedAndTight)
{
	const Solid plate(boxMesh({4, 1, 4}, 8));
	const ProtrusionScale scale{5, 1e-6, 3000};
	const auto lifted = [&](double height)
	{
		ConvexBody body;
		for (Vec3 v : boxMesh({1, 0.25, 1}, 1).vertices) body.points.push_back(v + Vec3{0.3, 0.75 + height, 0.2});
		body.realNormals = {{0, 1, 0}};
		return protrusion(plate, body, scale);
	};
	for (double height : {0.0, 0.001, 0.05, 0.2})
	{
		const Protrusion p = lifted(height);
		EXPECT_GE(p.upper, height);
		EXPECT_LE(p.upper, std::max(1.3 * height, 3e-4)) << height;
	}
}

// A slab over the mouth of a square pit: the farthest from the solid is the middle of the mouth, which none of the
// slab's corners shows.
TEST(AssembleProtrusion, WhatNoCornerShowsCounts)
{
	Mesh pit;
	for (const double z : {-4.0, 0.0})
		for (const Vec3& v : {Vec3{-3, -3, z}, Vec3{3, -3, z}, Vec3{3, 3, z}, Vec3{-3, 3, z}})
			pit.vertices.push_back(v);
	for (const double z : {-3.0, 0.0})
		for (const Vec3& v : {Vec3{-1, -1, z}, Vec3{1, -1, z}, Vec3{1, 1, z}, Vec3{-1, 1, z}})
			pit.vertices.push_back(v);
	const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d)
	{
		pit.triangles.push_back({a, b, c});
		pit.triangles.push_back({a, c, d});
	};
	quad(0, 3, 2, 1);
	quad(8, 9, 10, 11);
	for (std::uint32_t i = 0; i < 4; ++i)
	{
		const std::uint32_t j = (i + 1) % 4;
		quad(i, j, 4 + j, 4 + i);            // outside
		quad(8 + i, 12 + i, 12 + j, 8 + j);  // the pit's sides
		quad(4 + i, 4 + j, 12 + j, 12 + i);  // the top round it
	}
	const Solid solid(pit);
	for (const double share : {0.0, 0.13, 0.37, 0.61})  // more on one side, into the solid
	{
		ConvexBody body;
		for (const double z : {0.0, -0.05})
			for (const Vec3& v : {Vec3{-1, -1, z}, Vec3{1 + share, -1, z}, Vec3{1 + share, 1, z}, Vec3{-1, 1, z}})
				body.points.push_back(v);
		body.realNormals = {{0, 0, 1}};
		const Protrusion p = protrusion(solid, body, {5, 1e-6, 3000});
		EXPECT_GE(p.upper, 1) << share;
		EXPECT_LE(p.upper, 1.2) << share;
		// Given up early, it is a bound all the same.
		EXPECT_GE(protrusion(solid, body, {5, 1e-6, 3000}, 0.3).upper, 1) << share;
	}
}

// A patch over a wall of 1 and a wall of 0.2: its hull is no thicker than half the thinner one.
TEST(AssembleWalls, TheThinnestWallCounts)
{
	// Along y; x and z of its profile, clockwise from the top left.
	const double profile[7][2] = {{-1, 0}, {0, 0}, {1, 0}, {1, -0.2}, {0, -0.2}, {0, -1}, {-1, -1}};
	Mesh step;
	for (const double y : {-1.0, 1.0})
		for (const auto& p : profile) step.vertices.push_back({p[0], y, p[1]});
	for (std::uint32_t i = 0; i < 7; ++i)
	{
		const std::uint32_t j = (i + 1) % 7;
		step.triangles.push_back({i, j, j + 7});
		step.triangles.push_back({i, j + 7, i + 7});
	}
	for (const std::array<std::uint32_t, 3>& t :
		 {std::array<std::uint32_t, 3>{6, 5, 4}, {6, 4, 0}, {0, 4, 1}, {1, 4, 3}, {1, 3, 2}})
	{
		step.triangles.push_back(t);
		step.triangles.push_back({t[0] + 7, t[2] + 7, t[1] + 7});
	}
	const Solid solid(step);
	NodeDraft node;
	node.vertices = {step.vertices[0], step.vertices[2], step.vertices[9], step.vertices[7]};
	node.faces = {{0, 1, 2}, {0, 2, 3}};
	node.inward = {0, 0, -1};
	node.coneCosine = 1;
	for (std::uint32_t face = 0; face < 4; ++face) node.pieces.push_back({face, 0, Piece::kCodes, 0});
	SweepRule rule{};
	rule.harmless = 1e-3;
	rule.most = 0.01;
	thicken(node, solid, {2, 1e-6, 3000}, rule);
	EXPECT_LE(node.thickness, 0.1);
	EXPECT_GT(node.thickness, 0.09);
	EXPECT_LE(node.bounds.protrude, 1e-3);
}

// A prism of thickness 1 under a triangle, and three input points: above it, beside a face by more but inside, near.
TEST(AssembleCover, IsThatOfTheFarthestPointInWhateverOrder)
{
	NodeDraft node;
	node.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
	node.faces = {{0, 1, 2}};
	node.inward = {0, 0, -1};
	node.thickness = 1;
	node.pieces = {{0, 0, Piece::kCodes, 0}};
	Mesh input;
	input.vertices = {{0.2, 0.2, 0.3}, {0.2, 0.25, -0.9}, {0.3, 0.2, 0.1}};
	for (const std::array<std::uint32_t, 3>& order :
		 {std::array<std::uint32_t, 3>{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}})
	{
		input.triangles = {order};
		EXPECT_NEAR(coverAndReachOf(node, input, {0.1, 1e-4}).cover, 0.3, 1e-6);
	}
}

// Boxes that straddle hollows and ridges of a wrinkled torus. How many of 60 are not bounded within a tenth; every
// bound is compared with samples.
int looseBounds(int budget)
{
	const Mesh mesh = wrinkledTorusMesh(1.0, 0.35, 0.06, 6, 72, 28);
	const Solid solid(mesh);
	const double radius = boundingSphere(mesh.vertices).radius;
	std::mt19937_64 random(7);
	std::uniform_real_distribution<double> unit(-1, 1);
	std::uniform_int_distribution<std::size_t> anyVertex(0, mesh.vertices.size() - 1);
	int loose = 0;
	for (int i = 0; i < 60; ++i)
	{
		const Vec3 center = mesh.vertices[anyVertex(random)];
		const Vec3 half{0.05 + 0.04 * unit(random), 0.1 + 0.08 * unit(random), 0.15 + 0.12 * unit(random)};
		ConvexBody body;
		for (const Vec3& v : boxMesh(half, 1).vertices) body.points.push_back(center + v);
		const Protrusion p = protrusion(solid, body, {radius, 1e-6, budget});
		if (p.upper > std::max(1.1 * p.lower, p.lower + 1e-4 * radius)) ++loose;
		for (int k = 0; k < 300; ++k)
		{
			const Vec3 x = center + Vec3{half.x * unit(random), half.y * unit(random), half.z * unit(random)};
			EXPECT_LE(solid.distance(x), p.upper) << "box " << i;
		}
	}
	return loose;
}

TEST(AssembleProtrusion, HullsOverHollowsAreBoundedWithinATenth)
{
	EXPECT_EQ(looseBounds(15000), 0);
	EXPECT_GT(looseBounds(0), 5);  // the same without cutting anything
}
}  // namespace
}  // namespace clod::test
