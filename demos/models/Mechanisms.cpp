// SPDX-License-Identifier: Zlib
// Parts cut from plates with pins and holes, and the list of all parts.
#include "demos/models/Mechanisms.h"

#include <cctype>
#include <cstdlib>

#include "demos/models/Prism.h"

namespace clod::demo
{
namespace
{
// Pieces of round loops, as a share of those of straight ones: joints turn smoothly.
constexpr double ROUND = 0.3, HALF_ROUND = 0.6;
constexpr double HOLE_RADIUS = PIN_RADIUS + PIN_PLAY;

// A plate with a flanged pin on it: `plate` are loops, the pin stands at `place`.
Prism withPin(std::vector<Loop> plate, double thickness, const PlanarPoint& place, double edge)
{
	Prism prism;
	prism.bottom = -thickness / 2;
	prism.layers.push_back({{}, thickness});
	for (Loop& loop : plate)
	{
		prism.layers[0].loops.push_back(prism.loops.size());
		prism.loops.push_back(std::move(loop));
	}
	const size_t shaft = prism.loops.size();
	prism.loops.push_back(discLoop(place, PIN_RADIUS, ROUND * edge));
	prism.loops.push_back(discLoop(place, FLANGE_RADIUS, HALF_ROUND * edge));
	prism.layers.push_back({{shaft}, SHAFT_LENGTH});
	prism.layers.push_back({{shaft + 1}, FLANGE_THICKNESS});
	return prism;
}

Prism spool(double radius, double flangeRadius, double flange, double length, double edge)
{
	return {{discLoop({}, flangeRadius, HALF_ROUND * edge), discLoop({}, radius, ROUND * edge)},
			{{{0}, flange}, {{1}, length}, {{0}, flange}},
			-length / 2 - flange};
}

Prism plain(std::vector<Loop> loops, double thickness)
{
	Prism prism{std::move(loops), {{{}, thickness}}, -thickness / 2};
	for (size_t i = 0; i < prism.loops.size(); ++i) prism.layers[0].loops.push_back(i);
	return prism;
}

Loop armLoop(double toY, double edge)
{
	return stadiumLoop({}, {0, toY}, ARM_HALF_WIDTH, edge, HALF_ROUND * edge);
}

Loop boxLoop(double lowX, double lowY, double highX, double highY, double edge)
{
	return polygonLoop({{lowX, lowY}, {highX, lowY}, {highX, highY}, {lowX, highY}}, edge);
}

Loop reversed(const Loop& loop)
{
	return {loop.rbegin(), loop.rend()};
}

Prism pin(double edge)
{
	return spool(PIN_RADIUS, FLANGE_RADIUS, FLANGE_THICKNESS, SHAFT_LENGTH, edge);
}

Prism peg(double edge)
{
	return spool(PEG_RADIUS, PEG_FLANGE_RADIUS, PEG_FLANGE_THICKNESS, PEG_LENGTH, edge);
}

Prism arm(double edge)
{
	return plain({armLoop(-ARM_LENGTH, edge), holeLoop({}, HOLE_RADIUS, ROUND * edge)}, ARM_THICKNESS);
}

Prism armWithPin(double edge)
{
	return withPin({armLoop(-ARM_LENGTH, edge), holeLoop({}, HOLE_RADIUS, ROUND * edge)}, ARM_THICKNESS,
				   {0, -ARM_LENGTH}, edge);
}

Prism crank(double edge)
{
	// The disc lies a little to the other side, so that the centre of mass is on the axis.
	constexpr double pinVolume =
		PIN_RADIUS * PIN_RADIUS * SHAFT_LENGTH + FLANGE_RADIUS * FLANGE_RADIUS * FLANGE_THICKNESS;
	constexpr double aside = pinVolume * CRANK_THROW / (CRANK_RADIUS * CRANK_RADIUS * CRANK_THICKNESS);
	return withPin({discLoop({0, -aside}, CRANK_RADIUS, HALF_ROUND * edge)}, CRANK_THICKNESS, {0, CRANK_THROW}, edge);
}

Prism rod(double edge)
{
	const double round = ROUND * edge;
	return plain(
		{armLoop(ROD_LENGTH, edge), holeLoop({}, HOLE_RADIUS, round), holeLoop({0, ROD_LENGTH}, HOLE_RADIUS, round)},
		ARM_THICKNESS);
}

Prism piston(double edge)
{
	return withPin({boxLoop(-PISTON_WIDTH / 2, -PISTON_BELOW, PISTON_WIDTH / 2, PISTON_ABOVE, edge)}, PISTON_DEPTH, {},
				   edge);
}

Prism bore(double edge)
{
	const double x = PISTON_WIDTH / 2 + BORE_PLAY, y = PISTON_DEPTH / 2 + BORE_PLAY, wall = BORE_WALL;
	Prism tube = plain({boxLoop(-x - wall, -y - wall, x + wall, y + wall, edge), reversed(boxLoop(-x, -y, x, y, edge))},
					   BORE_LENGTH);
	tube.bottom = 0;
	return tube;
}

Prism plate(double edge)
{
	return plain({discLoop({}, PLATE_RADIUS, ROUND * edge)}, PLATE_THICKNESS);
}

Prism block(double edge)
{
	constexpr double half = BLOCK_WIDTH / 2;
	Prism prism = plain({boxLoop(-half, -half, half, half, edge)}, BLOCK_HEIGHT);
	prism.bottom = 0;
	return prism;
}

Prism socket(double edge)
{
	constexpr double half = SOCKET_WIDTH / 2, in = BLOCK_WIDTH / 2 + SOCKET_PLAY;
	return {{boxLoop(-half, -half, half, half, edge), reversed(boxLoop(-in, -in, in, in, edge))},
			{{{0}, SOCKET_BOTTOM}, {{0, 1}, SOCKET_DEPTH}},
			-SOCKET_DEPTH - SOCKET_BOTTOM};
}

ModelMaker cut(const char* name, size_t triangles, size_t fewest, Prism (*atEdge)(double edge))
{
	return {name, triangles, fewest, [atEdge](size_t count) { return makePrism(count, atEdge); }};
}

constexpr size_t STONE_TRIANGLES = 1280, STONE_MIN_TRIANGLES = 12;

ModelMaker wedge(const std::string& name, int degrees)
{
	return {name, STONE_TRIANGLES, STONE_MIN_TRIANGLES, [degrees](size_t count) { return makeWedge(degrees, count); }};
}

ModelMaker voussoir(const std::string& name, int stones)
{
	return {name, STONE_TRIANGLES, STONE_MIN_TRIANGLES, [stones](size_t count) { return makeVoussoir(stones, count); }};
}

// N of `stem` followed by N, 0 where that is not the name.
int numberAfter(const std::string& name, const std::string& stem)
{
	if (name.compare(0, stem.size(), stem) != 0 || name.size() == stem.size() || name.size() > stem.size() + 4)
		return 0;
	for (size_t i = stem.size(); i < name.size(); ++i)
		if (std::isdigit(static_cast<unsigned char>(name[i])) == 0) return 0;
	return name[stem.size()] == '0' ? 0 : std::atoi(name.c_str() + stem.size());
}
}  // namespace

const std::vector<ModelMaker>& mechanismParts()
{
	static const std::vector<ModelMaker> parts = []
	{
		std::vector<ModelMaker> list = {cut("pin", 1600, 200, pin),
										cut("arm", 1696, 200, arm),
										cut("arm-with-pin", 2400, 300, armWithPin),
										cut("crank", 2000, 200, crank),
										cut("rod", 2000, 240, rod),
										cut("piston", 1600, 160, piston),
										cut("bore", 1200, 40, bore),
										{"rack", 3920, 884, makeRack},
										{"pinion", 2968, 696, makePinion},
										{"chain-link", 1600, 60, makeChainLink},
										{"tumbler", 4000, 200, makeTumbler},
										{"dish", 4000, 200, makeDish},
										cut("plate", 1600, 100, plate),
										cut("peg", 1600, 200, peg),
										cut("block", 600, 12, block),
										cut("socket", 1200, 28, socket)};
		for (int degrees = 20; degrees <= 90; degrees += 10)
			list.push_back(wedge("wedge" + std::to_string(degrees), degrees));
		for (const int stones : {25, 101}) list.push_back(voussoir("voussoir" + std::to_string(stones), stones));
		return list;
	}();
	return parts;
}

ModelMaker mechanismPart(const std::string& name)
{
	for (const ModelMaker& part : mechanismParts())
		if (part.name == name) return part;
	if (const int degrees = numberAfter(name, "wedge"); degrees >= 1 && degrees <= 170) return wedge(name, degrees);
	if (const int stones = numberAfter(name, "voussoir"); stones >= 3 && stones <= 1001) return voussoir(name, stones);
	return {};
}
}  // namespace clod::demo
