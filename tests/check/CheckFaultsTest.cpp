// SPDX-License-Identifier: GPL-3.0-or-later
// The checker accepts sound hierarchies and finds every planted fault: a small hierarchy is damaged in one number,
// written with right checksums, and must be refused by the loader or named by the checker.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "builder/Lod.h"
#include "builder/check/Check.h"
#include "tests/query/Bodies.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
const HierarchyContent& soundContent()
{
	static const HierarchyContent content = []
	{
		builder::BuildConfig config;
		config.threads = 1;
		const auto silent = [](const char*, double) { return true; };
		return builder::buildHierarchy(wrinkledTorusMesh(1.0, 0.35, 0.06, 6, 36, 14), config, silent);
	}();
	return content;
}

// Empty when everything holds, "load: ..." when the loader refuses, else the name of the first broken invariant.
std::string firstFault(const HierarchyContent& content)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy) return "load: " + hierarchy.error();
	check::Options options;
	options.threads = 1;
	for (const check::Invariant& invariant : check::checkHierarchy(*hierarchy.value(), options))
		if (invariant.violations > 0) return invariant.name;
	return "";
}

Level& levelOf(HierarchyContent& c, std::uint32_t node)
{
	return c.levels[c.nodes[node].level];
}

// The node of the coarsest contact level with the largest value.
std::uint32_t largest(const HierarchyContent& c, float Node::*number)
{
	std::uint32_t best = 0;
	for (std::uint32_t i = 0; i < c.nodes.size(); ++i)
		if ((c.nodes[i].flags & kClodNode) != 0 && c.nodes[i].*number > c.nodes[best].*number) best = i;
	return best;
}

// Shrinks a bound (by a power of two: it stays on the grid) in every contact node above level 0, with the numbers
// derived from it, so that only the geometry can tell.
void shrink(HierarchyContent& c, float Node::*number, float Level::*maximum, float factor)
{
	for (Level& level : c.levels) level.*maximum = level.maxDeviation = 0;
	for (Node& n : c.nodes)
	{
		n.*number *= factor;
		if (number == &Node::reach) n.reach = std::max(n.reach, n.cover);
		n.deviation = std::max({n.cover, n.protrude, n.surf});
		Level& level = c.levels[n.level];
		level.*maximum = std::max(level.*maximum, n.*number);
		level.maxDeviation = std::max(level.maxDeviation, n.deviation);
	}
}

struct Fault
{
	const char* name;
	std::function<void(HierarchyContent&)> plant;
	const char* expected;  // invariant, or "load"
};
void PrintTo(const Fault& fault, std::ostream* out)
{
	*out << fault.name;
}

