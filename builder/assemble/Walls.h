// SPDX-License-Identifier: GPL-3.0-or-later
// Local wall thickness of the input solid, and how far a patch may be swept into it.
#pragma once
#include "builder/assemble/Draft.h"
#include "builder/assemble/Protrusion.h"

namespace clod::builder
{
// Distance from the input point nearest to p, into the solid along direction, to the opposite side; infinity if none.
double wallBehind(const Solid& solid, const Vec3& p, const Vec3& direction);

// Sets thickness (at most half the local wall along inward, measured from the input surface the node answers for) and
// protrude. The sweep is shortened, to zero if need be, until it does not make the node stick out farther.
void thicken(NodeDraft& node, const Solid& solid, const ProtrusionScale& scale);
}  // namespace clod::builder
