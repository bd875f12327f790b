// SPDX-License-Identifier: GPL-3.0-or-later
// Scaled bodies by the checker of built ones: stretched, mirrored and resized they keep every invariant, and a bound that
// is not one is found.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "builder/check/Check.h"
#include "clod/hierarchy/BoundGrid.h"
#include "clod/hierarchy/ScaledHierarchy.h"
#include "tests/query/Bodies.h"
#include "tests/query/Questions.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
namespace
{
const Vec3 kScales[] = {{1.01, 1.01, 1.01}, {-3, -3, -3}, {-1, 1, 1}, {1, 2, 0.5}, {-0.3, -2, 5}, {0.05, 1, 1}};

// The first broken invariant and its element, or what the loader says; empty where all hold.
std::string firstFault(const std::vector<std::byte>& bytes)
{
	const auto hierarchy = Hierarchy::fromBytes(bytes);
	if (!hierarchy) return "load: " + hierarchy.error();
	for (const check::Invariant& invariant : check::checkHierarchy(*hierarchy.value(), {}))
		if (invariant.violations > 0) return invariant.name + ": " + invariant.firstViolation;
	return "";
}
}  // namespace

TEST(CheckScaled, AcceptsScaledBodies)
{
	std::vector<const char*> names = {"number8-600", "cavity-shell", "plate-thin"};
	if (setting("CLOD_CHECK_SCALED", 0) != 0)
		names = {"cup-3000", "spoon-3000", "torus-900", "sphere-300", "ring", "rod", "box-12"};
	for (const char* name : names)
		for (const Vec3& scale : kScales)
		{
			const auto scaled = scaledHierarchy(*body(name).hierarchy, scale);
			ASSERT_TRUE(bool(scaled)) << scaled.error();
			EXPECT_EQ(firstFault(scaled.value()->bytes()), "")
				<< name << " by " << scale.x << " " << scale.y << " " << scale.z;
		}
}

// What scaling could easily get wrong: walls by their old directions, an area by the largest factor, the way inward turned.
TEST(CheckScaled, FindsBoundsThatAreNone)
{
	const struct
	{
		const char* body;
		std::function<void(HierarchyContent&)> plant;
		const char* expected;
	} faults[] = {
		{"number8-600", [](HierarchyContent& c) { c.asset.thinnestWall = boundAtMost(1.01 * double(c.asset.thinnestWall)); },
		 "thinnest-wall"},
		{"plate-thin", [](HierarchyContent& c) { c.asset.thinnestWall = boundAtMost(1.01 * double(c.asset.thinnestWall)); },
		 "thinnest-wall"},
		{"plate-thin", [](HierarchyContent& c) { c.asset.thinnestWall = boundAtMost(0.999 * double(c.asset.thinnestWall)); },
		 "thinnest-wall"},
		{"plate-thin",
		 [](HierarchyContent& c)
		 {
			 for (Face& f : c.faces) f.thickness = boundAtMost(0.03 * double(c.asset.radius));
		 },
		 "face-thickness"},
		{"number8-600",
		 [](HierarchyContent& c)
		 {
			 for (Node& n : c.nodes) n.contactArea *= 16;
		 },
		 "contact-areas"},
		{"number8-600",
		 [](HierarchyContent& c)
		 {
			 Node& n = *std::find_if(c.nodes.begin(), c.nodes.end(), [](const Node& node) { return node.thickness > 0; });
			 n.thickness = boundAtMost(1e-9 * double(c.asset.radius));
			 for (float& part : n.inward) part = -part;
		 },
		 "normals-and-cones"},
	};
	for (const auto& fault : faults)
	{
		HierarchyContent broken = contentOf(*scaledHierarchy(*body(fault.body).hierarchy, {1, 2, 0.5}).value());
		fault.plant(broken);
		const std::string found = firstFault(encode(broken));
		EXPECT_EQ(found.substr(0, found.find(':')), fault.expected) << found;
	}
}
}  // namespace clod::test
