// SPDX-License-Identifier: Zlib
// Bullet's own convex shapes as their partners meet them: one-piece hierarchies (hierarchy/ConvexPiece.h) grown by a
// radius, so that a box, a hull or a sphere is met by the same code as another body of ours.
//
// Exact are: a box with its corners sharp, margin included; polyhedra and triangle meshes' hulls by their vertices,
// grown by their margin; spheres, capsules and multi-spheres of one radius; and what of these is scaled uniformly. A
// cylinder or a cone is a prism or a pyramid whose sides are within half the skin of it, grown by its margin; whatever
// else has a support function is an inner polyhedron of as many corners as that takes, but no more than kMostCorners,
// grown by its margin.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"

class btConvexShape;

namespace clod
{
struct ConvexPartner
{
	std::vector<double> shape;  // all that makes it, or what is seen of it and where it is; and the unit
	std::shared_ptr<const Hierarchy> hierarchy;  // none where the shape cannot be used,
	std::string problem;                         // and why
	double radius = 0;  // that the hierarchy is grown by
	double error = 0;   // how far the shape may reach out of what stands for it
	std::vector<std::array<Vec3, 2>> answers;  // all that a support function was asked, directions and points
};

// Those of a world. May be used by several threads.
class ConvexPartners
{
public:
	// In units of `unit` world lengths. known: the last answer, or null; it comes back while the shape is as it was (if
	// known by its support only, in 26 directions). Cost: a look at the shape's numbers or vertices; anew some 20 us
	// for a box, a third of a millisecond for a hull of 100 vertices, 0.05 s for 10,000.
	std::shared_ptr<const ConvexPartner> of(const btConvexShape& shape, double unit,
											const std::shared_ptr<const ConvexPartner>& known);

private:
	std::shared_ptr<const ConvexPartner> find(const std::vector<double>& key);
	void keep(const std::vector<double>& key, const std::shared_ptr<const ConvexPartner>& partner);

	std::mutex m_mutex;
	std::map<std::vector<double>, std::shared_ptr<const ConvexPartner>> m_partners;
};
}  // namespace clod
