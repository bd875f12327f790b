// SPDX-License-Identifier: Zlib
// A link of a chain: a round wire bent to two half circles and two straight sides.
#include <cmath>

#include "demos/models/Mechanisms.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double LENGTH = 2 * PI * LINK_BEND + 4 * LINK_HALF_STRAIGHT;  // of the wire's middle

struct WirePoint
{
	Vec3 middle, outward;
};

// Once round, from the middle of one straight side.
WirePoint wireAt(double turn)
{
	double way = turn * LENGTH;
	double sign = 1;
	if (way > LENGTH / 2) way -= LENGTH / 2, sign = -1;
	Vec3 outward = {0, -sign, 0}, bend;
	if (way < LINK_HALF_STRAIGHT)
		bend = {sign * way, 0, 0};
	else if (way > LENGTH / 2 - LINK_HALF_STRAIGHT)
	{
		outward = {0, sign, 0};
		bend = {sign * (LENGTH / 2 - way), 0, 0};
	}
	else
	{
		const double angle = (way - LINK_HALF_STRAIGHT) / LINK_BEND - PI / 2;
		outward = {sign * std::cos(angle), sign * std::sin(angle), 0};
		bend = {sign * LINK_HALF_STRAIGHT, 0, 0};
	}
	return {bend + LINK_BEND * outward, outward};
}
}  // namespace

ModelMesh makeChainLink(size_t triangles)
{
	return ringGrid(ringSize(triangles, LENGTH / (2 * PI * LINK_WIRE)),
					[](double section, double turn)
					{
						const WirePoint wire = wireAt(turn);
						const double angle = 2 * PI * section;
						return wire.middle +
							   LINK_WIRE * (std::cos(angle) * wire.outward + std::sin(angle) * Vec3{0, 0, 1});
					});
}
}  // namespace clod::demo
