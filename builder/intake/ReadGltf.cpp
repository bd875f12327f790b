// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0 (.gltf, .glb) through tinygltf: the triangles of the default scene with their nodes' transforms applied.
// Every accessor is checked against its buffer here, because tinygltf hands them over as the file states them.
#include <fmt/format.h>
#include <tiny_gltf.h>

#include <array>
#include <cstring>
#include <filesystem>

#include "builder/intake/ReadMesh.h"

namespace clod::builder
{
namespace
{
[[noreturn]] void refuse(const std::string& what)
{
	throw Refused(Reason::syntax, what);
}

bool skipImage(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*)
{
	return true;
}

// Only files beside the .gltf: no absolute path, no "..".
bool mayOpen(const std::string& path, void* folder)
{
	const std::filesystem::path relative =
		std::filesystem::path(path).lexically_relative(*static_cast<const std::string*>(folder));
	return !relative.empty() && *relative.begin() != ".." && std::filesystem::is_regular_file(path);
}

bool readBeside(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* folder)
{
	if (!mayOpen(path, folder))
	{
		*error = "buffer outside the folder of the file";
		return false;
	}
	return tinygltf::ReadWholeFile(out, error, path, nullptr);
}

tinygltf::Model load(std::string_view bytes, std::string folder)
{
	if (folder.empty()) folder = ".";
	if (bytes.size() > 0xFFFFFFFFu) throw Refused(Reason::limit, "a glTF file holds at most 4 GiB");
	tinygltf::TinyGLTF loader;
	loader.SetImageLoader(skipImage, nullptr);
	loader.SetFsCallbacks({mayOpen, tinygltf::ExpandFilePath, readBeside, tinygltf::WriteWholeFile, &folder});
	tinygltf::Model model;
	std::string error, warning;
	const bool binary = bytes.substr(0, 4) == "glTF";
	const auto* const raw = reinterpret_cast<const unsigned char*>(bytes.data());
	const bool loaded =
		binary ? loader.LoadBinaryFromMemory(&model, &error, &warning, raw, unsigned(bytes.size()), folder)
			   : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), unsigned(bytes.size()), folder);
	if (!loaded) refuse("not a glTF file: " + error.substr(0, error.find('\n')));
	if (!model.extensionsRequired.empty())
		refuse(fmt::format("the required extension {} is not supported", model.extensionsRequired.front()));
	return model;
}

// Raw elements of an accessor, proved to lie inside their buffer.
struct Elements
{
	const unsigned char* data;
	std::size_t stride, count;
};

Elements elementsOf(const tinygltf::Model& model, int index, std::size_t elementSize)
{
	if (index < 0 || std::size_t(index) >= model.accessors.size()) refuse(fmt::format("no accessor {}", index));
	const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
	if (accessor.sparse.isSparse) refuse(fmt::format("accessor {} is sparse", index));
	if (accessor.bufferView < 0 || std::size_t(accessor.bufferView) >= model.bufferViews.size())
		refuse(fmt::format("accessor {} has no buffer view", index));
	const tinygltf::BufferView& view = model.bufferViews[std::size_t(accessor.bufferView)];
	if (view.buffer < 0 || std::size_t(view.buffer) >= model.buffers.size())
		refuse(fmt::format("buffer view {} has no buffer", accessor.bufferView));
	const std::size_t size = model.buffers[std::size_t(view.buffer)].data.size();
	const std::size_t stride = view.byteStride == 0 ? elementSize : view.byteStride;
	const bool viewFits = view.byteOffset <= size && view.byteLength <= size - view.byteOffset;
	const bool startFits = viewFits && accessor.byteOffset <= view.byteLength;
	const std::size_t room = startFits ? view.byteLength - accessor.byteOffset : 0;
	const bool fits = accessor.count == 0 || (room >= elementSize && stride >= elementSize &&
											  (accessor.count - 1) <= (room - elementSize) / stride);
	if (!startFits || !fits) refuse(fmt::format("accessor {} reaches outside its buffer", index));
	const unsigned char* const data = model.buffers[std::size_t(view.buffer)].data.data();
	return {data + view.byteOffset + accessor.byteOffset, stride, accessor.count};
}

// Column-major 4x4, as in the file.
using Matrix = std::array<double, 16>;
constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix operator*(const Matrix& a, const Matrix& b)
{
	Matrix c = {};
	for (std::size_t column = 0; column < 4; ++column)
		for (std::size_t row = 0; row < 4; ++row)
			for (std::size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
	return c;
}

Vec3 apply(const Matrix& m, const Vec3& p)
{
	return {m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12], m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
			m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
}

double determinant(const Matrix& m)
{
	return dot({m[0], m[1], m[2]}, cross({m[4], m[5], m[6]}, {m[8], m[9], m[10]}));
}

Matrix localTransform(const tinygltf::Node& node)
{
	Matrix m = kIdentity;
	if (node.matrix.size() == 16)
	{
		std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
		return m;
	}
	Mat3 rotation;
	if (node.rotation.size() == 4)
		rotation = rotationFromQuaternion(node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]);
	for (std::size_t column = 0; column < 3; ++column)
	{
		const double scale = node.scale.size() == 3 ? node.scale[column] : 1;
		for (std::size_t row = 0; row < 3; ++row) m[4 * column + row] = scale * rotation.row[row][int(column)];
		m[12 + column] = node.translation.size() == 3 ? node.translation[column] : 0;
	}
	return m;
}