const Fault kFaults[] = {
	{"CoverTooSmall", [](HierarchyContent& c) { shrink(c, &Node::cover, &Level::maxCover, 0.25f); }, "cover"},
	{"ReachTooSmall",
	 [](HierarchyContent& c)
	 {
		 shrink(c, &Node::cover, &Level::maxCover, 1.0f);
		 for (Node& n : c.nodes) n.reach = n.cover;
	 },
	 "reach"},
	{"SurfTooSmall", [](HierarchyContent& c) { shrink(c, &Node::surf, &Level::maxSurf, 0.25f); }, "surf"},
	{"ProtrudeTooSmall", [](HierarchyContent& c) { shrink(c, &Node::protrude, &Level::maxProtrude, 0.125f); },
	 "protrude"},
	{"HausdorffTooSmall",
	 [](HierarchyContent& c)
	 {
		 for (Level& level : c.levels) level.maxHausdorff = 0;
		 for (Node& n : c.nodes)
		 {
			 n.hausdorff *= 0.25f;
			 c.levels[n.level].maxHausdorff = std::max(c.levels[n.level].maxHausdorff, n.hausdorff);
		 }
	 },
	 "hausdorff"},
	{"CullingBoxTooSmall", [](HierarchyContent& c) { c.cullBoxes.back().half[0] *= 0.9f; }, "load"},
	{"VolumeOff", [](HierarchyContent& c) { c.asset.volume *= 1.001; }, "mass-properties"},
	{"InertiaOff", [](HierarchyContent& c) { c.asset.inertia[1] *= 1.001; }, "mass-properties"},
	{"PrincipalAxesOff",
	 [](HierarchyContent& c)
	 {
		 const double turned[4] = {std::sin(0.3), 0, 0, std::cos(0.3)};
		 std::copy(turned, turned + 4, c.asset.principal);
	 },
	 "mass-properties"},
	// Twice what the checker allows.
	{"VolumeSlightlyOff", [](HierarchyContent& c) { c.asset.volume *= 1 + 2e-6; }, "mass-properties"},
	{"InertiaSlightlyOff",
	 [](HierarchyContent& c)
	 {
		 const double largest = std::max({c.asset.inertia[0], c.asset.inertia[1], c.asset.inertia[2]});
		 c.asset.inertia[5] += 2e-6 * largest;
	 },
	 "mass-properties"},
	{"PrincipalAxesSlightlyOff",  // about the axis of a ring, in the plane of it and another
	 [](HierarchyContent& c)
	 {
		 // 1e-5 radians turn a difference of moments of near half the largest one into 4e-6 of it beside the diagonal.
		 const double half = 5e-6, *q = c.asset.principal;
		 const double turned[4] = {q[0] + half * q[3], q[1] + half * q[2], q[2] - half * q[1], q[3] - half * q[0]};
		 std::copy(turned, turned + 4, c.asset.principal);
	 },
	 "mass-properties"},
	{"VertexMoved",  // in one patch only: the surface tears
	 [](HierarchyContent& c) { c.hullX[c.nodes[0].firstVertex] += 0.01f; }, "load"},
	{"PatchConcave",  // patches 0 and 1 of level 0 made one by moving the border: the faces of 1 now belong to 0
	 [](HierarchyContent& c)
	 {
		 // Every tolerance made zero: some patch must use it.
		 for (Level& level : c.levels) level.patchTolerance = 0;
		 c.asset.storageTolerance *= 1e-4f;
	 },
	 "face-records|edges-convex|faces-on-hull|no-foreign-face|load"},
	{"PatchesMoreConvexThanTheyAre",  // a coarse level's are said to be as convex as rounding allows
	 [](HierarchyContent& c)
	 {
		 for (Level& level : c.levels) level.patchTolerance = std::min(level.patchTolerance, c.levels[0].patchTolerance);
	 },
	 "edges-convex"},
	{"NeighbourWrong", [](HierarchyContent& c) { std::swap(c.faces[0].neighbour[0], c.faces[0].neighbour[1]); },
	 "load"},
	{"WindingFlipped", [](HierarchyContent& c) { std::swap(c.faces[0].vertex[0], c.faces[0].vertex[1]); }, "load"},
	{"ChildTwice", [](HierarchyContent& c) { c.children[1] = c.children[0]; }, "load"},
	{"BoundFalls", [](HierarchyContent& c) { c.nodes.back().cover = 0; }, "load"},
	{"AreaRises", [](HierarchyContent& c) { c.nodes.back().contactArea *= 100; }, "load"},
	{"LevelMaximumWrong", [](HierarchyContent& c) { levelOf(c, largest(c, &Node::cover)).maxCover *= 2; }, "load"},
	{"FeatureVolumeTooSmall",
	 [](HierarchyContent& c)
	 {
		 for (Node& n : c.nodes)
			 if ((n.flags & kClodNode) != 0) n.featureVolume *= 0.5f;
	 },
	 "derived-numbers"},
	{"ContactAreaNegative", [](HierarchyContent& c) { c.nodes[0].contactArea = -1; }, "load"},
	{"NormalWrong", [](HierarchyContent& c) { std::swap(c.faces[0].normal[0], c.faces[0].normal[1]); },
	 "load|face-records"},
	{"ThicknessThroughTheWall",
	 [](HierarchyContent& c)
	 {
		 for (std::uint32_t i = 0; i < c.levels[0].nodeCount; ++i) c.nodes[i].thickness = 2;
	 },
	 "load|asset-bounds|culling-boxes|protrude"},
	{"FaceThicknessTooLarge", [](HierarchyContent& c) { c.faces[0].thickness = 1; }, "face-records"},
};

class PlantedFault : public ::testing::TestWithParam<Fault>
{
};
}  // namespace

TEST(Check, AcceptsASoundHierarchy)
{
	EXPECT_EQ(firstFault(soundContent()), "");
}

TEST(Check, SoundHierarchyHasWorkForEveryInvariant)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(soundContent()));
	ASSERT_TRUE(bool(hierarchy)) << hierarchy.error();
	const auto invariants = check::checkHierarchy(*hierarchy.value(), {});
	EXPECT_GE(invariants.size(), 22u);
	for (const check::Invariant& i : invariants) EXPECT_GT(i.checked, 0u) << i.name;
}

TEST(Check, SameResultForAnyNumberOfThreads)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(soundContent()));
	ASSERT_TRUE(bool(hierarchy)) << hierarchy.error();
	check::Options one, three;
	one.threads = 1;
	three.threads = 3;
	const auto a = check::checkHierarchy(*hierarchy.value(), one), b = check::checkHierarchy(*hierarchy.value(), three);
	ASSERT_EQ(a.size(), b.size());
	for (std::size_t i = 0; i < a.size(); ++i)
	{
		EXPECT_EQ(a[i].checked, b[i].checked) << a[i].name;
		EXPECT_EQ(a[i].undecided, b[i].undecided) << a[i].name;
	}
}

// What the budget of a proof leaves open is told, not taken.
TEST(Check, WhatIsUndecidedIsCounted)
{
	std::uint64_t undecided = 0;
	for (const check::Invariant& invariant : check::checkHierarchy(*body("cup-3000").hierarchy, {}))
		if (invariant.name == "protrude") undecided += invariant.undecided;
	EXPECT_GT(undecided, 0u) << "all is decided now: take a body where it is not";
}

