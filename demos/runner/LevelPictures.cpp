// SPDX-License-Identifier: Zlib
#include "demos/runner/LevelPictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>

#include "cli/Failure.h"
#include "clod/hierarchy/InputSurface.h"
#include "demos/render/Overlay.h"
#include "demos/render/PatchColor.h"
#include "demos/render/Renderer.h"

namespace clod::demo
{
namespace
{
constexpr int kCell = 400;         // pixels, each way; wider and lower for what looks long
constexpr int kLevelsWidth = 2000;  // pixels, about
constexpr double kLongest = 2.4;   // width over height of a cell
constexpr double kFovy = 30;
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

constexpr double kHeatEdge = 0.04;  // of the radius: how finely a heat map is cut
constexpr int kHeatHalvings = 7;
constexpr double kHeatEnds[kHeatSteps - 1] = {1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1};

// A level's surface cut finely, each part in the colour of its distance to the input surface.
struct HeatMesh
{
	RenderMesh mesh;
	double most = 0;                        // of all parts
	std::array<bool, kHeatSteps> isUsed{};  // which colours there are
};

void addHeat(const Hierarchy& hierarchy, const Triangle& triangle, int halvings, HeatMesh& heat)
{
	const double radius = double(hierarchy.asset().radius);
	int longest = 0;
	for (int k = 1; k < 3; ++k)
		if (lengthSquared(triangle[(k + 1) % 3] - triangle[k]) >
			lengthSquared(triangle[(longest + 1) % 3] - triangle[longest]))
			longest = k;
	const Vec3 &a = triangle[longest], &b = triangle[(longest + 1) % 3], &c = triangle[(longest + 2) % 3];
	if (halvings > 0 && length(b - a) > kHeatEdge * radius)
	{
		const Vec3 middle = 0.5 * (a + b);
		addHeat(hierarchy, {a, middle, c}, halvings - 1, heat);
		addHeat(hierarchy, {middle, b, c}, halvings - 1, heat);
		return;
	}
	std::uint32_t visited = 0;
	const Vec3 center = (1.0 / 3) * (a + b + c);
	const double error = std::fabs(distanceToInput(hierarchy, center, visited).distance) / radius;
	heat.most = std::max(heat.most, error);
	const int step = heatStep(error);
	heat.isUsed[std::size_t(step)] = true;
	const std::uint32_t first = std::uint32_t(heat.mesh.vertices.size());
	for (const Vec3& v : {a, b, c}) heat.mesh.vertices.push_back(v);
	heat.mesh.triangles.push_back({first, first + 1, first + 2});
	heat.mesh.triangleColors.push_back(levelColor(step, kHeatSteps));
}

HeatMesh heatMesh(const Hierarchy& hierarchy, std::size_t index)
{
	const Level& level = hierarchy.levels()[index];
	HeatMesh heat;
	for (std::uint32_t patch = 0; patch < level.nodeCount; ++patch)
	{
		const Node& node = hierarchy.node(level.firstNode + patch);
		for (const Face& face : hierarchy.faces(node))
			addHeat(hierarchy, triangleOf(hierarchy, node, face), kHeatHalvings * 2, heat);
	}
	return heat;
}

std::vector<LegendEntry> heatLegend(const std::array<bool, kHeatSteps>& isUsed)
{
	std::vector<LegendEntry> legend;
	for (int step = kHeatSteps - 1; step >= 0; --step)
		if (isUsed[std::size_t(step)])
			legend.push_back({levelColor(step, kHeatSteps),
							  step + 1 < kHeatSteps ? fmt::format("up to {:g} %", 100 * kHeatEnds[step])
													: fmt::format("over {:g} %", 100 * kHeatEnds[step - 1])});
	return legend;
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

// From where a mesh is looked at, and how wide it looks.
struct View
{
	double azimuth = 0, elevation = 0;
	Vec3 toEye, right, up;
	double low[2] = {0, 0}, high[2] = {0, 0};  // along right and up
	double width() const { return high[0] - low[0]; }
	double height() const { return high[1] - low[1]; }

	View(double azimuthAngle, double elevationAngle, const RenderMesh& mesh)
		: azimuth(azimuthAngle), elevation(elevationAngle)
	{
		toEye = normalized(orbitCamera({}, 1, azimuth, elevation).eye);
		right = normalized(cross(Vec3{0, 1, 0}, toEye));
		up = cross(toEye, right);
		for (int k = 0; k < 2; ++k)
		{
			const auto along = [&](const Vec3& v) { return dot(k == 0 ? right : up, v); };
			const auto ends = std::minmax_element(mesh.vertices.begin(), mesh.vertices.end(),
												  [&](const Vec3& a, const Vec3& b) { return along(a) < along(b); });
			low[k] = along(*ends.first);
			high[k] = along(*ends.second);
		}
	}
	double aspect() const { return std::clamp(width() / height(), 1.0, kLongest); }

	// Everything just fits.
	Camera camera(const RenderMesh& mesh) const
	{
		constexpr double kRoom = 1.08;
		const double tangent = std::tan(0.5 * kFovy * std::acos(-1.0) / 180);
		const double middle[2] = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])};
		const double wide = aspect();
		double distance = -std::numeric_limits<double>::infinity();
		for (const Vec3& v : mesh.vertices)
		{
			const double across =
				std::max(std::fabs(dot(right, v) - middle[0]) / wide, std::fabs(dot(up, v) - middle[1]));
			distance = std::max(distance, dot(toEye, v) + kRoom * across / tangent);
		}
		const Vec3 axis = middle[0] * right + middle[1] * up;
		double depth = 0;
		for (const Vec3& v : mesh.vertices) depth += dot(toEye, v) / double(mesh.vertices.size());
		return {axis + distance * toEye, axis + depth * toEye, kFovy};
	}
};

