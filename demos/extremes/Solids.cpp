// SPDX-License-Identifier: Zlib
#include "demos/extremes/Solids.h"

#include <fmt/format.h>

#include <cmath>

#include "cli/Failure.h"
#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"
#include "demos/runner/Commands.h"

namespace clod::demo
{
namespace
{
constexpr double kTurn = 6.283185307179586;
constexpr double kTorusRatio = 8;  // of its sections to the corners of each

SceneShape primitiveOf(SceneShape::Kind kind, const Vec3& halfExtents)
{
	SceneShape shape;
	shape.kind = kind;
	shape.halfExtents = halfExtents;
	return shape;
}

// Between polygons of `sides` corners about y; inner 0: full. The corners lie on the circles, the first side faces +x.
ModelMesh turnedPrism(double inner, double outer, double height, int sides)
{
	ModelMesh mesh;
	const auto ring = [&](double radius, double y)
	{
		const std::uint32_t first = std::uint32_t(mesh.vertices.size());
		for (int i = 0; i < sides; ++i)
		{
			const double angle = kTurn * (i + 0.5) / sides;
			mesh.vertices.push_back({radius * std::cos(angle), y, radius * std::sin(angle)});
		}
		return first;
	};
	// Quads from one ring to another.
	const auto join = [&](std::uint32_t from, std::uint32_t to)
	{
		for (int i = 0; i < sides; ++i)
		{
			const std::uint32_t here = std::uint32_t(i), next = std::uint32_t((i + 1) % sides);
			addQuad(mesh, {from + here, to + here, to + next, from + next});
		}
	};
	const std::uint32_t low = ring(outer, -height / 2), high = ring(outer, height / 2);
	join(low, high);
	if (inner > 0)
	{
		const std::uint32_t lowHole = ring(inner, -height / 2), highHole = ring(inner, height / 2);
		join(high, highHole);
		join(highHole, lowHole);
		join(lowHole, low);
	}
	for (int end = 0; end < 2 && inner == 0; ++end)
	{
		const std::uint32_t middle = std::uint32_t(mesh.vertices.size()), first = end == 0 ? low : high;
		mesh.vertices.push_back({0, end == 0 ? -height / 2 : height / 2, 0});
		for (int i = 0; i < sides; ++i)
		{
			const std::uint32_t here = first + std::uint32_t(i), next = first + std::uint32_t((i + 1) % sides);
			mesh.triangles.push_back(end == 0 ? std::array<std::uint32_t, 3>{middle, here, next}
											  : std::array<std::uint32_t, 3>{middle, next, here});
		}
	}
	orientOutward(mesh);
	return mesh;
}
}  // namespace

Solid boxSolid(const Vec3& size, std::size_t triangles)
{
	return {fmt::format("box {:g} x {:g} x {:g} of {}", size.x, size.y, size.z, triangles), makeBox(size, triangles),
			true, primitiveOf(SceneShape::Kind::box, 0.5 * size)};
}

Solid ballSolid(double radius, std::size_t triangles)
{
	return {fmt::format("ball {:g} of {}", radius, triangles), makeSphere(triangles, radius), true,
			primitiveOf(SceneShape::Kind::sphere, {radius, radius, radius})};
}

Solid cylinderSolid(double radius, double height, int sides)
{
	return {fmt::format("cylinder {:g} x {:g} of {} sides", radius, height, sides),
			turnedPrism(0, radius, height, sides), true,
			primitiveOf(SceneShape::Kind::cylinder, {radius, height / 2, radius})};
}

// Round the inner circle, within the outer one.
Solid tubeSolid(double inner, double outer, double height, int sides)
{
	return {fmt::format("tube {:g} to {:g} x {:g} of {} sides", inner, outer, height, sides),
			turnedPrism(inner / std::cos(kTurn / 2 / sides), outer, height, sides)};
}

Solid torusSolid(double ring, double tube, std::size_t triangles)
{
	const ModelMesh mesh = ringGrid(ringSize(triangles, kTorusRatio),
									[&](double section, double turn) -> Vec3
									{
										const double u = kTurn * turn, v = kTurn * section;
										const double reach = ring + tube * std::cos(v);
										return {reach * std::cos(u), tube * std::sin(v), reach * std::sin(u)};
									});
	Solid torus{fmt::format("torus {:g}, {:g} of {}", ring, tube, triangles), mesh};
	orientOutward(torus.mesh);
	return torus;
}

int torusSections(std::size_t triangles)
{
	return ringSize(triangles, kTorusRatio).along;
}

Solid partSolid(const std::string& model, std::size_t triangles, double scale, bool isConvex)
{
	Result<ModelMesh> mesh = makeModel(model, triangles);
	if (!mesh) throw cli::Failure(cli::ExitCode::failure, mesh.error());
	for (Vec3& vertex : mesh.value().vertices) vertex = scale * vertex;
	return {fmt::format("{} of {}, {:g} times", model, triangles, scale), std::move(mesh.value()), isConvex};
}

HierarchyPointer Workshop::hierarchy(const Solid& solid)
{
	HierarchyPointer& known = m_hierarchies[solid.name];
	if (!known) known = m_cache.build(meshSource(solid.name, solid.mesh), {});
	return known;
}
}  // namespace clod::demo
