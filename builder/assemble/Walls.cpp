// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Walls.h"

#include <algorithm>
#include <utility>

#include "clod/hierarchy/BoundGrid.h"

namespace clod::builder
{
namespace
{
constexpr std::size_t kWallSamples = 16;

double wallOf(const NodeDraft& node, const Solid& solid)
{
	double wall = std::numeric_limits<double>::infinity();
	const std::size_t step = std::max<std::size_t>(1, node.pieces.size() / kWallSamples);
	for (std::size_t i = 0; i < node.pieces.size(); i += step)
	{
		const Triangle piece = pieceTriangle(solid.tree().triangle(node.pieces[i].face), node.pieces[i]);
		if (dot(areaVector(piece), node.inward) >= 0) continue;
		wall = std::min(wall, solid.tree().exitDistance(centroid(piece), node.inward, 0));
	}
	return wall;
}

Protrusion measured(const NodeDraft& node, const Solid& solid, const ProtrusionScale& scale, double hopeless)
{
	ConvexBody body{node.hullPoints(), {}};
	for (std::size_t i = 0; i < node.faces.size(); ++i) body.realNormals.push_back(areaVector(node.face(i)));
	return protrusion(solid, body, scale, hopeless);
}
}  // namespace

double wallBehind(const Solid& solid, const Vec3& p, const Vec3& direction)
{
	return solid.tree().exitDistance(solid.tree().nearest(p).closest.point, direction, 0);
}

void thicken(NodeDraft& node, const Solid& solid, const ProtrusionScale& scale, const SweepRule& rule)
{
	double attained = scale.rounding;
	for (const Vec3& v : node.vertices) attained = std::max(attained, solid.distance(v));
	const double harmless = std::min(std::max(rule.overVertices * attained, rule.harmless), rule.most);
	const double wall = node.coneCosine > 0 ? wallOf(node, solid) : 0;
	const double half = std::isfinite(wall) ? 0.5 * wall : 0;
	double thin = -1, allowed = harmless;
	const auto measureThin = [&]
	{
		const double thickness = std::exchange(node.thickness, 0);
		thin = measured(node, solid, scale, rule.most).upper;
		node.thickness = thickness;
		allowed = std::max({harmless, thin, std::min(1.1 * thin, rule.most)});
	};
	for (double share : {1.0, 0.6, 0.3, 0.1})
	{
		node.thickness = double(boundAtMost(share * half));
		if (node.thickness <= scale.rounding) break;
		Protrusion thick = measured(node, solid, scale, allowed);
		if (thick.upper > harmless && thin < 0)
		{
			measureThin();
			const bool gaveUp = thick.lower > harmless;
			if (gaveUp && thick.lower <= allowed) thick = measured(node, solid, scale, allowed);
		}
		node.bounds.protrude = thick.upper;
		if (thick.upper <= allowed) return;
	}
	node.thickness = 0;
	if (thin < 0) measureThin();
	node.bounds.protrude = thin;
}
}  // namespace clod::builder
