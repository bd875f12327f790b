// SPDX-License-Identifier: Zlib
// Edges and corners of a body that go on in another one joined to it, as where plates lie flush that are fixed, or children
// of one compound: the two together have none there, and what slides over both must not feel any. A pair does not know of
// other bodies; those are told here.
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
// A body that moves with one of a pair and that the other one may touch, too.
struct JoinedBody
{
	const ContactSurface* surface = nullptr;  // its own frame and unit
	Transform bodyFromA;                      // the translation in A's unit, as all of a point that it is applied to;
	double scale = 1;                         // units of the body that are one of A's
	double radius = 0;                        // that the body is grown by, its own unit,
	double rounding = 0;                      // and by which its surface may be elsewhere than meant
	Vec3 center;                              // of a ball round it, its own frame and unit,
	double reach = 0;                         // and the ball's radius, growth included
};

// Those joined to either body of a pair.
struct JoinedBodies
{
	std::vector<JoinedBody> toA, toB;
	bool isEmpty() const { return toA.empty() && toB.empty(); }
};

// Is the facet one of an edge or a corner that goes on in a body joined to its own?
CLOD_API bool isAtSeam(const FacetQuestion& question, const JoinedBodies& joined, const Facet& facet);
}  // namespace clod
