// SPDX-License-Identifier: Zlib
// From the patches of a level back to one mesh.
#include "demos/runner/InputSurface.h"

#include <map>

namespace clod::demo
{
ModelMesh inputSurface(const Hierarchy& hierarchy)
{
	return levelSurface(hierarchy, 0);
}

ModelMesh levelSurface(const Hierarchy& hierarchy, std::uint32_t index)
{
	const double(&origin)[3] = hierarchy.asset().meshFromBody;
	const Level& level = hierarchy.levels()[index];
	std::map<std::array<float, 3>, std::uint32_t> indexOf;
	ModelMesh mesh;
	for (std::uint32_t n = level.firstNode; n < level.firstNode + level.nodeCount; ++n)
	{
		const HullView hull = hierarchy.hull(hierarchy.node(n));
		for (const Face& face : hierarchy.faces(hierarchy.node(n)))
		{
			std::array<std::uint32_t, 3> triangle{};
			for (std::size_t i = 0; i < 3; ++i)
			{
				const std::uint16_t v = face.vertex[i];
				const std::array<float, 3> place = {hull.x[v], hull.y[v], hull.z[v]};
				const auto [entry, isNew] = indexOf.insert({place, std::uint32_t(mesh.vertices.size())});
				if (isNew) mesh.vertices.push_back({origin[0] + place[0], origin[1] + place[1], origin[2] + place[2]});
				triangle[i] = entry->second;
			}
			mesh.triangles.push_back(triangle);
		}
	}
	return mesh;
}
}  // namespace clod::demo
