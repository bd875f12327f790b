// SPDX-License-Identifier: GPL-3.0-or-later
// Local wall thickness of the input solid, and how far a patch may be swept into it.
#pragma once
#include "builder/assemble/Draft.h"
#include "builder/assemble/Protrusion.h"

namespace clod::builder
{
// Distance from the input point nearest to p, into the solid along direction, to the opposite side; infinity if none.
double wallBehind(const Solid& solid, const Vec3& p, const Vec3& direction);

// A sweep is taken at once where protrude stays below this.
struct SweepRule
{
	double overVertices;  // times the protrusion of the patch's own vertices
	double harmless;      // absolute: what the deviation is anyway
	double most;          // absolute: never more than this because of the sweep
};

// Sets thickness (at most half the local wall along inward, measured from the input surface the node answers for) and
// protrude. The sweep is shortened, to zero if need be, until it obeys the rule or makes the node stick out no farther
// than without it.
void thicken(NodeDraft& node, const Solid& solid, const ProtrusionScale& scale, const SweepRule& rule);
}  // namespace clod::builder
