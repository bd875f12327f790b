// SPDX-License-Identifier: GPL-3.0-or-later
// What can be wrong in a stored hierarchy: every field of every record, and every way to spoil it. Written from
// Layout.h alone; CheckFaultListTest.cpp plants them one at a time, with right checksums.
#pragma once
#include <cstddef>
#include <vector>

#include <clod/hierarchy/Hierarchy.h>

namespace clod::test
{
enum class Record
{
	asset,
	level,
	node,
	cullBox,
	face,
	child,
	hullX,
	hullY,
	hullZ
};
enum class Stored
{
	real32,
	real64,
	index32,
	index16
};
enum class Spoil
{
	sign,      // reals: negated
	ulpUp,     // reals: the next one up; indices: one more
	ulpDown,   // reals: the next one down; indices: one less
	swap,      // exchanged with the same field of the next record, in the asset and in vectors with the next component
	omission,  // zero
};
inline constexpr Spoil kSpoils[] = {Spoil::sign, Spoil::ulpUp, Spoil::ulpDown, Spoil::swap, Spoil::omission};
inline constexpr const char* kSpoilNames[] = {"sign", "ulp up", "ulp down", "swap", "omission"};

struct Field
{
	Record record;
	const char* name;
	Stored stored;
	std::size_t offset;  // in the record
	int components = 1;
};

#define CLOD_FIELD(record, type, member, stored, components)                        \
	{                                                                               \
		Record::record, #member, Stored::stored, offsetof(type, member), components \
	}
inline const std::vector<Field> kFields = {
	CLOD_FIELD(asset, Asset, volume, real64, 1),
	CLOD_FIELD(asset, Asset, inertia, real64, 6),
	CLOD_FIELD(asset, Asset, principal, real64, 4),
	CLOD_FIELD(asset, Asset, buildSeconds, real64, 1),
	CLOD_FIELD(asset, Asset, sphereCenter, real32, 3),
	CLOD_FIELD(asset, Asset, radius, real32, 1),
	CLOD_FIELD(asset, Asset, boxMin, real32, 3),
	CLOD_FIELD(asset, Asset, boxMax, real32, 3),
	CLOD_FIELD(asset, Asset, storageTolerance, real32, 1),
	CLOD_FIELD(asset, Asset, areaTolerance, real32, 1),
	CLOD_FIELD(asset, Asset, thinnestWall, real32, 1),
	CLOD_FIELD(asset, Asset, flags, index32, 1),
	CLOD_FIELD(asset, Asset, triangleCount, index32, 1),
	CLOD_FIELD(asset, Asset, componentCount, index32, 1),
	CLOD_FIELD(level, Level, firstNode, index32, 1),
	CLOD_FIELD(level, Level, nodeCount, index32, 1),
	CLOD_FIELD(level, Level, firstFace, index32, 1),
	CLOD_FIELD(level, Level, faceCount, index32, 1),
	CLOD_FIELD(level, Level, flags, index32, 1),
	CLOD_FIELD(level, Level, maxHausdorff, real32, 1),
	CLOD_FIELD(level, Level, maxDeviation, real32, 1),
	CLOD_FIELD(level, Level, maxCover, real32, 1),
	CLOD_FIELD(level, Level, maxProtrude, real32, 1),
	CLOD_FIELD(level, Level, maxSurf, real32, 1),
	CLOD_FIELD(level, Level, patchTolerance, real32, 1),
	CLOD_FIELD(node, Node, firstChild, index32, 1),
	CLOD_FIELD(node, Node, childCount, index16, 1),
	CLOD_FIELD(node, Node, primaryChildCount, index16, 1),
	CLOD_FIELD(node, Node, firstVertex, index32, 1),
	CLOD_FIELD(node, Node, vertexCount, index32, 1),
	CLOD_FIELD(node, Node, firstFace, index32, 1),
	CLOD_FIELD(node, Node, faceCount, index32, 1),
	CLOD_FIELD(node, Node, level, index32, 1),
	CLOD_FIELD(node, Node, flags, index32, 1),
	CLOD_FIELD(node, Node, thickness, real32, 1),
	CLOD_FIELD(node, Node, inward, real32, 3),
	CLOD_FIELD(node, Node, cover, real32, 1),
	CLOD_FIELD(node, Node, reach, real32, 1),
	CLOD_FIELD(node, Node, protrude, real32, 1),
	CLOD_FIELD(node, Node, surf, real32, 1),
	CLOD_FIELD(node, Node, deviation, real32, 1),
	CLOD_FIELD(node, Node, resolution, real32, 1),
	CLOD_FIELD(node, Node, featureVolume, real32, 1),
	CLOD_FIELD(node, Node, contactArea, real32, 1),
	CLOD_FIELD(node, Node, hausdorff, real32, 1),
	CLOD_FIELD(node, Node, curvature, real32, 1),
	CLOD_FIELD(node, Node, meanNormal, real32, 3),
	CLOD_FIELD(node, Node, coneCosine, real32, 1),
	CLOD_FIELD(cullBox, OrientedBox, center, real32, 3),
	CLOD_FIELD(cullBox, OrientedBox, radius, real32, 1),
	CLOD_FIELD(cullBox, OrientedBox, axis, real32, 9),
	CLOD_FIELD(cullBox, OrientedBox, half, real32, 3),
	CLOD_FIELD(face, Face, vertex, index16, 3),
	CLOD_FIELD(face, Face, neighbour, index32, 3),
	CLOD_FIELD(face, Face, normal, real32, 3),
	CLOD_FIELD(face, Face, offset, real32, 1),
	CLOD_FIELD(face, Face, thickness, real32, 1),
	CLOD_FIELD(face, Face, source, index32, 1),
	{Record::child, "child", Stored::index32, 0},
	{Record::hullX, "x", Stored::real32, 0},
	{Record::hullY, "y", Stored::real32, 0},
	{Record::hullZ, "z", Stored::real32, 0},
};
#undef CLOD_FIELD
// Not listed: Asset::meshFromBody, which only the mesh's own file can tell (check --mesh does), and the padding.
}  // namespace clod::test
