// SPDX-License-Identifier: GPL-3.0-or-later
// The assembled hierarchy against independent references: sampled lower bounds, closed forms, chains of owners.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "builder/assemble/Assignment.h"
#include "builder/assemble/BoundingSphere.h"
#include "builder/assemble/Certify.h"
#include "builder/assemble/CoarseLevels.h"
#include "builder/assemble/ContactArea.h"
#include "builder/assemble/ConvexDistance.h"
#include "builder/assemble/MassProperties.h"
#include "builder/assemble/Protrusion.h"
#include "builder/assemble/Walls.h"
#include "tests/support/HierarchyContents.h"
#include "tests/support/LeafHierarchy.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
using namespace clod::builder;
const double kPi = std::acos(-1.0);

std::shared_ptr<const Hierarchy> torus(bool paper, unsigned threads = 0)
{
	BuildConfig config;
	config.paper = paper;
	config.threads = threads;
	return loaded(assembleHierarchy(torusLods(1, 0.4, 32, 16, 3), config, nullptr));
}

Vec3 randomIn(const builder::Triangle& t, std::mt19937_64& random)
{
	std::uniform_real_distribution<double> unit(0, 1);
	double u = unit(random), v = unit(random);
	if (u + v > 1) u = 1 - u, v = 1 - v;
	return t.a + u * (t.b - t.a) + v * (t.c - t.a);
}

builder::Triangle faceOf(const Hierarchy& h, const Node& n, std::uint32_t i)
{
	const Face& f = h.faces(n)[i];
	return {h.hull(n).vertex(f.vertex[0]), h.hull(n).vertex(f.vertex[1]), h.hull(n).vertex(f.vertex[2])};
}

std::vector<Vec3> verticesOf(const Hierarchy& h, const Node& n)
{
	std::vector<Vec3> points;
	for (std::uint32_t i = 0; i < n.vertexCount; ++i) points.push_back(h.hull(n).vertex(i));
	return points;
}

Vec3 sweepOf(const Node& n)
{
	return double(n.thickness) * Vec3{double(n.inward[0]), double(n.inward[1]), double(n.inward[2])};
}

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
	for (std::uint32_t face = 0; face < 4; ++face) node.pieces.push_back({face, 0, std::uint16_t(Piece::kCodes), 0});
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
	node.pieces = {{0, 0, std::uint16_t(Piece::kCodes), 0}};
	Mesh input;
	input.vertices = {{0.2, 0.2, 0.3}, {0.2, 0.25, -0.9}, {0.3, 0.2, 0.1}};
	for (const std::array<std::uint32_t, 3>& order :
		 {std::array<std::uint32_t, 3>{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}})
	{
		input.triangles = {order};
		EXPECT_NEAR(coverAndReachOf(node, input, {0.1, 1e-4}).cover, 0.3, 1e-6);
	}
}

TEST(Assemble, LeavesAndLevelsAreValid)
{
	EXPECT_EQ(loaded(leafHierarchy(torusMesh(1, 0.4, 24, 12)))->levels()[0].nodeCount, 576u);
	EXPECT_EQ(loaded(leafHierarchy(boxMesh({1, 1, 1}, 1)))->levels()[0].nodeCount, 12u);
	EXPECT_EQ(torus(false)->coarsestClodLevel(), 2u);
	EXPECT_TRUE(torus(true)->isPaperBuild());
}

