// SPDX-License-Identifier: GPL-3.0-or-later
// Down the primary tree: culling boxes enclose every thickened hull, and the stored Hausdorff distance bounds how far
// any descendant's hull leaves the node's own (largest at a vertex, as the distance to a convex set is convex).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/check/Subject.h"

namespace clod::check
{
// Also used for the surface a node answers for.
double outsideBox(const OrientedBox& box, const Vec3& p)
{
	const Vec3 d = p - toVec3(box.center);
	double excess = length(d) - double(box.radius);
	for (int i = 0; i < 3; ++i) excess = std::max(excess, std::abs(dot(toVec3(box.axis[i]), d)) - double(box.half[i]));
	return excess;
}

Invariants checkCulling(const Subject& s)
{
	Tally boxes("culling-boxes"), hausdorff("hausdorff");
	std::vector<std::vector<Vec3>> hulls(s.h.nodes().size);
	for (std::uint32_t i = 0; i < hulls.size(); ++i) hulls[i] = s.thickHull(i);
	s.forEach("culling", hulls.size(),
			  [&](std::size_t index)
			  {
				  const std::uint32_t i = std::uint32_t(index);
				  for (std::uint32_t up = i; up != kNone; up = s.primaryParent[up])
				  {
					  double outside = 0, beyond = 0;
					  const double stored = double(s.h.node(up).hausdorff);
					  const bool measured = up != i && s.isContact(i);
					  for (const Vec3& p : hulls[i])
					  {
						  outside = std::max(outside, outsideBox(s.h.cullBox(up), p));
						  if (measured)
							  beyond = std::max(beyond, distanceToHull(hulls[up], p, 0.5 * s.slack, stored) - stored);
					  }
					  boxes.add(i, outside - s.slack,
								fmt::format("the hull of node {} leaves the culling box of node {} by {:.3g}", i, up,
											outside));
					  if (measured)
						  hausdorff.add(i, beyond - s.slack,
										fmt::format("the hull of node {} is {:.3g} farther from that of node {} than "
													"its hausdorff {:.6g}",
													i, beyond, up, stored));
				  }
			  });
	return {boxes.result(), hausdorff.result()};
}
}  // namespace clod::check
