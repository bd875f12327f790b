// SPDX-License-Identifier: Zlib
// Parts of mechanisms that hold together by contact alone, and the sizes that scenes place them by. Metres.
// Parts cut from plates lie in the plane z = 0 with what sticks out of them towards +z. Round things are polygons
// within their circle, holes polygons round it: parts that fit by these numbers are apart at any resolution.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "demos/models/Models.h"

namespace clod::demo
{
struct ModelMaker
{
	std::string name;
	size_t defaultTriangles = 0, minTriangles = 0;
	std::function<ModelMesh(size_t triangles)> make;
};

// All of fixed name: those that scenes use. makeModel knows wedge1 to wedge170 and voussoir3 to voussoir1001 besides.
const std::vector<ModelMaker>& mechanismParts();
// The part of that name; without a maker where there is none.
ModelMaker mechanismPart(const std::string& name);

// Flanged pins and what turns on them: the hole's radius, its plate's thickness, and the room between the flanges.
constexpr double PIN_RADIUS = 0.1, PIN_PLAY = 0.001, PIN_AXIAL_PLAY = 0.001;
constexpr double FLANGE_RADIUS = 0.14, FLANGE_THICKNESS = 0.03;
constexpr double ARM_THICKNESS = 0.1, ARM_LENGTH = 1.0, ARM_HALF_WIDTH = 0.16;
constexpr double SHAFT_LENGTH = ARM_THICKNESS + 2 * PIN_AXIAL_PLAY;
// pin: its shaft's middle is the origin. arm: a hole at the origin, a round end at (0, -ARM_LENGTH). arm-with-pin: at
// that end a pin, on whose shaft a second arm's middle plane is ARM_TO_ARM in front of the first one's.
constexpr double ARM_TO_ARM = ARM_THICKNESS / 2 + SHAFT_LENGTH / 2;

// crank: a disc, its centre of mass on the z axis, its pin at (0, CRANK_THROW). rod: holes at the origin and (0,
// ROD_LENGTH). piston: a block with the pin at the origin. The rod's middle plane is PISTON_TO_ROD and CRANK_TO_ROD in
// front of theirs. bore: a square tube along z for the piston, from 0 to BORE_LENGTH.
constexpr double CRANK_THROW = 0.2, CRANK_RADIUS = 0.36, CRANK_THICKNESS = 0.08, ROD_LENGTH = 0.8;
constexpr double PISTON_WIDTH = 0.4, PISTON_DEPTH = 0.3, PISTON_BELOW = 0.1, PISTON_ABOVE = 0.9;
constexpr double BORE_PLAY = 0.001, BORE_LENGTH = 0.6, BORE_WALL = 0.06;
constexpr double PISTON_TO_ROD = PISTON_DEPTH / 2 + SHAFT_LENGTH / 2;
constexpr double CRANK_TO_ROD = CRANK_THICKNESS / 2 + SHAFT_LENGTH / 2;

// rack: along y, teeth on both sides, one at y = 0; its pitch lines are x = +-RACK_PITCH_LINE. pinion: about the
// origin, a gap on the x axis on either side. BACKLASH is along the pitch line.
constexpr int PINION_TEETH = 18, RACK_TEETH = 25;
constexpr double TOOTH_MODULE = 0.002, RACK_PITCH_LINE = 0.010, BACKLASH = 0.0002;
constexpr double PINION_PITCH_RADIUS = TOOTH_MODULE * PINION_TEETH / 2;

// chain-link: a round wire bent to a loop in the plane z = 0, long in x. Taut links are CHAIN_PITCH apart.
constexpr double LINK_WIRE = 0.0025, LINK_BEND = 0.006, LINK_HALF_STRAIGHT = 0.008;
constexpr double CHAIN_PITCH = 2 * (LINK_HALF_STRAIGHT + LINK_BEND - LINK_WIRE);

// voussoirN: one of N stones of a half circle of an arch about the z axis, the one at the top.
constexpr double ARCH_INSIDE = 8.5, ARCH_OUTSIDE = 11.5, ARCH_DEPTH = 3, ARCH_JOINT = 0.001;

// wedgeN: an edge of N degrees along z through the origin, the body below it.
constexpr double WEDGE_HEIGHT = 0.020, WEDGE_LENGTH = 0.040;

// tumbler: a cup with a cone for a wall that stands on y = 0. Stacked ones touch all round TUMBLER_PITCH apart.
constexpr double TUMBLER_HEIGHT = 0.060, TUMBLER_FOOT = 0.020, TUMBLER_TOP = 0.0327, TUMBLER_WALL = 0.0016;
extern const double TUMBLER_PITCH;
// dish: a part of a hollow ball whose middle is the origin; a ball of this radius keeps clear of its inside.
constexpr double DISH_RADIUS = 0.060, DISH_WALL = 0.003;

// plate: a flat disc, its axis z. peg: a flanged pin for the smooth torus to hang on. block and socket: a loose fit
// along z; the socket's opening is z = 0, the block's lower face too.
constexpr double PLATE_RADIUS = 0.030, PLATE_THICKNESS = 0.003;
constexpr double PEG_RADIUS = 0.005, PEG_FLANGE_RADIUS = 0.009, PEG_FLANGE_THICKNESS = 0.003, PEG_LENGTH = 0.024;
constexpr double BLOCK_WIDTH = 0.020, BLOCK_HEIGHT = 0.030, SOCKET_PLAY = 0.00005, SOCKET_DEPTH = 0.020;
constexpr double SOCKET_WIDTH = 0.036, SOCKET_BOTTOM = 0.006;

ModelMesh makePinion(size_t triangles);
ModelMesh makeRack(size_t triangles);
ModelMesh makeChainLink(size_t triangles);
ModelMesh makeWedge(double degrees, size_t triangles);
ModelMesh makeVoussoir(int stones, size_t triangles);
ModelMesh makeTumbler(size_t triangles);
ModelMesh makeDish(size_t triangles);
}  // namespace clod::demo