TEST(Assemble, SameBytesForAnyNumberOfThreads)
{
	const auto one = torus(false, 1);
	EXPECT_EQ(one->bytes(), torus(false, 2)->bytes());
	EXPECT_EQ(one->bytes(), torus(false, 3)->bytes());
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

// Of 500 points of each patch's hull.
int pointsBeyond(const Lod& lod, const Solid& solid, double limit)
{
	std::mt19937_64 random(11);
	std::vector<std::vector<Vec3>> corners(lod.patchCount);
	for (std::size_t f = 0; f < lod.mesh.triangles.size(); ++f)
		for (const std::uint32_t v : lod.mesh.triangles[f])
			corners[lod.patchOfTriangle[f]].push_back(lod.mesh.vertices[v]);
	int beyond = 0;
	for (const std::vector<Vec3>& points : corners)
		for (int i = 0; i < 500 && !points.empty(); ++i)
		{
			std::uniform_int_distribution<std::size_t> any(0, points.size() - 1);
			const double s = std::uniform_real_distribution<double>(0, 1)(random);
			if (solid.distance(points[any(random)] * s + points[any(random)] * (1 - s)) > limit) ++beyond;
		}
	return beyond;
}

// Whether every patch of the coarse level is made of whole patches of the fine one, of the same triangles.
bool isUnionOf(const Lod& fine, const Lod& coarse)
{
	if (fine.mesh.triangles != coarse.mesh.triangles) return false;
	std::vector<std::uint32_t> into(fine.patchCount, kNone);
	for (std::size_t f = 0; f < fine.patchOfTriangle.size(); ++f)
	{
		std::uint32_t& patch = into[fine.patchOfTriangle[f]];
		if (patch != kNone && patch != coarse.patchOfTriangle[f]) return false;
		patch = coarse.patchOfTriangle[f];
	}
	return true;
}

struct BridgedTorus
{
	explicit BridgedTorus(const LodSequence& sequence)
		: solid(sequence.lods[0].mesh),
		  radius(boundingSphere(sequence.lods[0].mesh.vertices).radius),
		  lods(sequence.lods.begin() + 1, sequence.lods.end())
	{
		bridgeCoarseLevels(lods, solid, {radius, 1e-6 * radius, 15000}, 1);
	}
	const Solid solid;
	const double radius;
	std::vector<Lod> lods;
};

TEST(AssembleCoarse, BridgedLevelsHalveAndStayWithinTheirError)
{
	const BridgedTorus torus(torusLods(1, 0.4, 20, 12, 2));
	const std::vector<Lod>& lods = torus.lods;
	ASSERT_GE(lods.size(), 2u);
	for (std::size_t k = 1; k < lods.size(); ++k)
	{
		EXPECT_LE(2 * lods[k].patchCount, lods[k - 1].patchCount);
		EXPECT_EQ(pointsBeyond(lods[k], torus.solid, lods[k].errorLimit), 0) << k;
		EXPECT_TRUE(isUnionOf(lods[k - 1], lods[k])) << k;
	}
	Lod blind = lods[1];  // merged without looking
	for (std::uint32_t& patch : blind.patchOfTriangle) patch /= 4;
	EXPECT_GT(pointsBeyond(blind, torus.solid, blind.errorLimit), 0);
	EXPECT_FALSE(isUnionOf(lods[1], lods[0]));
}

// The fewest patches of a level whose hulls keep the limit; kNone where none is known to.
std::uint32_t fewestWithin(const std::vector<Lod>& lods, double limit)
{
	std::uint32_t fewest = kNone;
	for (const Lod& lod : lods)
		if (lod.errorLimit <= limit) fewest = std::min(fewest, lod.patchCount);
	return fewest;
}

TEST(AssembleCoarse, LevelsOfSmallErrorsStayBelowThoseOfLargeOnes)
{
	const BridgedTorus torus(torusLods(1, 0.4, 40, 24, 4));
	const std::vector<Lod>& lods = torus.lods;
	EXPECT_LE(fewestWithin(lods, 0.03 * torus.radius), 240u / 4);
	EXPECT_LE(2 * fewestWithin(lods, 0.2 * torus.radius), fewestWithin(lods, 0.03 * torus.radius));
	for (std::size_t k = 0; k < lods.size(); ++k)
	{
		EXPECT_TRUE(lods[k].patchOfChild.empty()) << k;  // of levels that may be gone
		if (k > 0)
		{
			EXPECT_LE(2 * lods[k].patchCount, lods[k - 1].patchCount) << k;
		}
	}
}

TEST(AssembleProtrusion, HullsOverHollowsAreBoundedWithinATenth)
{
	EXPECT_EQ(looseBounds(15000), 0);
	EXPECT_GT(looseBounds(0), 5);  // the same without cutting anything
}

// A coarse level of a million triangles: one face over all of a flat side. With 20,000 parts a face the bound is 0.17.
TEST(AssembleSurf, AFaceOverFiftyThousandFlatTrianglesIsProvedToLieOnThem)
{
	constexpr std::uint32_t kCells = 160;
	Mesh sheet;
	for (std::uint32_t i = 0; i <= kCells; ++i)
		for (std::uint32_t j = 0; j <= kCells; ++j)
			sheet.vertices.push_back({double(i) / kCells, double(j) / kCells, 0});
	for (std::uint32_t i = 0; i < kCells; ++i)
		for (std::uint32_t j = 0; j < kCells; ++j)
		{
			const std::uint32_t a = i * (kCells + 1) + j, b = a + kCells + 1;
			sheet.triangles.push_back({a, b, b + 1});
			sheet.triangles.push_back({a, b + 1, a + 1});
		}
	const TriangleTree tree(sheet);
	NodeDraft node;
	node.vertices = {{0.01, 0.02, 0}, {0.99, 0.03, 0}, {0.98, 0.99, 0}, {0.02, 0.98, 0}};
	node.faces = {{0, 1, 2}, {0, 2, 3}};
	EXPECT_LE(surfOf(node, tree, {0.1, 1e-4}).upper, 1e-4);
	node.vertices[2].z = 0.05;
	const Supremum raised = surfOf(node, tree, {0.1, 1e-4});
	EXPECT_GE(raised.upper, 0.05);
	EXPECT_LE(raised.upper, 0.055 + 1e-9);
}

TEST(Assemble, SampledSurfAndProtrudeNeverExceedTheirBounds)
{
	const auto h = torus(false);
	const Solid solid(torusMesh(1, 0.4, 32, 16));
	std::mt19937_64 random(7);
	std::uniform_real_distribution<double> unit(0, 1);
	double tightestSurf = 0, tightestProtrude = 0;
	for (const Node& n : h->nodes())
	{
		if (n.level == 0 || n.flags == 0) continue;
		for (std::uint32_t f = 0; f < n.faceCount; ++f)
			for (int i = 0; i < 100; ++i)
			{
				const double d = std::fabs(solid.signedDistance(randomIn(faceOf(*h, n, f), random)));
				ASSERT_LE(d, double(n.surf));
				tightestSurf = std::max(tightestSurf, d / double(n.surf));
			}
		const std::vector<Vec3> points = verticesOf(*h, n);
		for (int i = 0; i < 300; ++i)
		{
			Vec3 p = unit(random) * sweepOf(n);
			double total = 0;
			std::vector<double> weight;
			// Between four vertices: of more, the mean hardly leaves the middle of the hull.
			for (int k = 0; k < 4; ++k) total += weight.emplace_back(-std::log(unit(random) + 1e-300));
			for (const double w : weight) p += (w / total) * points[random() % points.size()];
			const double d = solid.distance(p);
			ASSERT_LE(d, double(n.protrude));
			tightestProtrude = std::max(tightestProtrude, d / double(n.protrude));
		}
	}
	EXPECT_GT(tightestSurf, 0.8);  // the bound is met somewhere, so a bound half as large would have failed
	EXPECT_GT(tightestProtrude, 0.25);
}

// Every point of the input has a chain leaf .. root whose contact nodes cover it and whose culling boxes contain it.
bool hasChain(const Hierarchy& h, std::uint32_t node, const Vec3& p,
			  const std::vector<std::vector<std::uint32_t>>& parents)
{
	const Node& n = h.node(node);
	const OrientedBox& box = h.cullBox(node);
	Vec3 d = p;
	for (int k = 0; k < 3; ++k) d[k] -= double(box.center[k]);
	for (int i = 0; i < 3; ++i)
		if (std::fabs(dot(d, {double(box.axis[i][0]), double(box.axis[i][1]), double(box.axis[i][2])})) >
			double(box.half[i]))
			return false;
	const std::vector<Vec3> points = verticesOf(h, n);
	const double gap = distanceBound(p, {points.data(), points.size(), sweepOf(n)});
	if (n.flags != 0 && gap * (1 - 2e-3) > double(n.cover) + 1e-6) return false;
	if (node == h.root()) return true;
	for (std::uint32_t parent : parents[node])
		if (hasChain(h, parent, p, parents)) return true;
	return false;
}

std::size_t pointsWithoutChain(const Hierarchy& h)
{
	std::vector<std::vector<std::uint32_t>> parents(h.nodes().size);
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
		for (std::uint32_t c : h.children(h.node(i))) parents[c].push_back(i);
	std::mt19937_64 random(3);
	std::size_t missing = 0;
	for (std::uint32_t i = 0; i < h.levels()[0].nodeCount; ++i)
		for (std::uint32_t f = 0; f < h.node(i).faceCount; ++f)
			for (int k = 0; k < 5; ++k) missing += !hasChain(h, i, randomIn(faceOf(h, h.node(i), f), random), parents);
	return missing;
}

TEST(Assemble, EveryInputPointHasAChainThatCoversIt)
{
	EXPECT_EQ(pointsWithoutChain(*torus(false)), 0u);
	EXPECT_EQ(pointsWithoutChain(*torus(true)), 0u);
	EXPECT_EQ(pointsWithoutChain(*loaded(leafHierarchy(torusMesh(1, 0.4, 24, 12)))), 0u);
}

TEST(Assemble, PaperHausdorffIsThatOfAllDescendants)
{
	const auto h = torus(true);
	double tightest = 0;
	for (const Node& n : h->nodes())
	{
		const std::vector<Vec3> own = verticesOf(*h, n);
		std::vector<std::uint32_t> open(h->children(n).begin(), h->children(n).end());
		while (!open.empty())
		{
			const Node& below = h->node(open.back());
			open.pop_back();
			open.insert(open.end(), h->children(below).begin(), h->children(below).end());
			for (const Vec3& v : verticesOf(*h, below))
			{
				const double d = distanceBound(v, {own.data(), own.size(), sweepOf(n)}) * (1 - 2e-3);
				ASSERT_LE(d, double(n.hausdorff) + 1e-6);
				if (n.level > 0 && n.flags != 0) tightest = std::max(tightest, d / double(n.hausdorff));
			}
		}
	}
	EXPECT_GT(tightest, 0.95);
}
}  // namespace
}  // namespace clod::test
