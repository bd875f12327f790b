// SPDX-License-Identifier: Zlib
// A .clod file as it is stored, version 3: header and section table are those of the block (HierarchyFormat.h), offsets
// and hashes of sections included, but for the header's version, bytes and hashes; then all sections, packed. Unpacked
// it is the block again, bit for bit, so that nothing that was proved is another.
//
// Planes of faces follow from their corners, and mostly inward directions from mean normals: stored is by how much, as
// whole numbers, they differ (version 2: as they are).
//
// A section's records are packed column by column (of 2 or 4 bytes), a column as
//   [predictor: 1 byte][group][group]...     of 16 values: [bits: 1 byte, 0..32][differences of so many bits]
// a difference being that to the value before or to the record's number, zigzag, or the value itself, whichever is
// least. Groups end on whole bytes; the last one has the values that are left.
//
// Based on: Lemire & Boytsov 2015, "Decoding billions of integers per second through vectorization" (binary packing);
// Kapoulkine, meshoptimizer's vertex codec (records as columns, differences, zigzag).
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "clod/Export.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/Layout.h"

namespace clod
{
inline constexpr std::uint32_t kPackedVersion = 3;
inline constexpr std::uint32_t kFirstPackedVersion = 2;
// A group of zeros is a byte of 16 values: no block is larger, times its file, than this.
inline constexpr std::uint64_t kMostUnpacked = 64;

// Precondition: a block, as encode() writes it. Same block, same bytes.
CLOD_API std::vector<std::byte> pack(std::vector<std::byte> block);

// Section after section, in the file's order. Nothing is trusted but the table, which is checked.
class PackedSections
{
public:
	PackedSections(const std::byte* begin, const std::byte* end, const SectionEntry* table)
		: m_at(begin), m_end(end), m_table(table)
	{
	}
	// The next section's records. Room: their bytes. Empty, or what is wrong: the file ends before, or has more bits
	// than a value, or goes on after the last.
	std::string read(std::byte* records);

private:
	const std::byte* m_at;
	const std::byte* m_end;
	const SectionEntry* m_table;
	std::uint32_t m_next = 0;
};

// Of a file of this version, unpacked: what was taken off is given back. Faces after nodes and vertices.
void restoreInward(std::uint32_t version, Node* nodes, std::size_t count);
struct PlaneRecords
{
	const Node* nodes;
	std::size_t nodeCount;
	Face* faces;
	std::size_t faceCount;
	const float *x, *y, *z;
	std::size_t vertexCount;
};
void restorePlanes(std::uint32_t version, const PlaneRecords& records);

// The block of a packed file. Precondition: checkFileStart() and checkPacked() have found nothing.
Result<std::vector<std::byte>> unpack(const std::vector<std::byte>& file);
}  // namespace clod