// From above the corner, unless the mesh shows half as much again from its side or from further above.
View viewOf(const RenderMesh& mesh)
{
	View best(35, 25, mesh);
	double most = 1.5 * best.width() * best.height();
	for (const double azimuth : {35.0, 0.0, 90.0})
		for (const double elevation : {25.0, 60.0})
		{
			const View view(azimuth, elevation, mesh);
			if (view.width() * view.height() <= most) continue;
			most = view.width() * view.height();
			best = view;
		}
	return best;
}

class Painter
{
public:
	explicit Painter(const Hierarchy& hierarchy)
		: m_hierarchy(hierarchy), m_finest(levelMesh(hierarchy, 0)), m_view(viewOf(m_finest))
	{
		m_width = int(kCell * std::sqrt(m_view.aspect()));
		auto renderer = Renderer::create(m_width, int(m_width / m_view.aspect()));
		if (!renderer) throw cli::Failure(cli::ExitCode::failure, renderer.error());
		m_renderer = std::move(renderer.value());
		m_camera = m_view.camera(m_finest);
	}
	int columns() const { return kLevelsWidth / m_width; }
	std::vector<CaptionedImage> paint()
	{
		std::vector<CaptionedImage> cells;
		cells.push_back({render(inputMesh(m_finest), Shading::Smooth, m_camera),
						 fmt::format("the model: {} triangles", m_finest.triangles.size())});
		const double detail = kDetail * m_hierarchy.asset().radius;
		const Camera close =
			orbitCamera(nearestTo(m_camera.eye, m_finest), detail, m_view.azimuth, m_view.elevation, kFovy);
		cells.push_back({render(m_finest, Shading::Flat, close), "detail: its convex patches"});
		for (std::size_t level = 0; level <= m_hierarchy.coarsestClodLevel(); ++level)
			cells.push_back({render(levelMesh(m_hierarchy, level), Shading::Flat, m_camera), caption(level)});
		return cells;
	}

	std::vector<CaptionedImage> paintErrors()
	{
		std::vector<CaptionedImage> cells;
		cells.push_back({render(inputMesh(m_finest), Shading::Smooth, m_camera),
						 fmt::format("the model: {} triangles", m_finest.triangles.size())});
		std::array<bool, kHeatSteps> isUsed{};
		for (std::size_t level = 1; level <= m_hierarchy.coarsestClodLevel(); ++level)
		{
			const HeatMesh heat = heatMesh(m_hierarchy, level);
			for (std::size_t step = 0; step < isUsed.size(); ++step) isUsed[step] = isUsed[step] || heat.isUsed[step];
			cells.push_back(
				{render(heat.mesh, Shading::Flat, m_camera),
				 fmt::format("level {}: at most {:.2g} %, certified {}", level, 100 * heat.most, certified(level))});
		}
		Image legend(cells.front().image.width, cells.front().image.height, {1, 1, 1, 1});
		OverlayText text;
		text.legendTitle = "Off the full mesh, of the radius";
		text.legend = heatLegend(isUsed);
		drawOverlay(legend, text);
		cells.push_back({std::move(legend), ""});
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
		return fmt::format("level {}: {} triangles, {} patches, {}", index, level.faceCount, level.nodeCount,
						   certified(index));
	}
	std::string certified(std::size_t index) const
	{
		const double most = double(m_hierarchy.levels()[index].maxDeviation);
		return index == 0 ? "exact" : fmt::format("{:.2g} %", 100 * most / m_hierarchy.asset().radius);
	}

	const Hierarchy& m_hierarchy;
	const RenderMesh m_finest;
	const View m_view;
	int m_width = kCell;
	std::unique_ptr<Renderer> m_renderer;
	Camera m_camera;
};
}  // namespace

int heatStep(double shareOfRadius)
{
	return int(std::lower_bound(std::begin(kHeatEnds), std::end(kHeatEnds), shareOfRadius) - std::begin(kHeatEnds));
}

Image paintLevelErrors(const Hierarchy& hierarchy, const std::string& title)
{
	Painter painter(hierarchy);
	return contactSheet(painter.paintErrors(), painter.columns(), 0,
						title + " - how far each level is off the full mesh");
}

Image paintLevels(const Hierarchy& hierarchy, const std::string& title)
{
	Painter painter(hierarchy);
	return contactSheet(painter.paint(), painter.columns(), 0,
						title + " - one colour per convex patch; certified error, of the radius");
}
}  // namespace clod::demo
