// SPDX-License-Identifier: Zlib
// A depth that no facet answers: bodies overlap so far that what is inside has lost sight of the surface. One direction
// for the pair, and one point to push at: the direction kept from the step before, else the mean way out of what is
// inside, else the shortest way out of the hulls.
#pragma once
#include <optional>
#include <vector>

#include "clod/manifold/FacetFinder.h"

namespace clod
{
struct DeepAnswer
{
	Vec3 point, normal;  // from B to A
	double depth = 0;
	std::uint32_t nodeA = 0, nodeB = 0;
};

class DeepOverlap
{
public:
	// Empty where nothing is found inside. kept: a direction to go on with, or zero.
	std::optional<DeepAnswer> find(const FacetQuestion& question, const std::vector<Contact>& contacts,
								   const Vec3& kept);

private:
	struct Inside
	{
		Vec3 point, way;  // out of B for A's points, and for B's the way A has to go; length: the depth
	};
	void probe(const FacetQuestion& question, const Contact& contact, bool ofA);
	Vec3 wayOut(const FacetQuestion& question, const std::vector<Contact>& contacts, const Vec3& kept) const;
	std::vector<Inside> m_inside;
};
}  // namespace clod
