// SPDX-License-Identifier: GPL-3.0-or-later
// Two ways to cull, one answer: hulls grown by their drift (paper eq. 1), or culling boxes.
#include <gtest/gtest.h>

#include "demos/paper/PaperQuery.h"
#include "tests/fixtures/Recipes.h"
#include "tests/query/Questions.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
namespace
{
using demo::paperQuery;
using demo::paperQueryError;

const Body& paperTorus()
{
	static const Body body = bodyOf("paper's torus", loaded(built(modelMesh("torus", 900), true)));
	return body;
}

TEST(PaperQuery, FindsTheSameLeafPairsAndTheSameGap)
{
	Random random(11);
	const Body& torus = paperTorus();
	std::size_t contacts = 0;
	for (int i = 0; i < 6; ++i)
	{
		const Transform pose = poseWithGap(random, torus, torus, stratifiedGap(random, i));
		const Settings settings = exactSettings(0.02 * smallerRadius(torus, torus));
		const GapResult boxes = fresh({torus, torus}, pose, settings);
		ASSERT_EQ(paperQueryError(*torus.hierarchy, *torus.hierarchy, settings), "");
		GapResult paper;
		paperQuery(*torus.hierarchy, *torus.hierarchy, pose, settings, paper);
		EXPECT_EQ(difference(paper, boxes), "");
		contacts += boxes.contacts.size();
	}
	EXPECT_GT(contacts, 10u);
}

// At a threshold its accepted pairs are those of the plugin's walk wherever these are met in the tree: every bound holds.
TEST(PaperQuery, CertifiesItsGapAtAnyThreshold)
{
	Random random(12);
	const Body& torus = paperTorus();
	for (int i = 0; i < 12; ++i)
	{
		const Transform pose = poseWithGap(random, torus, torus, stratifiedGap(random, i));
		const double radius = smallerRadius(torus, torus);
		Settings settings;
		settings.tolerance = 0.02 * radius;
		settings.metric.weightedDeviation = std::pow(10, uniform(random, -4, 1)) * radius;
		GapResult paper;
		paperQuery(*torus.hierarchy, *torus.hierarchy, pose, settings, paper);
		std::uint32_t finest = paper.contacts.empty() ? paper.stats.finestLevel : kNone;
		std::uint32_t coarsest = paper.contacts.empty() ? paper.stats.coarsestLevel : 0;
		for (const Contact& contact : paper.contacts)
			for (const std::uint32_t node : {contact.nodeA, contact.nodeB})
			{
				finest = std::min(finest, torus.hierarchy->node(node).level);
				coarsest = std::max(coarsest, torus.hierarchy->node(node).level);
			}
		EXPECT_EQ(paper.stats.finestLevel, finest) << i;
		EXPECT_EQ(paper.stats.coarsestLevel, coarsest) << i;
		EXPECT_EQ(broken(paper, triangleGap(torus.triangles, torus.triangles, pose, 1e-3 * radius), settings.tolerance), "") << i;
	}
}

TEST(PaperQuery, RefusesOtherBuilds)
{
	const Hierarchy& h = *body("box", 12).hierarchy;
	EXPECT_NE(paperQueryError(h, h, exactSettings(0)).find("paper"), std::string::npos);
}
}  // namespace
}  // namespace clod::test
