// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/cli/LevelSurface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "demos/render/PatchColor.h"

namespace clod::builder
{
namespace
{
template <class T>
void append(std::string& bytes, const T& value)
{
	const char* const raw = reinterpret_cast<const char*>(&value);
	bytes.append(raw, sizeof(T));
}

Vec3 inMesh(const LevelSurface& surface, std::size_t vertex)
{
	return toVec3(surface.verticesInBody[vertex]) + surface.meshFromBody;
}

std::array<std::vector<float>, 2> bounds(const LevelSurface& surface)
{
	std::vector<float> low(3, 0), high(3, 0);
	for (std::size_t i = 0; i < surface.verticesInBody.size(); ++i)
	{
		const Float3& v = surface.verticesInBody[i];
		const float p[3] = {v.x, v.y, v.z};
		for (std::size_t k = 0; k < 3; ++k)
		{
			low[k] = i == 0 ? p[k] : std::min(low[k], p[k]);
			high[k] = i == 0 ? p[k] : std::max(high[k], p[k]);
		}
	}
	return {low, high};
}

// The JSON part of a .glb: one mesh, buffer views positions | colours | indices.
nlohmann::ordered_json gltfScene(const LevelSurface& surface)
{
	const std::size_t vertices = surface.verticesInBody.size(), corners = 3 * surface.triangles.size();
	const std::size_t colorStart = 12 * vertices, indexStart = colorStart + 4 * vertices;
	const auto [low, high] = bounds(surface);
	nlohmann::ordered_json scene;
	scene["asset"] = {{"version", "2.0"}, {"generator", "clod-build"}};
	scene["scene"] = 0;
	scene["scenes"] = {{{"nodes", {0}}}};
	const Vec3& t = surface.meshFromBody;
	scene["nodes"] = {{{"mesh", 0}, {"translation", {t.x, t.y, t.z}}}};
	scene["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}, {"COLOR_0", 1}}}, {"indices", 2}}}}}};
	scene["accessors"] = {
		{{"bufferView", 0},
		 {"componentType", 5126},
		 {"count", vertices},
		 {"type", "VEC3"},
		 {"min", low},
		 {"max", high}},
		{{"bufferView", 1}, {"componentType", 5121}, {"normalized", true}, {"count", vertices}, {"type", "VEC4"}},
		{{"bufferView", 2}, {"componentType", 5125}, {"count", corners}, {"type", "SCALAR"}}};
	scene["bufferViews"] = {
		{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", colorStart}, {"target", 34962}},
		{{"buffer", 0}, {"byteOffset", colorStart}, {"byteLength", 4 * vertices}, {"target", 34962}},
		{{"buffer", 0}, {"byteOffset", indexStart}, {"byteLength", 4 * corners}, {"target", 34963}}};
	scene["buffers"] = {{{"byteLength", indexStart + 4 * corners}}};
	return scene;
}

// glTF's vertex colours are linear where those of the other formats are sRGB (glTF 2.0, sec. 3.9.2).
std::uint8_t linear(std::uint8_t value)
{
	const double c = value / 255.0;
	return std::uint8_t(std::lround(255 * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4))));
}

void appendChunk(std::string& file, const char* type, std::string data, char fill)
{
	data.resize((data.size() + 3) / 4 * 4, fill);
	append(file, std::uint32_t(data.size()));
	file.append(type, 4);
	file += data;
}
}  // namespace

LevelSurface levelSurface(const Hierarchy& hierarchy, std::uint32_t levelIndex)
{
	const Level& level = hierarchy.levels()[levelIndex];
	LevelSurface surface;
	surface.patchCount = level.nodeCount;
	const double* const shift = hierarchy.asset().meshFromBody;
	surface.meshFromBody = {shift[0], shift[1], shift[2]};
	for (std::uint32_t patch = 0; patch < level.nodeCount; ++patch)
	{
		const Node& node = hierarchy.node(level.firstNode + patch);
		const HullView hull = hierarchy.hull(node);
		const std::uint32_t first = std::uint32_t(surface.verticesInBody.size());
		for (std::uint32_t v = 0; v < hull.count; ++v)
		{
			surface.verticesInBody.push_back({hull.x[v], hull.y[v], hull.z[v]});
			surface.colors.push_back(demo::patchColor(patch));
		}
		for (const Face& face : hierarchy.faces(node))
			surface.triangles.push_back({first + face.vertex[0], first + face.vertex[1], first + face.vertex[2]});
	}
	return surface;
}

std::string encodePly(const LevelSurface& surface)
{
	std::string file = fmt::format(
		"ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
		"property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n"
		"property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
		"end_header\n",
		surface.verticesInBody.size(), surface.triangles.size());
	for (std::size_t i = 0; i < surface.verticesInBody.size(); ++i)
	{
		const Vec3 p = inMesh(surface, i);
		for (int k = 0; k < 3; ++k) append(file, p[k]);
		append(file, surface.colors[i]);
	}
	for (const auto& triangle : surface.triangles)
	{
		append(file, std::uint8_t(3));
		append(file, triangle);
		append(file, surface.colors[triangle[0]]);
	}
	return file;
}

std::string encodeObj(const LevelSurface& surface)
{
	fmt::memory_buffer file;
	const auto out = std::back_inserter(file);
	for (std::size_t i = 0; i < surface.verticesInBody.size(); ++i)
	{
		const Vec3 p = inMesh(surface, i);
		const auto& c = surface.colors[i];
		fmt::format_to(out, "v {} {} {} {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z, c[0] / 255.0, c[1] / 255.0,
					   c[2] / 255.0);
	}
	for (const auto& t : surface.triangles) fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
	return fmt::to_string(file);
}

std::string encodeGlb(const LevelSurface& surface)
{
	std::string binary;
	for (const Float3& v : surface.verticesInBody) append(binary, v);
	for (const auto& c : surface.colors)
		append(binary, std::array<std::uint8_t, 4>{linear(c[0]), linear(c[1]), linear(c[2]), 255});
	for (const auto& triangle : surface.triangles) append(binary, triangle);
	std::string chunks;
	appendChunk(chunks, "JSON", gltfScene(surface).dump(), ' ');
	appendChunk(chunks, "BIN\0", binary, '\0');
	std::string file = "glTF";
	append(file, std::uint32_t(2));
	append(file, std::uint32_t(12 + chunks.size()));
	return file + chunks;
}
}  // namespace clod::builder
