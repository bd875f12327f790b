// SPDX-License-Identifier: Zlib
#include "clod/manifold/HeldBetween.h"

#include <algorithm>

namespace clod
{
namespace
{
// Sine of the angle by which a way out has to leave every facet: two normals that are 154 degrees apart leave none.
constexpr double kWayOut = 0.225;
constexpr int kRounds = 64;
}  // namespace

// Finds the shortest vector in the convex hull of the normals (Gilbert, 1966). Its length is the sine of the angle by
// which the best way out leaves the facet that it leaves least.
bool isHeldBetween(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	const auto touches = [&](const Facet& facet) { return facet.hasFeatures() && facet.distance < question.touching(); };
	const auto first = std::find_if(facets.begin(), facets.end(), touches);
	if (first == facets.end()) return false;
	Vec3 shortest = first->normal;
	for (int round = 0; round < kRounds; ++round)
	{
		const double size = length(shortest);
		if (size < kWayOut) return true;
		const Facet* worst = &*first;
		for (const Facet& facet : facets)
			if (touches(facet) && dot(facet.normal, shortest) < dot(worst->normal, shortest)) worst = &facet;
		if (dot(worst->normal, shortest) >= kWayOut * size) return false;
		const Vec3 towards = worst->normal - shortest;
		shortest += std::clamp(-dot(shortest, towards) / lengthSquared(towards), 0.0, 1.0) * towards;
	}
	return false;
}
}  // namespace clod
