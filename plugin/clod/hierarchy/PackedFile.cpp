// SPDX-License-Identifier: Zlib
#include "clod/hierarchy/PackedFile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>

#include "clod/collide/Vector.h"

namespace clod
{
namespace
{
constexpr std::uint32_t kGroup = 16;  // values
constexpr std::uint32_t kMostBits = 32;

enum class Predictor : std::uint8_t
{
	kBefore,
	kNumber,  // of the record: indices of what lies beside it
	kNone,
	count
};

struct Column
{
	std::uint32_t offset, bytes;
};
// Pairs of short numbers are columns of their own.
bool areShorts(Section section, std::uint32_t offset)
{
	if (section == Section::nodes) return offset == offsetof(Node, childCount);
	return section == Section::faces && offset < offsetof(Face, neighbour);
}
std::vector<Column> columnsOf(const SectionEntry& entry)
{
	std::vector<Column> columns;
	for (std::uint32_t offset = 0; offset < entry.stride; offset += 4)
	{
		const bool shorts = areShorts(Section(entry.kind), offset);
		columns.push_back({offset, shorts ? 2U : 4U});
		if (shorts) columns.push_back({offset + 2, 2});
	}
	return columns;
}

std::uint32_t zigzag(std::uint32_t difference)
{
	return difference << 1 ^ (0U - (difference >> 31));
}
std::uint32_t unzigzag(std::uint32_t coded)
{
	return coded >> 1 ^ (0U - (coded & 1));
}

// As a difference of whole numbers of the column's width.
std::uint32_t code(std::uint32_t value, std::uint32_t predicted, std::uint32_t bytes)
{
	const std::uint32_t difference = value - predicted;
	return zigzag(bytes == 2 ? std::uint32_t(std::int32_t(std::int16_t(difference))) : difference);
}

constexpr std::uint32_t bytesOf(std::uint32_t bits, std::uint32_t count)
{
	return (bits * count + 7) / 8;
}
constexpr std::uint32_t bytesOfWhole(std::uint32_t bits)
{
	return bytesOf(bits, kGroup);
}

void packGroup(const std::uint32_t (&codes)[kGroup], std::uint32_t count, std::vector<std::byte>& packed)
{
	std::uint32_t all = 0, bits = 0, kept = 0;
	for (std::uint32_t i = 0; i < count; ++i) all |= codes[i];
	while (bits < kMostBits && all >> bits != 0) ++bits;
	packed.push_back(std::byte(bits));
	std::uint64_t pending = 0;
	for (std::uint32_t i = 0; i < count; ++i)
	{
		pending |= std::uint64_t(codes[i]) << kept;
		for (kept += bits; kept >= 8; kept -= 8, pending >>= 8) packed.push_back(std::byte(pending & 0xFF));
	}
	if (kept > 0) packed.push_back(std::byte(pending & 0xFF));
}

std::vector<std::byte> packedBy(Predictor predictor, const std::vector<std::uint32_t>& values, std::uint32_t bytes)
{
	std::vector<std::byte> packed{std::byte(predictor)};
	std::uint32_t before = 0;
	for (std::size_t first = 0; first < values.size(); first += kGroup)
	{
		std::uint32_t codes[kGroup];
		const std::size_t end = std::min<std::size_t>(values.size(), first + kGroup);
		for (std::size_t i = first; i < end; ++i)
		{
			const std::uint32_t predicted = predictor == Predictor::kBefore ? before : std::uint32_t(i);
			codes[i - first] = predictor == Predictor::kNone ? values[i] : code(values[i], predicted, bytes);
			before = values[i];
		}
		packGroup(codes, std::uint32_t(end - first), packed);
	}
	return packed;
}

void packColumn(const std::byte* records, const SectionEntry& entry, const Column& column,
				std::vector<std::byte>& packed)
{
	std::vector<std::uint32_t> values(std::size_t(entry.count), 0);
	for (std::size_t i = 0; i < values.size(); ++i)
		std::memcpy(&values[i], records + i * entry.stride + column.offset, column.bytes);
	std::vector<std::byte> least;
	for (std::uint8_t p = 0; p < std::uint8_t(Predictor::count); ++p)
	{
		std::vector<std::byte> other = packedBy(Predictor(p), values, column.bytes);
		if (p == 0 || other.size() < least.size()) least = std::move(other);
	}
	packed.insert(packed.end(), least.begin(), least.end());
}

// `size` bytes are the group's, which may have fewer codes than others; `left` may be read.
void unpackGroup(const std::byte* from, std::size_t size, std::size_t left, std::uint32_t bits,
				 std::uint32_t (&codes)[kGroup])
{
	if (bits == 0)
	{
		std::fill(std::begin(codes), std::end(codes), 0U);
		return;
	}
	std::byte copy[bytesOfWhole(kMostBits) + sizeof(std::uint64_t)];
	if (left < bytesOfWhole(bits) + sizeof(std::uint64_t))
	{
		std::memset(copy, 0, sizeof copy);
		std::memcpy(copy, from, size);
		from = copy;
	}
	const std::uint64_t mask = (std::uint64_t(1) << bits) - 1;
	for (std::uint32_t i = 0; i < kGroup; ++i)
	{
		std::uint64_t word = 0;
		std::memcpy(&word, from + i * bits / 8, sizeof word);
		codes[i] = std::uint32_t(word >> (i * bits % 8) & mask);
	}
}

// Where it ends; null: it does not fit.
template <class Value, Predictor predictor>
const std::byte* unpackBy(const std::byte* at, const std::byte* end, const SectionEntry& entry, std::byte* to)
{
	std::uint32_t before = 0;
	std::uint32_t codes[kGroup];
	for (std::uint32_t first = 0; first < entry.count; first += kGroup)
	{
		if (at == end) return nullptr;
		const std::uint32_t bits = std::uint32_t(*at++), count = std::min(kGroup, std::uint32_t(entry.count) - first);
		const std::size_t size = bytesOf(bits, count), left = std::size_t(end - at);
		if (bits > kMostBits || left < size) return nullptr;
		unpackGroup(at, size, left, bits, codes);
		at += size;
		for (std::uint32_t i = 0; i < count; ++i, to += entry.stride)
		{
			std::uint32_t value = codes[i];
			if constexpr (predictor == Predictor::kBefore) value = before += unzigzag(value);
			if constexpr (predictor == Predictor::kNumber) value = first + i + unzigzag(value);
			const Value stored = Value(value);
			std::memcpy(to, &stored, sizeof stored);
		}
	}
	return at;
}

template <class Value>
const std::byte* unpackColumn(const std::byte* at, const std::byte* end, const SectionEntry& entry, std::byte* to)
{
	if (at == end) return nullptr;
	switch (Predictor(*at))
	{
		case Predictor::kBefore: return unpackBy<Value, Predictor::kBefore>(at + 1, end, entry, to);
		case Predictor::kNumber: return unpackBy<Value, Predictor::kNumber>(at + 1, end, entry, to);
		case Predictor::kNone: return unpackBy<Value, Predictor::kNone>(at + 1, end, entry, to);
		default: return nullptr;
	}
}

// value + times * predicted, of their bits. What is not finite has not the same bits on all machines.
void shift(float& value, double predicted, std::uint32_t times)
{
	const float rounded = float(predicted);
	std::uint32_t bits = 0, of = 0;
	std::memcpy(&bits, &value, sizeof bits);
	if (std::isfinite(rounded)) std::memcpy(&of, &rounded, sizeof of);
	bits += times * of;
	std::memcpy(&value, &bits, sizeof bits);
}

double offsetOf(const Face& face, const std::array<Vec3, 3>& corners)
{
	const Vec3 normal{double(face.normal[0]), double(face.normal[1]), double(face.normal[2])};
	return double(roundUp(std::max({dot(normal, corners[0]), dot(normal, corners[1]), dot(normal, corners[2])})));
}

constexpr std::uint32_t kTake = 0xFFFFFFFFu, kGive = 1;

void shiftPlane(Face& face, const Node& node, const PlaneRecords& records, std::uint32_t times)
{
	std::array<Vec3, 3> corners;
	for (std::size_t i = 0; i < 3; ++i)
	{
		const std::size_t v = std::size_t(node.firstVertex) + face.vertex[i];
		if (v >= records.vertexCount) return;
		corners[i] = {double(records.x[v]), double(records.y[v]), double(records.z[v])};
	}
	const Vec3 normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
	// The offset is that of the true normal.
	if (times == kTake) shift(face.offset, offsetOf(face, corners), times);
	for (int k = 0; k < 3; ++k) shift(face.normal[k], normal[k], times);
	if (times == kGive) shift(face.offset, offsetOf(face, corners), times);
}

void shiftInward(Node* nodes, std::size_t count, std::uint32_t times)
{
	for (std::size_t i = 0; i < count; ++i)
		for (int k = 0; k < 3; ++k) shift(nodes[i].inward[k], -double(nodes[i].meanNormal[k]), times);
}

// Faces that are no node's, in order, stay as they are: each is looked at once, whatever nodes say.
void shiftPlanes(const PlaneRecords& records, std::uint32_t times)
{
	std::size_t next = 0;
	for (std::size_t i = 0; i < records.nodeCount; ++i)
	{
		const Node& node = records.nodes[i];
		if (node.firstFace != next || node.faceCount > records.faceCount - next) continue;
		for (const std::size_t end = next + node.faceCount; next < end; ++next)
			shiftPlane(records.faces[next], node, records, times);
	}
}

Node* nodesOf(std::vector<std::byte>& block, const SectionEntry (&table)[kSectionCount])
{
	return reinterpret_cast<Node*>(block.data() + table[std::uint32_t(Section::nodes)].offset);
}

PlaneRecords planesOf(std::vector<std::byte>& block, const SectionEntry (&table)[kSectionCount])
{
	const auto at = [&](Section section) { return block.data() + table[std::uint32_t(section)].offset; };
	const auto count = [&](Section section) { return std::size_t(table[std::uint32_t(section)].count); };
	const auto values = [&](Section section) { return reinterpret_cast<const float*>(at(section)); };
	return {nodesOf(block, table), count(Section::nodes),
			reinterpret_cast<Face*>(at(Section::faces)), count(Section::faces),
			values(Section::hullX), values(Section::hullY), values(Section::hullZ),
			std::min({count(Section::hullX), count(Section::hullY), count(Section::hullZ)})};
}
}  // namespace

void restoreInward(std::uint32_t version, Node* nodes, std::size_t count)
{
	if (version != kFirstPackedVersion) shiftInward(nodes, count, kGive);
}

void restorePlanes(std::uint32_t version, const PlaneRecords& records)
{
	if (version != kFirstPackedVersion) shiftPlanes(records, kGive);
}

std::string PackedSections::read(std::byte* records)
{
	const Section section = Section(m_next);
	const SectionEntry& entry = m_table[m_next++];
	for (const Column& column : columnsOf(entry))
	{
		if (entry.count == 0) continue;
		const auto unpackOne = column.bytes == 2 ? unpackColumn<std::uint16_t> : unpackColumn<std::uint32_t>;
		const std::byte* const next = unpackOne(m_at, m_end, entry, records + column.offset);
		if (!next) return std::string("damaged (section ") + sectionName(section) + " cannot be unpacked)";
		m_at = next;
	}
	return m_next == kSectionCount && m_at != m_end ? "bytes follow the last section" : "";
}

std::vector<std::byte> pack(std::vector<std::byte> block)
{
	std::vector<std::byte> packed(block.begin(), block.begin() + std::ptrdiff_t(kFileStartBytes));
	SectionEntry table[kSectionCount];
	std::memcpy(table, block.data() + sizeof(FileHeader), sizeof table);
	shiftInward(nodesOf(block, table), std::size_t(table[std::uint32_t(Section::nodes)].count), kTake);
	shiftPlanes(planesOf(block, table), kTake);
	for (const SectionEntry& entry : table)
		for (const Column& column : columnsOf(entry))
			if (entry.count > 0) packColumn(block.data() + entry.offset, entry, column, packed);
	finishHeader(kPackedVersion, packed);
	return packed;
}

Result<std::vector<std::byte>> unpack(const std::vector<std::byte>& file)
{
	SectionEntry table[kSectionCount];
	std::memcpy(table, file.data() + sizeof(FileHeader), sizeof table);
	const SectionEntry& last = table[kSectionCount - 1];
	std::vector<std::byte> block(std::size_t(last.offset + last.count * last.stride), std::byte(0));
	std::copy(file.begin(), file.begin() + std::ptrdiff_t(kFileStartBytes), block.begin());
	PackedSections sections(file.data() + kFileStartBytes, file.data() + file.size(), table);
	for (const SectionEntry& entry : table)
	{
		const std::string problem = sections.read(block.data() + entry.offset);
		if (!problem.empty()) return Error{problem};
	}
	restoreInward(versionOf(file), nodesOf(block, table), std::size_t(table[std::uint32_t(Section::nodes)].count));
	restorePlanes(versionOf(file), planesOf(block, table));
	finishHeader(kFileVersion, block);
	return block;
}
}  // namespace clod
