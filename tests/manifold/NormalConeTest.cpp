// SPDX-License-Identifier: GPL-3.0-or-later
// Which edges can face a cone of normals: compared with places all along the arc between an edge's two normals.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clod/manifold/MovedNode.h"

namespace clod::test
{
namespace
{
class Directions
{
public:
	Vec3 next() { return normalized(Vec3{m_normal(m_random), m_normal(m_random), m_normal(m_random)}); }

private:
	std::mt19937 m_random{1};
	std::normal_distribution<double> m_normal;
};

TEST(NormalCone, IsFacedByAnEdgeOneOfWhoseNormalsLooksIntoIt)
{
	constexpr int kPlaces = 500;
	Directions directions;
	int between = 0, facing = 0;
	for (int i = 0; i < 6000; ++i)
	{
		const NormalCone cone{directions.next(), 0.9};
		const Vec3 from = directions.next(), to = directions.next();
		if (dot(from, to) < -0.95) continue;  // the arc between them is any
		const double least = 0.2 + 0.7 * (i % 10) / 10.0;
		double ends = std::max(-dot(cone.axis, from), -dot(cone.axis, to)), nearest = ends;
		for (int k = 1; k < kPlaces; ++k)
		{
			const double share = double(k) / kPlaces;
			nearest = std::max(nearest, -dot(cone.axis, normalized((1 - share) * from + share * to)));
		}
		if (std::fabs(nearest - least) < 1e-4) continue;
		EXPECT_EQ(cone.isFacedBy(from, to, least), nearest > least) << i;
		EXPECT_EQ(cone.isFacedBy(to, from, least), nearest > least) << i;
		facing += nearest > least;
		between += nearest > least && ends < least;
	}
	EXPECT_GT(between, 100);  // the middle of the arc alone looks into the cone
	EXPECT_GT(facing - between, 300);
	EXPECT_LT(facing, 4000);
	EXPECT_TRUE(NormalCone{}.isFacedBy({}, {0, 0, 1}, 0.99)) << "of a thin core: any";
}

TEST(NormalCone, AnglesAddUpToAQuarterOfATurn)
{
	for (const double ofCone : {0.0, 0.3, 0.9})
		for (const double ofSlack : {0.1, 0.5, 0.7})
		{
			const double least = NormalCone{{0, 0, 1}, std::cos(ofCone)}.leastCosine(std::cos(ofSlack));
			EXPECT_NEAR(least, ofCone + ofSlack < std::acos(0.0) ? std::cos(ofCone + ofSlack) : -1, 1e-12);
		}
	EXPECT_EQ(NormalCone{}.leastCosine(0.9), -1) << "of all directions";
}
}  // namespace
}  // namespace clod::test