void readPositions(const tinygltf::Model& model, int index, const Matrix& transform, Soup& soup)
{
	const Elements elements = elementsOf(model, index, 3 * sizeof(float));
	const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
	if (accessor.type != TINYGLTF_TYPE_VEC3 || accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
		refuse(fmt::format("accessor {} holds positions that are not three floats", index));
	for (std::size_t i = 0; i < elements.count; ++i)
	{
		std::array<float, 3> raw;
		std::memcpy(raw.data(), elements.data + i * elements.stride, sizeof(raw));
		const Vec3 p{double(raw[0]), double(raw[1]), double(raw[2])};
		soup.vertices.push_back(transform == kIdentity ? p : apply(transform, p));
	}
}

std::vector<std::uint32_t> readIndices(const tinygltf::Model& model, int index, std::size_t vertexCount)
{
	std::vector<std::uint32_t> indices;
	if (index < 0)
	{
		for (std::size_t i = 0; i < vertexCount; ++i) indices.push_back(std::uint32_t(i));
		return indices;
	}
	if (std::size_t(index) >= model.accessors.size()) refuse(fmt::format("no accessor {}", index));
	const int type = model.accessors[std::size_t(index)].componentType;
	const std::size_t size = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 1
							 : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
							 : type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? 4
																			  : 0;
	if (size == 0) refuse(fmt::format("accessor {} holds indices that are not unsigned integers", index));
	const Elements elements = elementsOf(model, index, size);
	for (std::size_t i = 0; i < elements.count; ++i)
	{
		std::uint32_t value = 0;  // little-endian, as the file
		std::memcpy(&value, elements.data + i * elements.stride, size);
		indices.push_back(value);
	}
	return indices;
}

void readPrimitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const Matrix& transform,
				   Soup& soup)
{
	if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1)
		refuse(fmt::format("primitive mode {} is not triangles", primitive.mode));
	const auto position = primitive.attributes.find("POSITION");
	if (position == primitive.attributes.end()) refuse("a primitive has no POSITION");
	const std::size_t first = soup.vertices.size();
	readPositions(model, position->second, transform, soup);
	const std::size_t count = soup.vertices.size() - first;
	const std::vector<std::uint32_t> indices = readIndices(model, primitive.indices, count);
	if (indices.size() % 3 != 0) refuse(fmt::format("{} indices do not make triangles", indices.size()));
	const bool mirrored = determinant(transform) < 0;
	for (std::size_t i = 0; i < indices.size(); ++i)
	{
		const std::uint32_t index = indices[mirrored ? i - i % 3 + (3 - i % 3) % 3 : i];
		if (index >= count)
			throw Refused(Reason::indexOutOfRange,
						  fmt::format("triangle {} of a primitive: vertex index {} of {}", i / 3, index, count));
		soup.corners.push_back(checkedIndex((long long)(first + index), "vertices"));
		if (i % 3 == 2) soup.endPolygon();
	}
}

// A node with a mesh.
void readPart(const tinygltf::Model& model, const tinygltf::Node& node, const Matrix& transform, Soup& soup)
{
	const std::size_t polygons = soup.polygonCount();
	const tinygltf::Mesh& mesh = model.meshes[std::size_t(node.mesh)];
	for (const tinygltf::Primitive& primitive : mesh.primitives) readPrimitive(model, primitive, transform, soup);
	if (soup.polygonCount() > polygons) soup.endPart(node.name.empty() ? mesh.name : node.name);
}

std::vector<int> rootNodes(const tinygltf::Model& model)
{
	const std::size_t scene = model.defaultScene < 0 ? 0 : std::size_t(model.defaultScene);
	if (model.scenes.empty()) refuse("the file has no scene");
	if (scene >= model.scenes.size()) refuse(fmt::format("no scene {}", scene));
	return model.scenes[scene].nodes;
}
}  // namespace

Soup parseGltf(std::string_view bytes, const std::string& folder)
{
	if (bytes.empty()) throw Refused(Reason::empty, "the file has no content");
	const tinygltf::Model model = load(bytes, folder);
	struct Visit
	{
		int node;
		Matrix parent;
	};
	std::vector<Visit> open;
	const std::vector<int> roots = rootNodes(model);
	for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, kIdentity});
	std::vector<bool> seen(model.nodes.size(), false);
	Soup soup;
	while (!open.empty())
	{
		const Visit visit = open.back();
		open.pop_back();
		const std::size_t index = std::size_t(visit.node);
		if (visit.node < 0 || index >= model.nodes.size()) refuse(fmt::format("no node {}", visit.node));
		if (seen[index]) refuse(fmt::format("node {} has two parents", visit.node));
		seen[index] = true;
		const tinygltf::Node& node = model.nodes[index];
		const Matrix transform = visit.parent * localTransform(node);
		if (node.mesh >= 0 && std::size_t(node.mesh) >= model.meshes.size())
			refuse(fmt::format("no mesh {}", node.mesh));
		if (node.mesh >= 0) readPart(model, node, transform, soup);
		for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
			open.push_back({*child, transform});
	}
	return soup;
}
}  // namespace clod::builder
