// SPDX-License-Identifier: Zlib
// Wedges of any angle and the stones of an arch.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/models/Prism.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;

ModelMesh bar(const std::vector<PlanarPoint>& corners, double length, size_t triangles)
{
	return makePrism(triangles,
					 [&](double edge) { return Prism{{polygonLoop(corners, edge)}, {{{0}, length}}, -length / 2}; });
}
}  // namespace

ModelMesh makeWedge(double degrees, size_t triangles)
{
	const double halfWidth = WEDGE_HEIGHT * std::tan(degrees / 2 * PI / 180);
	return bar({{0, 0}, {-halfWidth, -WEDGE_HEIGHT}, {halfWidth, -WEDGE_HEIGHT}}, WEDGE_LENGTH, triangles);
}

ModelMesh makeVoussoir(int stones, size_t triangles)
{
	const double half = PI / stones / 2, back = ARCH_JOINT / 2;
	const auto corner = [&](double radius, double side) -> PlanarPoint
	{
		return {side * (radius * std::sin(half) - back * std::cos(half)),
				radius * std::cos(half) + back * std::sin(half)};
	};
	return bar({corner(ARCH_INSIDE, 1), corner(ARCH_OUTSIDE, 1), corner(ARCH_OUTSIDE, -1), corner(ARCH_INSIDE, -1)},
			   ARCH_DEPTH, triangles);
}
}  // namespace clod::demo
