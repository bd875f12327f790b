// SPDX-License-Identifier: Zlib
// One level of each body that answers all contacts of a query: what a certified limit, the same everywhere, is kept by.
// The trees of primary children above two levels cost less than half of what choosing a level at each contact does.
#pragma once
#include "clod/Export.h"
#include "clod/query/QueryContext.h"

namespace clod
{
// No node above them answers. Input surfaces: 0 and 0.
struct BaseLevels
{
	std::uint32_t a = kNone, b = kNone;
	bool isUsed() const { return a != kNone; }
	bool isOfLeaves() const { return a == 0 && b == 0; }
	bool operator==(const BaseLevels& other) const { return a == other.a && b == other.b; }
	bool operator!=(const BaseLevels& other) const { return !(*this == other); }
};

// Of the levels whose worst nodes keep the limit together those with the fewest pairs of nodes, unless of others
// far fewer boxes meet (meetingBoxes): those of long patches meet many that touch none. O(levels).
// isAlone: no threshold asks for finer nodes here and there; where one does, the input surfaces or none.
CLOD_API BaseLevels chooseBaseLevels(const QueryContext& context, double maxError, bool isAlone);
}  // namespace clod
