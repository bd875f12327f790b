// SPDX-License-Identifier: Zlib
// A dual hierarchy: one immutable, checksummed block, shared read-only by any number of shapes and threads.
// Everything reachable through a Hierarchy has been validated once, by load or fromBytes; nothing is checked later.
#pragma once
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/Triangle.h"
#include "clod/hierarchy/DerivedData.h"
#include "clod/hierarchy/Layout.h"
#include "clod/hierarchy/Result.h"

namespace clod
{
template <class T>
struct Span
{
	const T* data = nullptr;
	std::size_t size = 0;
	const T& operator[](std::size_t i) const { return data[i]; }
	const T* begin() const { return data; }
	const T* end() const { return data + size; }
	bool empty() const { return size == 0; }
};

// The same data as growable arrays: what a builder fills and encode() writes. Hull coordinates are padded already.
struct HierarchyContent
{
	Asset asset{};
	std::vector<Level> levels;
	std::vector<Node> nodes;
	std::vector<OrientedBox> cullBoxes;  // one a node
	std::vector<std::uint32_t> children;
	std::vector<Face> faces;  // level by level, contiguous per node
	std::vector<float> hullX, hullY, hullZ;
};

class CLOD_API Hierarchy
{
public:
	// Reads and validates a file: header, checksums, sizes before any allocation, then every index and float, then the
	// structure. Fails with a sentence naming the first offending element. O(file size).
	static Result<std::shared_ptr<const Hierarchy>> load(const std::string& path);
	// Loads only the levels from `finest` on (and a finer one where a level needs its children): level 0 of the result
	// is level finestLevel() of the file. Only what is loaded takes memory and is validated; the checksums are those of
	// the whole file. Metrics that ask for finer levels cannot be met: see levelsError (query/Query.h).
	static Result<std::shared_ptr<const Hierarchy>> load(const std::string& path, std::uint32_t finest);
	static Result<std::shared_ptr<const Hierarchy>> fromBytes(std::vector<std::byte> bytes);

	const Asset& asset() const { return *m_asset; }
	Span<Level> levels() const { return m_levels; }
	Span<Node> nodes() const { return m_nodes; }
	const Node& node(std::uint32_t i) const { return m_nodes[i]; }
	const OrientedBox& cullBox(std::uint32_t i) const { return m_cullBoxes[i]; }
	Span<std::uint32_t> children(const Node& n) const { return {m_children.data + n.firstChild, n.childCount}; }
	Span<Face> faces() const { return m_faces; }
	Span<Face> faces(const Node& n) const { return {m_faces.data + n.firstFace, n.faceCount}; }
	HullView hull(const Node& n) const
	{
		return {m_hullX + n.firstVertex, m_hullY + n.firstVertex, m_hullZ + n.firstVertex, n.vertexCount,
				(n.vertexCount + kVertexLanes - 1) / kVertexLanes * kVertexLanes};
	}
	std::size_t childrenSize() const { return m_children.size; }
	std::size_t hullSize() const { return m_hullSize; }  // floats in each of the three coordinate arrays
	std::uint32_t root() const { return std::uint32_t(m_nodes.size - 1); }
	std::uint32_t coarsestClodLevel() const { return m_coarsestClodLevel; }
	bool isPaperBuild() const { return (asset().flags & kPaperBuild) != 0; }
	bool isScaled() const { return (asset().flags & kScaled) != 0; }
	// Which level of the file is level 0 here. If above 0, level 0 is not the input surface but stands for it.
	std::uint32_t finestLevel() const { return m_finestLevel; }
	bool isCoarse() const { return m_finestLevel > 0; }
	bool isThinCore() const { return (asset().flags & kThinCore) != 0; }
	// An upper bound of the distance from the body's origin to anything in the hierarchy, culling boxes included.
	double originRadius() const;
	// Hash of the whole block (xxh3, 64 bits): identifies the asset.
	std::uint64_t contentHash() const { return m_contentHash; }
	const std::vector<std::byte>& bytes() const { return m_bytes; }
	// Data that another folder derives from a hierarchy, by T(hierarchy): made once, when first asked for, and kept as
	// long as the hierarchy.
	template <class T>
	const T& derived() const
	{
		return m_derived.get<T>(*this);
	}

	// Takes bytes that encode() wrote in this process without validating them: those of a piece (ConvexPiece.h) or of a
	// scaled body whose original was proved (ScaledHierarchy.h), or if a proof follows (CoarseLevels.cpp).
	static std::shared_ptr<const Hierarchy> fromOwnBytes(std::vector<std::byte> bytes, std::uint32_t finestLevel = 0);

private:
	Hierarchy() = default;
	std::vector<std::byte> m_bytes;
	const Asset* m_asset = nullptr;
	Span<Level> m_levels;
	Span<Node> m_nodes;
	Span<OrientedBox> m_cullBoxes;
	Span<std::uint32_t> m_children;
	Span<Face> m_faces;
	const float* m_hullX = nullptr;
	const float* m_hullY = nullptr;
	const float* m_hullZ = nullptr;
	std::size_t m_hullSize = 0;
	std::uint32_t m_coarsestClodLevel = 0;
	std::uint32_t m_finestLevel = 0;
	std::uint64_t m_contentHash = 0;
	DerivedData m_derived;
	friend struct HierarchyReader;
};

// The thickened hull of a node.
inline ConvexHull contactHull(const Hierarchy& hierarchy, const Node& node)
{
	const double t = node.thickness;
	return {hierarchy.hull(node), {t * node.inward[0], t * node.inward[1], t * node.inward[2]}};
}

// Corners of a real face, body frame.
inline Triangle triangleOf(const Hierarchy& hierarchy, const Node& owner, const Face& face)
{
	const HullView hull = hierarchy.hull(owner);
	return {hull.vertex(face.vertex[0]), hull.vertex(face.vertex[1]), hull.vertex(face.vertex[2])};
}

// The bytes of a .clod file. Same content, same bytes.
CLOD_API std::vector<std::byte> encode(const HierarchyContent& content);

// Checks the rules of a content: indices in range, floats finite, a tree, monotone numbers and so on. Empty if it is
// sound, otherwise the first broken rule and element. load() calls it; linear in the content.
CLOD_API std::string validate(const Hierarchy& hierarchy);
}  // namespace clod
