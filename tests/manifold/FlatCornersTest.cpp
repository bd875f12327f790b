// SPDX-License-Identifier: GPL-3.0-or-later
// What is left out of facets in one plane is implied by what is kept: whatever rigid motion the kept ones allow, the others allow it
// but for the tolerances.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "clod/manifold/FlatCorners.h"

namespace clod::test
{
namespace
{
constexpr double kBeside = 0.1, kBeneath = 2e-5;  // of the length, FlatCorners.cpp

struct Plane
{
	Vec3 normal, u, v;
	explicit Plane(const Vec3& n) : normal(normalized(n)), u(normalized(cross(n, {0.3, -0.2, 0.9}))), v(cross(normal, u)) {}
	Facet at(double x, double y, double distance) const
	{
		Facet facet{};
		facet.kind = Facet::Kind::kVertexFace;
		facet.onA = Vec3{1, 2, 3} + x * u + y * v;
		facet.onB = facet.onA - distance * normal;
		facet.normal = normal;
		facet.distance = facet.then = distance;
		return facet;
	}
};
std::size_t count(const std::vector<char>& needed)
{
	return std::size_t(std::count(needed.begin(), needed.end(), 1));
}
}  // namespace

TEST(FlatCorners, ImplyWhatIsLeftOut)
{
	std::mt19937 random(1);
	std::uniform_real_distribution<double> uniform(-1, 1);
	FlatCorners corners;
	std::size_t kept = 0, all = 0;
	for (int round = 0; round < 300; ++round)
	{
		const double length = round % 2 ? 1 : 0.01, bow = round % 3 ? 0 : round % 2 ? 3e-3 : -1e-3,
					 bowThen = round % 4 ? 0 : 3e-3;
		const Plane plane({uniform(random), uniform(random), uniform(random)});
		std::vector<Facet> facets;
		for (int i = 0; i < 5 + round % 90; ++i)
		{
			const double x = uniform(random), y = (round % 5 ? 1 : 1e-9) * uniform(random);
			const double square = x * x + y * y;
			facets.push_back(plane.at(length * x, length * y, length * (1e-3 + 2e-4 * x + bow * square + 1e-5 * uniform(random))));
			facets.back().then = length * (5e-4 - 1e-4 * x + 3e-4 * y + bowThen * square + 1e-5 * uniform(random));
		}
		std::vector<char> known(facets.size()), needed;
		for (char& each : known) each = uniform(random) > 0.5;
		corners.choose(facets, length, known, needed);
		ASSERT_EQ(needed.size(), facets.size());
		if (bow == 0 && bowThen == 0)
		{
			kept += count(needed);
			all += facets.size();
		}
		for (int motion = 0; motion < 50; ++motion)
		{
			// What the motion closes by at a place, as much as those that are kept allow.
			const double alongU = 0.01 * uniform(random), alongV = 0.01 * uniform(random);
			const Vec3 slope = alongU * plane.u + alongV * plane.v;
			for (double Facet::*distance : {&Facet::distance, &Facet::then})
			{
				double most = 1e9;
				for (std::size_t i = 0; i < facets.size(); ++i)
					if (needed[i]) most = std::min(most, facets[i].*distance - dot(slope, facets[i].onA));
				for (std::size_t i = 0; i < facets.size(); ++i)
				{
					const double left = facets[i].*distance - dot(slope, facets[i].onA) - most;
					// Beside the span heights are those of its border.
					ASSERT_GT(left, -1.01 * length * (kBeneath + kBeside * (std::sqrt(lengthSquared(slope)) + 4e-3)));
				}
			}
		}
	}
	EXPECT_LT(kept, all / 3);
}

TEST(FlatCorners, AreTheOutermostOfAFlat)
{
	const Plane plane({0, 1, 0});
	std::vector<Facet> facets;
	for (int x = 0; x <= 10; ++x)
		for (int y = 0; y <= 10; ++y) facets.push_back(plane.at(0.1 * x, 0.1 * y, 1e-4));
	std::vector<char> needed;
	FlatCorners corners;
	corners.choose(facets, 1, std::vector<char>(facets.size()), needed);
	EXPECT_EQ(count(needed), 4u);
	for (const int corner : {0, 10, 110, 120}) EXPECT_EQ(needed[std::size_t(corner)], 1);
	// One inside that is lower carries instead.
	facets[60].distance = facets[60].then = 0;
	corners.choose(facets, 1, std::vector<char>(facets.size()), needed);
	EXPECT_EQ(needed[60], 1);
	// Of another plane, or on its own: each needed.
	facets.push_back(Plane({0, 1, 0.1}).at(0.5, 0.5, 1e-4));
	corners.choose(facets, 1, std::vector<char>(facets.size()), needed);
	EXPECT_EQ(needed.back(), 1);
}
}  // namespace clod::test
