// SPDX-License-Identifier: GPL-3.0-or-later
// Decomposition and levels on small meshes, judged by an independent slow oracle that is itself shown to see faults.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "builder/patches/DeviationGuard.h"
#include "builder/patches/Validity.h"
#include "demos/models/Models.h"
#include "tests/builder/PatchesMeshes.h"
#include "tests/builder/PatchesOracle.h"

namespace clod::builder
{
namespace
{
using namespace clod::builder::test;

LodSequence build(const Mesh& mesh, bool paper = false)
{
	BuildConfig config;
	config.paper = paper;
	return buildLods(mesh, config, {});
}

struct NamedMesh
{
	const char* name;
	Mesh mesh;
};
std::vector<NamedMesh> smallMeshes()
{
	return {{"icosphere", icosphere(2)},
			{"box", gridBox({1, 0.6, 0.4}, 4)},
			{"L-plate", lPlate(0.3, 4)},
			{"torus", wrinkledTorus(40, 20, 0, 0)},
			{"wrinkled torus", wrinkledTorus(60, 16, 0.1, 12)},
			{"thick cup", thickCup(32, 6, 0.12)},
			{"thin cup", thickCup(24, 6, 0.02)},
			{"slab", gridBox({4, 0.1, 4}, 6)}};
}

bool isSameMesh(const Mesh& a, const Mesh& b)
{
	return a.triangles == b.triangles && a.vertices.size() == b.vertices.size() &&
		   std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin());
}

TEST(Decomposition, AClosedConvexSurfaceIsOnePatch)
{
	for (const Mesh& mesh : {icosphere(3), gridBox({1, 1, 1}, 1), gridBox({1, 1, 1}, 12), gridBox({3, 0.05, 2}, 9)})
	{
		const LodSequence sequence = build(mesh);
		ASSERT_EQ(sequence.lods.size(), 1u);
		EXPECT_EQ(sequence.lods[0].patchCount, 1u);
	}
}

TEST(Decomposition, TwoSeparateConvexSurfacesAreTwoPatches)
{
	Mesh mesh = gridBox({1, 1, 1}, 3);
	const Mesh second = gridBox({1, 1, 1}, 2);
	const auto offset = std::uint32_t(mesh.vertices.size());
	for (const Vec3& v : second.vertices) mesh.vertices.push_back(v + Vec3{2, 0, 0});
	for (const auto& t : second.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
	const LodSequence sequence = build(mesh);
	EXPECT_EQ(sequence.lods[0].patchCount, 2u);
	EXPECT_EQ(faultOfPatches(sequence.lods[0]), "");
}

TEST(Decomposition, CountsStayNearThePrototypes)
{
	const std::uint32_t torus = build(wrinkledTorus(40, 20, 0, 0)).lods[0].patchCount;
	EXPECT_GE(torus, 35u);
	EXPECT_LE(torus, 60u);
	EXPECT_GE(build(lPlate(0.3, 4)).lods[0].patchCount, 2u);
}

TEST(Levels, EveryLevelOfEverySmallMeshIsValid)
{
	for (const bool paper : {false, true})
		for (const NamedMesh& input : smallMeshes())
		{
			SCOPED_TRACE(std::string(input.name) + (paper ? ", paper" : ""));
			const LodSequence sequence = build(input.mesh, paper);
			EXPECT_EQ(faultOfSurface(input.mesh), "");
			EXPECT_TRUE(isSameMesh(sequence.lods[0].mesh, input.mesh));
			EXPECT_EQ(faultOfSequence(sequence), "");
			for (std::size_t k = 0; k < sequence.lods.size(); ++k)
			{
				SCOPED_TRACE("level " + std::to_string(k));
				EXPECT_TRUE(!paper || k == 0 || !sequence.lods[k].patchOfChild.empty());
				EXPECT_EQ(faultOfSurface(sequence.lods[k].mesh), "");
				EXPECT_EQ(faultOfPatches(sequence.lods[k]), "");
				EXPECT_EQ(eulerCharacteristic(sequence.lods[k].mesh), eulerCharacteristic(input.mesh));
			}
		}
}

TEST(Levels, DeviationStaysWithinTheStop)
{
	for (const NamedMesh& input : smallMeshes())
	{
		SCOPED_TRACE(input.name);
		const LodSequence sequence = build(input.mesh);
		const double limit = 0.125 * boundingRadius(input.mesh);  // 10 % at the samples, some more between them
		for (const Lod& lod : sequence.lods)
		{
			EXPECT_LE(deviation(lod.mesh, input.mesh), limit);
			EXPECT_LE(deviation(input.mesh, lod.mesh), limit);
			EXPECT_LE(lod.patchTolerance, 0.25 * limit);
		}
		// What deviates may be less convex.
		const Lod& coarsest = sequence.lods.back();
		EXPECT_GT(coarsest.patchTolerance, 0.05 * deviation(coarsest.mesh, input.mesh));
	}
}

// Its patches are narrow strips that block one another's collapses: without patches grown anew the bolt keeps 624
// triangles.
TEST(Levels, AThreadGetsDownToAFewTriangles)
{
	const demo::ModelMesh bolt = std::move(demo::makeModel("bolt", 5000)).value();
	Mesh mesh{bolt.vertices, bolt.triangles};
	for (Vec3& v : mesh.vertices) v = roundedToFloat(v);
	const LodSequence sequence = build(mesh);
	EXPECT_EQ(faultOfSequence(sequence), "");
	EXPECT_LE(sequence.lods.back().mesh.triangles.size(), 100u);
	std::size_t grownAnew = 0;
	for (std::size_t k = 1; k < sequence.lods.size(); ++k)
	{
		SCOPED_TRACE("level " + std::to_string(k));
		const Lod& lod = sequence.lods[k];
		if (lod.patchOfChild.empty()) ++grownAnew;
		if (lod.mesh.triangles.size() > 1300) continue;  // the oracle is slow
		EXPECT_EQ(faultOfSurface(lod.mesh), "");
		EXPECT_EQ(faultOfPatches(lod), "");
		EXPECT_EQ(eulerCharacteristic(lod.mesh), 2);
		EXPECT_LE(deviation(lod.mesh, mesh), 0.125 * boundingRadius(mesh));
	}
	EXPECT_GE(grownAnew, 1u);
}

// Patches that span a notch are split elsewhere; a label has one heir.
TEST(Levels, WithPaperEveryPatchInherits)
{
	const demo::ModelMesh cup = std::move(demo::makeModel("cup", 3000)).value();
	Mesh mesh{cup.vertices, cup.triangles};
	for (Vec3& v : mesh.vertices) v = roundedToFloat(v);
	const LodSequence sequence = build(mesh, true);
	EXPECT_GE(sequence.lods.size(), 3u);
	for (std::size_t k = 1; k < sequence.lods.size(); ++k)
	{
		std::vector<char> isHeir(sequence.lods[k].patchCount, 0);
		for (const std::uint32_t heir : sequence.lods[k].patchOfChild) isHeir[heir] = 1;
		EXPECT_EQ(std::count(isHeir.begin(), isHeir.end(), 0), 0) << k;
	}
}

TEST(Levels, TheOracleSeesPlantedFaults)
{
	const LodSequence sequence = build(wrinkledTorus(60, 16, 0.1, 12));
	ASSERT_GE(sequence.lods.size(), 3u);
	for (const Lod& lod : sequence.lods)
	{
		const double radius = boundingRadius(lod.mesh);
		ASSERT_EQ(faultOfPatches(lod), "");
		Lod moved = lod;
		Vec3& v = moved.mesh.vertices[moved.mesh.vertices.size() / 2];
		v = v - (0.2 * radius / length(v)) * v;
		EXPECT_NE(faultOfPatches(moved), "") << lod.patchCount;
		Lod swapped = lod;
		swapped.patchOfTriangle[0] = swapped.patchOfTriangle[lod.patchOfTriangle.size() / 2];
		EXPECT_NE(faultOfPatches(swapped), "");
		Lod flipped = lod;
		std::swap(flipped.mesh.triangles[0][0], flipped.mesh.triangles[0][1]);
		EXPECT_NE(faultOfSurface(flipped.mesh), "");
		Lod opened = lod;
		opened.mesh.triangles.pop_back();
		EXPECT_NE(faultOfSurface(opened.mesh), "");
	}
	const LodSequence inherited = build(wrinkledTorus(60, 16, 0.1, 12), true);
	ASSERT_GE(inherited.lods.size(), 3u);
	ASSERT_EQ(faultOfSequence(inherited), "");
	LodSequence wrong = inherited;
	wrong.lods[1].patchOfChild[0] = wrong.lods[1].patchCount;
	EXPECT_NE(faultOfSequence(wrong), "");
	wrong = inherited;
	wrong.lods[1].patchCount = wrong.lods[0].patchCount;
	EXPECT_NE(faultOfSequence(wrong), "");
	wrong = inherited;
	for (double& r : wrong.lods[2].patchResolution) r = 1e9;
	EXPECT_NE(faultOfSequence(wrong), "");
}

TEST(Levels, AFlatPatchMustNotSpanANotch)
{
	// The whole top of an L in one patch: convex edges, no volume, but its hull spans the notch.
	Lod lod;
	lod.mesh = lPlate(0.3, 2);
	lod.patchTolerance = 1e-6;
	for (const auto& t : lod.mesh.triangles)
	{
		bool top = true;
		for (const std::uint32_t v : t) top = top && lod.mesh.vertices[v].z > 0.2;
		lod.patchOfTriangle.push_back(top ? 0 : lod.patchCount + 1);
		if (!top) ++lod.patchCount;
	}
	++lod.patchCount;
	lod.patchResolution.assign(lod.patchCount, 0);
	EXPECT_NE(faultOfPatches(lod).find("notch"), std::string::npos);
}

// The area of a narrow notch is below what a long border may leave out; its depth is thousands of tolerances.
TEST(Decomposition, AFlatPatchSpansNoNarrowNotch)
{
	const auto topIsPatch = [](double width, double depth)
	{
		PatchMesh mesh(notchedPlate(0.3, width, depth));
		std::vector<std::uint32_t> top;
		for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
			if (mesh.planes[f].normal.z > 0.5) top.push_back(f);
		Validity validity(mesh);
		validity.tolerance = 8.0 / (1 << 24) * mesh.radius;
		return validity.isValid(top);
	};
	for (const double width : {1e-4, 2e-4, 4e-4}) EXPECT_FALSE(topIsPatch(width, 10 * width)) << width;
	for (const double depth : {2e-7, 1e-6}) EXPECT_TRUE(topIsPatch(0.1, depth)) << depth;
}

// All its edges and planes are convex within the tolerance; its hull closes the hole.
TEST(Decomposition, ARingThinnerThanTheToleranceIsNoConvexPatch)
{
	Mesh ring = wrinkledTorus(16, 8, 0, 0);
	for (Vec3& v : ring.vertices) v.z *= 3e-7;
	EXPECT_GT(build(ring).lods[0].patchCount, 1u);
	Mesh disc = gridBox({1, 1, 1e-7}, 4);
	EXPECT_EQ(build(disc).lods[0].patchCount, 1u);
}

// Three sheets over each other in half of the notch have more area than the notch.
TEST(Decomposition, SheetsOverEachOtherCoverOnce)
{
	const auto topIsPatch = [](int sheets, double side)
	{
		Mesh mesh = lPlate(0.3, 2);
		const double eps = 8.0 / (1 << 24) * PatchMesh(mesh).radius;
		for (int i = 0; i < sheets; ++i)
		{
			const auto first = std::uint32_t(mesh.vertices.size());
			const Mesh sheet = gridBox({side, side, eps}, 1);
			for (const Vec3& v : sheet.vertices)
				mesh.vertices.push_back(v + Vec3{1, 1, double(roundToFloat(0.3)) - (2 * i + 1) * eps});
			for (const auto& t : sheet.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
		}
		PatchMesh patches(mesh);
		std::vector<std::uint32_t> top;
		for (std::uint32_t f = 0; f < patches.faces.size(); ++f)
			if (f < lPlate(0.3, 2).triangles.size() && patches.planes[f].normal.z > 0.5) top.push_back(f);
		Validity validity(patches);
		validity.tolerance = eps;
		validity.isExact = true;
		return validity.isValid(top);
	};
	EXPECT_FALSE(topIsPatch(1, 0.5));
	EXPECT_FALSE(topIsPatch(3, 0.5));
	EXPECT_TRUE(topIsPatch(1, 1));
	EXPECT_TRUE(topIsPatch(3, 1));
}

TEST(Levels, SameResultForAnyThreadCountAndEveryTime)
{
	const Mesh mesh = thickCup(32, 6, 0.12);
	BuildConfig config;
	config.threads = 1;
	const LodSequence first = buildLods(mesh, config, {});
	config.threads = 3;
	const LodSequence second = buildLods(mesh, config, {});
	ASSERT_EQ(first.lods.size(), second.lods.size());
	for (std::size_t k = 0; k < first.lods.size(); ++k)
	{
		EXPECT_TRUE(isSameMesh(first.lods[k].mesh, second.lods[k].mesh));
		EXPECT_EQ(first.lods[k].patchOfTriangle, second.lods[k].patchOfTriangle);
		EXPECT_EQ(first.lods[k].patchResolution, second.lods[k].patchResolution);
		EXPECT_EQ(first.lods[k].patchOfChild, second.lods[k].patchOfChild);
	}
}

TEST(Levels, ScalingByAPowerOfTwoChangesNothing)
{
	const Mesh mesh = wrinkledTorus(60, 16, 0.1, 12);
	const LodSequence expected = build(mesh);
	for (const double scale : {std::ldexp(1.0, -12), std::ldexp(1.0, 12)})
	{
		Mesh scaled = mesh;
		for (Vec3& v : scaled.vertices) v = scale * v;
		const LodSequence found = build(scaled);
		ASSERT_EQ(found.lods.size(), expected.lods.size());
		for (std::size_t k = 0; k < found.lods.size(); ++k)
		{
			EXPECT_EQ(found.lods[k].patchOfTriangle, expected.lods[k].patchOfTriangle);
			EXPECT_EQ(found.lods[k].mesh.triangles, expected.lods[k].mesh.triangles);
		}
	}
}

TEST(Levels, AQuarterTurnKeepsTheDecomposition)
{
	const Mesh mesh = thickCup(32, 6, 0.12);
	Mesh turned = mesh;
	for (Vec3& v : turned.vertices) v = {v.y, v.z, v.x};
	EXPECT_EQ(build(turned).lods[0].patchCount, build(mesh).lods[0].patchCount);
}

// A guard that has to keep the input within a fiftieth of the size.
DeviationGuard guardOf(const Mesh& mesh)
{
	DeviationGuard guard(mesh, 1);
	guard.bound = 0.02;
	return guard;
}

TEST(DeviationGuard, NeedlesHoldFewSamples)
{
	const auto torus = [](double u, double v)
	{
		const double a = 2 * M_PI * u, b = 2 * M_PI * v, r = 0.75 + 0.25 * std::cos(b);
		return Vec3{r * std::cos(a), 0.25 * std::sin(b), -r * std::sin(a)};
	};
	for (const auto& [columns, rows] : {std::pair{4000, 8}, std::pair{4, 8000}})
	{
		const Mesh mesh = periodicGrid(columns, rows, torus);
		std::size_t held = 0;
		const DeviationGuard guard(mesh, 1);
		for (const auto& samples : guard.held().samples) held += samples.size();
		EXPECT_LT(held, 3 * mesh.vertices.size());
	}
}

// Large triangles of thin plates, needles on one: of a sample near the middle, the other side of the wall has none.
TEST(DeviationGuard, SeesADentInEveryLargeTriangle)
{
	for (const double width : {1.0, 0.12})
	{
		const Mesh plate = gridBox({1, 0.005, width}, 1);
		DeviationGuard guard = guardOf(plate);
		for (std::uint32_t f = 0; f < plate.triangles.size(); ++f)
		{
			const auto& t = plate.triangles[f];
			const Vec3 &a = plate.vertices[t[0]], &b = plate.vertices[t[1]], &c = plate.vertices[t[2]];
			const Vec3 normal = cross(b - a, c - a);
			if (length(normal) < 0.5 * width) continue;
			EXPECT_GT(guard.held().samples[f].size(), std::size_t(1000 * width)) << width << ' ' << f;
			const Vec3 middle = (1.0 / 3) * (a + b + c);
			const auto isNearDent = [&](double depth)
			{
				const Vec3 dent = middle - depth / length(normal) * normal;
				return guard.inputIsNear({f}, {f, f, f}, {{a, b, dent}, {b, c, dent}, {c, a, dent}});
			};
			EXPECT_TRUE(isNearDent(0.01)) << width << ' ' << f;
			EXPECT_FALSE(isNearDent(0.06)) << width << ' ' << f;
		}
	}
}

TEST(Levels, CancelStopsTheBuild)
{
	EXPECT_THROW(buildLods(wrinkledTorus(60, 16, 0.1, 12), {}, [](const char*, double) { return false; }), Cancelled);
}
}  // namespace
}  // namespace clod::builder
