// SPDX-License-Identifier: Zlib
// What a front has of each pair of nodes.
#pragma once
#include <cstdint>

#include "clod/collide/SeparatingAxis.h"
#include "clod/hierarchy/Layout.h"

namespace clod
{
enum class NodePairState : std::uint8_t
{
	kSeparated,   // culling volumes are farther apart than the tolerance: only the pair of roots is kept then
	kElsewhere,   // met before in this walk, through other parents
	kOpenA,       // replaced by the children of a
	kOpenB,       // replaced by the children of b
	kHullsApart,  // not accepted, and nothing the two nodes answer for is within the tolerance (HullCull.h)
	kAnswer       // accepted by the stop rule, culling volumes within the tolerance
};
inline bool isOpen(NodePairState state)
{
	return state == NodePairState::kOpenA || state == NodePairState::kOpenB;
}

// Bounds are of the pose of the last finished traversal, in float, rounded outward.
struct FrontEntry
{
	std::uint32_t a, b;
	std::uint32_t link = kNone;    // opened: its first child in entries
	std::uint32_t hull = kNone;    // its place in hulls
	std::uint16_t childCount = 0;  // of link
	std::uint16_t slot = 0;        // its number among the children of the node opened above it
	float high = 0;                // the separation of the culling volumes is less
	float apart = 0;               // opened: that of every child which is not kept exceeds
	std::uint32_t old = kNone;     // its entry in the traversal before
	NodePairState state = NodePairState::kSeparated;
	bool whileApart = false;  // answers, or is opened, as its hulls are apart, or not
};
static_assert(sizeof(FrontEntry) == 36);
}  // namespace clod
