// SPDX-License-Identifier: Zlib
// Bodies of the matrix: a mesh centred at its centre of mass, Bullet's own solid of the same size where there is one,
// and the hierarchy of the mesh.
#pragma once
#include <map>
#include <optional>
#include <string>

#include "demos/models/Models.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
struct Solid
{
	std::string name;  // one mesh a name
	ModelMesh mesh;
	bool isConvex = false;
	std::optional<SceneShape> primitive = {};
};

Solid boxSolid(const Vec3& size, std::size_t triangles = 12);
Solid ballSolid(double radius, std::size_t triangles);
Solid cylinderSolid(double radius, double height, int sides);  // about y
Solid tubeSolid(double inner, double outer, double height, int sides);
Solid torusSolid(double ring, double tube, std::size_t triangles);  // flat in y
int torusSections(std::size_t triangles);
// A benchmark model or a part of a mechanism, all lengths times a factor.
Solid partSolid(const std::string& model, std::size_t triangles, double scale, bool isConvex = false);

// Builds every mesh once.
class Workshop
{
public:
	explicit Workshop(HierarchyCache& cache) : m_cache(cache) {}
	HierarchyPointer hierarchy(const Solid& solid);
	HierarchyCache& cache() { return m_cache; }

private:
	HierarchyCache& m_cache;
	std::map<std::string, HierarchyPointer> m_hierarchies;
};
}  // namespace clod::demo
