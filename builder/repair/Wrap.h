// SPDX-License-Identifier: GPL-3.0-or-later
// Alpha wrap (Portaneri et al. 2022, CGAL 5.5): a closed 2-manifold that encloses every triangle given.
#pragma once
#include <optional>

#include "builder/Lod.h"

namespace clod::builder
{
// Its vertices are `offset` from the triangles, but where it bridges gaps narrower than about `alpha`.
// Tells its progress as a share of the vertices expected. None where it has more than the most vertices.
struct WrapSize
{
	double expected, most;  // vertices
};
std::optional<Mesh> alphaWrap(const Mesh& mesh, double alpha, double offset, const WrapSize& size,
							  const Progress& progress);
}  // namespace clod::builder
