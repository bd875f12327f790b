// SPDX-License-Identifier: Zlib
#include "demos/runner/LevelPictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "demos/cli/Failure.h"
#include "demos/render/Overlay.h"
#include "demos/render/PatchColor.h"
#include "demos/render/Renderer.h"

namespace clod::demo
{
namespace
{
constexpr int kCell = 400;  // pixels, each way
constexpr int kColumns = 5;
constexpr double kAzimuth = 35, kElevation = 25, kFovy = 30;
constexpr double kDetail = 0.22;  // of the radius, what the detail shows

// The faces of a level, each patch with vertices of its own.
RenderMesh levelMesh(const Hierarchy& hierarchy, std::size_t index)
{
	const Level& level = hierarchy.levels()[index];
	RenderMesh mesh;
	for (std::uint32_t patch = 0; patch < level.nodeCount; ++patch)
	{
		const Node& node = hierarchy.node(level.firstNode + patch);
		const HullView hull = hierarchy.hull(node);
		const std::uint32_t first = std::uint32_t(mesh.vertices.size());
		for (std::uint32_t v = 0; v < hull.count; ++v) mesh.vertices.push_back(hull.vertex(v));
		const auto color = patchColor(patch);
		for (const Face& face : hierarchy.faces(node))
		{
			mesh.triangles.push_back({first + face.vertex[0], first + face.vertex[1], first + face.vertex[2]});
			mesh.triangleColors.push_back({color[0] / 255.0f, color[1] / 255.0f, color[2] / 255.0f, 1});
		}
	}
	return mesh;
}

// Level 0 as one surface, for smooth shading.
RenderMesh inputMesh(const RenderMesh& patches)
{
	RenderMesh mesh;
	std::map<std::tuple<double, double, double>, std::uint32_t> places;
	for (const auto& triangle : patches.triangles)
	{
		mesh.triangles.emplace_back();
		for (std::size_t k = 0; k < 3; ++k)
		{
			const Vec3& v = patches.vertices[triangle[k]];
			const auto [place, isNew] = places.try_emplace({v.x, v.y, v.z}, std::uint32_t(mesh.vertices.size()));
			if (isNew) mesh.vertices.push_back(v);
			mesh.triangles.back()[k] = place->second;
		}
	}
	return mesh;
}

// Where the detail looks: the vertex nearest to the eye.
Vec3 nearestTo(const Vec3& eye, const RenderMesh& mesh)
{
	return *std::min_element(mesh.vertices.begin(), mesh.vertices.end(),
							 [&](const Vec3& a, const Vec3& b)
							 { return lengthSquared(a - eye) < lengthSquared(b - eye); });
}

class Painter
{
public:
	explicit Painter(const Hierarchy& hierarchy) : m_hierarchy(hierarchy)
	{
		auto renderer = Renderer::create(kCell, kCell);
		if (!renderer) throw cli::Failure(cli::ExitCode::failure, renderer.error());
		m_renderer = std::move(renderer.value());
		const Asset& asset = hierarchy.asset();
		m_center = {asset.sphereCenter[0], asset.sphereCenter[1], asset.sphereCenter[2]};
		m_camera = orbitCamera(m_center, asset.radius, kAzimuth, kElevation, kFovy);
	}
	std::vector<CaptionedImage> paint()
	{
		const RenderMesh finest = levelMesh(m_hierarchy, 0);
		std::vector<CaptionedImage> cells;
		cells.push_back({render(inputMesh(finest), Shading::Smooth, m_camera),
						 fmt::format("the model: {} triangles", finest.triangles.size())});
		const double detail = kDetail * m_hierarchy.asset().radius;
		const Camera close = orbitCamera(nearestTo(m_camera.eye, finest), detail, kAzimuth, kElevation, kFovy);
		cells.push_back({render(finest, Shading::Flat, close), "detail: its convex patches"});
		for (std::size_t level = 0; level <= m_hierarchy.coarsestClodLevel(); ++level)
			cells.push_back({render(levelMesh(m_hierarchy, level), Shading::Flat, m_camera), caption(level)});
		return cells;
	}

private:
	Image render(const RenderMesh& mesh, Shading shading, const Camera& camera)
	{
		const Result<MeshId> id = m_renderer->addMesh(mesh, shading);
		if (!id) throw cli::Failure(cli::ExitCode::failure, id.error());
		Frame frame;
		frame.camera = camera;
		frame.instances.push_back({id.value(), {}, {0.72f, 0.74f, 0.77f, 1}, false});
		frame.ground.isDrawn = false;
		return m_renderer->render(frame);
	}
	std::string caption(std::size_t index) const
	{
		const Level& level = m_hierarchy.levels()[index];
		const std::string error =
			index == 0 ? "exact"
					   : fmt::format("error {:.2g} %", 100 * double(level.maxDeviation) / m_hierarchy.asset().radius);
		return fmt::format("level {}: {} triangles, {} patches, {}", index, level.faceCount, level.nodeCount, error);
	}

	const Hierarchy& m_hierarchy;
	std::unique_ptr<Renderer> m_renderer;
	Vec3 m_center;
	Camera m_camera;
};
}  // namespace

Image paintLevels(const Hierarchy& hierarchy, const std::string& title)
{
	return contactSheet(Painter(hierarchy).paint(), kColumns, 0,
						title + " - one colour per convex patch; errors certified, of the radius");
}
}  // namespace clod::demo
