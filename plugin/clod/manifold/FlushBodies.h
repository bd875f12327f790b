// SPDX-License-Identifier: Zlib
// Edges and corners of a fixed body that go on in another fixed one, as where plates lie flush: the two together have
// none there, and what slides over both must not feel any. A pair does not know of other bodies; those are told here.
//
// An edge goes on where one of its faces does, straight on or rising: then the two meet flat or in a reflex edge. A corner
// goes on if an edge does that leads to it.
//
// Frame and unit: body A's. Departs from Otaduy & Lin 2003, who treat each pair for itself.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/Facet.h"

namespace clod
{
// A fixed body that the moving one of a pair may touch, too.
struct FixedBody
{
	const ContactSurface* surface = nullptr;  // its own frame and unit
	Transform bodyFromA;                      // the translation in A's unit, as all of a point that it is applied to;
	double scale = 1;                         // units of the body that are one of A's
	double radius = 0;                        // that the body is grown by, its own unit,
	double rounding = 0;                      // and by which its surface may be elsewhere than meant
	Vec3 center;                              // of a ball round it, its own frame and unit,
	double reach = 0;                         // and the ball's radius, growth included
};

// Those of a pair, one body of which is fixed, too.
struct FixedBodies
{
	bool fixedIsB = false;
	std::vector<FixedBody> others;
};

// Is the facet one of an edge or a corner of the pair's fixed body that goes on in another?
CLOD_API bool isAtSeam(const FacetQuestion& question, const FixedBodies& fixed, const Facet& facet);
}  // namespace clod
