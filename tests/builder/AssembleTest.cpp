// SPDX-License-Identifier: GPL-3.0-or-later
// The assembled hierarchy against independent references: sampled lower bounds, closed forms, chains of owners.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "builder/assemble/Assignment.h"
#include "builder/assemble/BoundingSphere.h"
#include "builder/assemble/Certify.h"
#include "builder/assemble/CoarseLevels.h"
#include "builder/assemble/ConvexDistance.h"
#include "tests/fixtures/Recipes.h"
#include "tests/support/HierarchyContents.h"
#include "tests/support/LeafHierarchy.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
using namespace clod::builder;

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
			const Vec3 &one = points[any(random)], &other = points[any(random)];
			if (solid.distance(one * s + other * (1 - s)) > limit) ++beyond;
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

// A waved ground with a skirt, whose faces are many times as tall as wide and lie beneath several patches of a coarse
// level. No patch answers for much more than others because of them: one such kept the default from all coarse levels.
TEST(Assemble, TallFacesBelongToPatchesAsCloselyAsOthers)
{
	constexpr std::uint32_t kCells = 16;
	constexpr double kDepth = 0.5;
	const auto at = [](std::uint32_t i) { return double(i) / kCells - 0.5; };
	Mesh slab;
	for (std::uint32_t j = 0; j <= kCells; ++j)
		for (std::uint32_t i = 0; i <= kCells; ++i)
			slab.vertices.push_back({at(i), at(j), 0.5 * kDepth + 0.015 * std::sin(12.6 * at(i)) * std::sin(15.7 * at(j))});
	const auto place = [](std::uint32_t i, std::uint32_t j) { return j * (kCells + 1) + i; };
	for (std::uint32_t j = 0; j < kCells; ++j)
		for (std::uint32_t i = 0; i < kCells; ++i)
		{
			const std::uint32_t a = place(i, j), b = place(i + 1, j), c = place(i + 1, j + 1), d = place(i, j + 1);
			slab.triangles.push_back({a, b, (i + j) % 2 ? c : d});
			slab.triangles.push_back((i + j) % 2 ? std::array<std::uint32_t, 3>{a, c, d} : std::array<std::uint32_t, 3>{b, c, d});
		}
	std::vector<std::uint32_t> border;
	for (std::uint32_t k = 0; k < kCells; ++k) border.push_back(place(k, 0));
	for (std::uint32_t k = 0; k < kCells; ++k) border.push_back(place(kCells, k));
	for (std::uint32_t k = kCells; k > 0; --k) border.push_back(place(k, kCells));
	for (std::uint32_t k = kCells; k > 0; --k) border.push_back(place(0, k));
	const std::uint32_t beneath = std::uint32_t(slab.vertices.size()), count = std::uint32_t(border.size());
	for (const std::uint32_t v : border)
		slab.vertices.push_back({slab.vertices[v].x, slab.vertices[v].y, -0.5 * kDepth});
	slab.vertices.push_back({0, 0, -0.5 * kDepth});
	for (std::uint32_t k = 0; k < count; ++k)
	{
		const std::uint32_t next = (k + 1) % count;
		slab.triangles.push_back({border[k], beneath + k, beneath + next});
		slab.triangles.push_back({border[k], beneath + next, border[next]});
		slab.triangles.push_back({beneath + count, beneath + next, beneath + k});
	}
	for (Vec3& v : slab.vertices) v = {double(float(v.x)), double(float(v.y)), double(float(v.z))};
	const std::shared_ptr<const Hierarchy> h = loaded(built(slab));
	std::vector<float> covers;
	for (const Node& node : h->nodes())
		if (node.level == 1) covers.push_back(node.cover);
	std::sort(covers.begin(), covers.end());
	EXPECT_LT(covers.back(), 2 * covers[covers.size() / 2]);
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
