// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/library/Asset.h"

#include "builder/assemble/BoundingSphere.h"

namespace clod::builder
{
double radiusOf(const Soup& soup)
{
	std::vector<Vec3> used;
	for (const std::uint32_t corner : soup.corners)
		if (corner < soup.vertices.size() && isFinite(soup.vertices[corner])) used.push_back(soup.vertices[corner]);
	return used.empty() ? 0 : boundingSphere(used).radius;
}

Repaired solidOf(const Soup& soup, const Mending& mending, const Progress& progress)
{
	if (mending.wrap) return wrapAround(soup, *mending.wrap, mending.mostTriangles, progress);
	if (mending.repair) return repair(soup, mending.maxMove ? *mending.maxMove : kMaxMove * radiusOf(soup), progress);
	Repaired asItIs;
	asItIs.solid = intake(soup);
	return asItIs;
}

HierarchyContent buildAsset(const Intake& solid, const BuildConfig& config, const Progress& progress)
{
	HierarchyContent content = buildHierarchy(solid.mesh, config, progress);
	for (int i = 0; i < 3; ++i) content.asset.meshFromBody[i] = solid.meshFromBody[i];
	content.asset.componentCount = std::uint32_t(solid.componentCount);
	return content;
}
}  // namespace clod::builder