// Faces are cut along the edges of the input's, as what lies over one is settled at once: by quartering 176 and 53 of
// their faces stayed undecided.
TEST(Check, EveryFacesDistanceIsDecided)
{
	for (const char* name : {"cup-3000", "spoon-3000"})
	{
		std::uint64_t checked = 0;
		for (const check::Invariant& invariant : check::checkHierarchy(*body(name).hierarchy, {}))
		{
			EXPECT_EQ(invariant.violations, 0u) << name << ": " << invariant.name;
			if (invariant.name != "surf") continue;
			checked = invariant.checked;
			EXPECT_EQ(invariant.undecided, 0u) << name;
		}
		EXPECT_GT(checked, 1000u) << name;
	}
}

TEST(Check, LevelZeroIsComparedWithTheGivenMesh)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(soundContent()));
	ASSERT_TRUE(bool(hierarchy)) << hierarchy.error();
	const builder::Mesh mesh = wrinkledTorusMesh(1.0, 0.35, 0.06, 6, 36, 14);
	const double* const shift = hierarchy.value()->asset().meshFromBody;
	check::GivenMesh given;
	for (const Vec3& v : mesh.vertices) given.vertices.push_back(v + Vec3{shift[0], shift[1], shift[2]});
	for (const auto& t : mesh.triangles) given.polygons.emplace_back(t.begin(), t.end());
	const auto broken = [&]
	{
		check::Options options;
		options.given = &given;
		for (const check::Invariant& i : check::checkHierarchy(*hierarchy.value(), options))
			if (i.violations > 0) return i.name;
		return std::string();
	};
	EXPECT_EQ(broken(), "");
	given.vertices[7].x += 1e-3;
	EXPECT_EQ(broken(), "equals-mesh");
}

// Each proof by itself: reflex edges, corners above their faces, and faces in the hull of another patch's.
TEST(Check, ConvexityIsProvedInEveryWay)
{
	HierarchyContent content = soundContent();
	for (Level& level : content.levels)
		level.patchTolerance = std::min(level.patchTolerance, content.levels[0].patchTolerance);
	const auto hierarchy = Hierarchy::fromBytes(encode(content));
	ASSERT_TRUE(hierarchy) << hierarchy.error();
	std::set<std::string> broken;
	for (const check::Invariant& invariant : check::checkHierarchy(*hierarchy.value(), {}))
		if (invariant.violations > 0 && invariant.worst > 0) broken.insert(invariant.name);
	EXPECT_EQ(broken, (std::set<std::string>{"edges-convex", "faces-on-hull", "no-foreign-face"}));
}

// A ball with a dimple at either pole, all between them one patch: convex along its edges and on its hull, which the
// dimples are in.
TEST(Check, APatchWhoseHullHoldsAnothersFacesIsFound)
{
	builder::Lod lod = trianglePatches(sphereMesh(1, 12, 6));
	const auto last = std::uint32_t(lod.mesh.vertices.size() - 1);
	lod.mesh.vertices[0].y = 0.25;
	lod.mesh.vertices[last].y = -0.25;
	lod.patchCount = 1;
	for (std::size_t i = 0; i < lod.mesh.triangles.size(); ++i)
	{
		const auto& t = lod.mesh.triangles[i];
		const bool isOfDimple = std::count(t.begin(), t.end(), 0u) + std::count(t.begin(), t.end(), last) > 0;
		lod.patchOfTriangle[i] = isOfDimple ? lod.patchCount++ : 0;
	}
	lod.patchResolution.resize(lod.patchCount);
	lod.patchTolerance = 1e-6;
	const auto hierarchy = Hierarchy::fromBytes(encode(builder::assembleHierarchy({{lod}}, builder::BuildConfig{}, nullptr)));
	ASSERT_TRUE(hierarchy) << hierarchy.error();
	std::set<std::string> broken;
	for (const check::Invariant& invariant : check::checkHierarchy(*hierarchy.value(), {}))
		if (invariant.violations > 0) broken.insert(invariant.name);
	EXPECT_EQ(broken, std::set<std::string>{"no-foreign-face"});
}

TEST_P(PlantedFault, IsFound)
{
	HierarchyContent content = soundContent();
	GetParam().plant(content);
	const std::string found = firstFault(content);
	ASSERT_NE(found, "") << "the fault went unnoticed";
	const std::string name = found.substr(0, found.find(':'));
	EXPECT_NE(("|" + std::string(GetParam().expected) + "|").find("|" + name + "|"), std::string::npos)
		<< "found: " << found;
}

INSTANTIATE_TEST_SUITE_P(Check, PlantedFault, ::testing::ValuesIn(kFaults),
						 [](const auto& fault) { return std::string(fault.param.name); });
}  // namespace clod::test
