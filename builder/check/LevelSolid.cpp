// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/check/LevelSolid.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <map>
#include <tuple>

namespace clod::check
{
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

struct LevelSolid::Inside
{
	Mesh mesh;
	std::unique_ptr<CGAL::Side_of_triangle_mesh<Mesh, Kernel>> side;
};

LevelSolid::LevelSolid(const Subject& subject, const Level& level) : m_surface(subject.levelTriangles(level))
{
}

LevelSolid::~LevelSolid() = default;

void LevelSolid::prepare() const
{
	m_inside = std::make_unique<Inside>();
	std::map<std::tuple<double, double, double>, std::size_t> number;
	std::vector<Kernel::Point_3> points;
	std::vector<std::vector<std::size_t>> polygons;
	for (const Triangle& t : m_surface.triangles())
	{
		std::vector<std::size_t> corners;
		for (const Vec3& p : t)
		{
			const auto [entry, isNew] = number.emplace(std::tuple(p.x, p.y, p.z), points.size());
			if (isNew) points.emplace_back(p.x, p.y, p.z);
			corners.push_back(entry->second);
		}
		polygons.push_back(corners);
	}
	CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, polygons, m_inside->mesh);
	m_inside->side = std::make_unique<CGAL::Side_of_triangle_mesh<Mesh, Kernel>>(m_inside->mesh);
	(*m_inside->side)(points.front());  // builds its tree before threads share it
}

bool LevelSolid::holds(const Vec3& p) const
{
	std::call_once(m_prepared, [this] { prepare(); });
	return (*m_inside->side)(Kernel::Point_3(p.x, p.y, p.z)) != CGAL::ON_UNBOUNDED_SIDE;
}
}  // namespace clod::check
