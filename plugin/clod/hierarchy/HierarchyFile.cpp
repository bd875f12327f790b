// SPDX-License-Identifier: Zlib
// Writer and reader of the block (HierarchyFormat.h), and of files that are packed (PackedFile.h). Nothing of the input
// is trusted: sizes are compared by division with the bytes that remain, hashes are compared before a record is looked
// at, then validate() runs.
#include <algorithm>
#include <cstring>

#include <xxhash.h>

#include "clod/hierarchy/Hierarchy.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/PackedFile.h"

namespace clod
{

namespace
{
constexpr std::array<const char*, kSectionCount> kSectionNames = {"asset", "levels", "nodes", "cullBoxes", "children",
																  "faces", "hullX",  "hullY", "hullZ"};
constexpr std::array<std::uint32_t, kSectionCount> kStrides = {sizeof(Asset),   sizeof(Level),         sizeof(Node),
															   sizeof(OrientedBox), sizeof(std::uint32_t), sizeof(Face),
															   sizeof(float),   sizeof(float),         sizeof(float)};

std::uint64_t alignUp(std::uint64_t offset)
{
	return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

// Of the first kFileStartBytes bytes.
std::uint64_t hashOfStart(const std::byte* bytes)
{
	std::array<std::byte, kFileStartBytes> start;
	std::memcpy(start.data(), bytes, start.size());
	std::memset(start.data() + offsetof(FileHeader, headerHash), 0, sizeof(std::uint64_t));
	return XXH3_64bits(start.data(), start.size());
}

bool isLittleEndian()
{
	const std::uint32_t mark = kEndianMark;
	unsigned char first = 0;
	std::memcpy(&first, &mark, 1);
	return first == 1;
}

std::string number(std::uint64_t value)
{
	return std::to_string(value);
}

std::string checkHeader(const FileHeader& header, std::uint64_t fileBytes)
{
	if (std::memcmp(header.magic, kFileMagic, sizeof kFileMagic) != 0) return "not a .clod file (wrong first bytes)";
	if (header.endianMark != kEndianMark) return "written with another byte order";
	if (header.version < kFileVersion || header.version > kPackedVersion)
		return "format version " + number(header.version) + "; this library reads versions " + number(kFileVersion) +
			   " to " + number(kPackedVersion) +
			   (header.version < kFileVersion ? ": build it again from its mesh" : ": a newer library is needed");
	if (header.headerBytes != sizeof(FileHeader)) return "header size " + number(header.headerBytes) + " is not 64";
	if (header.fileBytes != fileBytes)
		return "header says " + number(header.fileBytes) + " bytes, the file has " + number(fileBytes);
	if (header.sectionCount != kSectionCount || header.tableOffset != sizeof(FileHeader))
		return "section table of " + number(header.sectionCount) + " entries at " + number(header.tableOffset);
	const bool isZero = std::all_of(header.padding, header.padding + 2, [](std::uint32_t word) { return word == 0; });
	if (!isZero || (header.version == kFileVersion && header.packedHash != 0)) return "header padding is not zero";
	return "";
}

// Offsets follow from counts; the running offset never exceeds fileBytes, so no sum here can overflow.
std::string checkTable(const SectionEntry* table, std::uint64_t fileBytes, bool isWhole)
{
	std::uint64_t end = kFileStartBytes;
	for (std::uint32_t i = 0; i < kSectionCount; ++i)
	{
		const SectionEntry& entry = table[i];
		const std::string name = std::string("section ") + kSectionNames[i];
		if (entry.kind != i || entry.stride != kStrides[i]) return name + ": wrong kind or record size";
		if (entry.offset != alignUp(end)) return name + ": starts at " + number(entry.offset);
		if (entry.offset > fileBytes || entry.count > (fileBytes - entry.offset) / entry.stride)
			return name + ": " + number(entry.count) + " records do not fit into the file";
		if (entry.count >= kNone) return name + ": " + number(entry.count) + " records are too many";
		end = entry.offset + entry.count * entry.stride;
	}
	if (isWhole && end != fileBytes) return number(fileBytes - end) + " bytes follow the last section";
	return "";
}

std::vector<std::byte> startOf(const std::vector<std::byte>& bytes)
{
	return {bytes.begin(), bytes.begin() + std::ptrdiff_t(std::min<std::uint64_t>(bytes.size(), kFileStartBytes))};
}
}  // namespace

const char* sectionName(Section section)
{
	return kSectionNames[std::uint32_t(section)];
}

std::string checkFileStart(const std::vector<std::byte>& start, std::uint64_t fileBytes)
{
	if (!isLittleEndian()) return "this machine's byte order is not supported";
	if (start.size() < kFileStartBytes) return "is " + number(fileBytes) + " bytes, too short for a .clod file";
	FileHeader header;
	std::memcpy(&header, start.data(), sizeof header);
	std::string problem = checkHeader(header, fileBytes);
	if (!problem.empty()) return problem;
	if (header.headerHash != hashOfStart(start.data())) return "damaged (checksum of the header)";
	SectionEntry table[kSectionCount];
	std::memcpy(table, start.data() + sizeof header, sizeof table);
	if (header.version == kFileVersion) return checkTable(table, fileBytes, true);
	return checkTable(table, std::min(kMostUnpacked * fileBytes, kMostBytes), false);
}

std::uint32_t versionOf(const std::vector<std::byte>& start)
{
	FileHeader header;
	std::memcpy(&header, start.data(), sizeof header);
	return header.version;
}

bool isPacked(const std::vector<std::byte>& start)
{
	return versionOf(start) >= kFirstPackedVersion;
}

void finishHeader(std::uint32_t version, std::vector<std::byte>& bytes)
{
	FileHeader header;
	std::memcpy(&header, bytes.data(), sizeof header);
	header.version = version;
	header.fileBytes = bytes.size();
	header.packedHash =
		version < kFirstPackedVersion ? 0 : XXH3_64bits(bytes.data() + kFileStartBytes, bytes.size() - kFileStartBytes);
	std::memcpy(bytes.data(), &header, sizeof header);
	header.headerHash = hashOfStart(bytes.data());
	std::memcpy(bytes.data(), &header, sizeof header);
}

std::string checkPacked(const std::vector<std::byte>& start, const std::byte* packed, std::size_t size)
{
	FileHeader header;
	std::memcpy(&header, start.data(), sizeof header);
	return XXH3_64bits(packed, size) == header.packedHash ? "" : "damaged (checksum of the packed sections)";
}

// Builds the object over the block; the only writer of Hierarchy's members.
struct HierarchyReader
{
	static std::string checkSections(const std::vector<std::byte>& bytes, const SectionEntry* table)
	{
		std::uint64_t end = kFileStartBytes;
		for (std::uint32_t i = 0; i < kSectionCount; ++i)
		{
			const std::byte* const gap = bytes.data() + end;
			if (std::any_of(gap, bytes.data() + table[i].offset, [](std::byte b) { return b != std::byte(0); }))
				return std::string("padding before section ") + kSectionNames[i] + " is not zero";
			end = table[i].offset + table[i].count * table[i].stride;
			if (XXH3_64bits(bytes.data() + table[i].offset, std::size_t(end - table[i].offset)) != table[i].hash)
				return std::string("damaged (checksum of section ") + kSectionNames[i] + ")";
		}
		return "";
	}

	template <class T>
	static Span<T> view(const std::vector<std::byte>& bytes, const SectionEntry& entry)
	{
		return {reinterpret_cast<const T*>(bytes.data() + entry.offset), std::size_t(entry.count)};
	}

	static std::string checkCounts(const SectionEntry* table)
	{
		const auto count = [table](Section s) { return table[std::uint32_t(s)].count; };
		if (count(Section::asset) != 1) return "section asset has " + number(count(Section::asset)) + " records";
		if (count(Section::levels) == 0) return "no levels";
		if (count(Section::nodes) == 0) return "no nodes";
		if (count(Section::cullBoxes) != count(Section::nodes))
			return number(count(Section::cullBoxes)) + " culling boxes for " + number(count(Section::nodes)) + " nodes";
		if (count(Section::hullX) != count(Section::hullY) || count(Section::hullX) != count(Section::hullZ))
			return "hull coordinates of different length";
		return "";
	}

	static void bind(Hierarchy& h, const SectionEntry* table)
	{
		const auto entry = [table](Section s) -> const SectionEntry& { return table[std::uint32_t(s)]; };
		h.m_asset = view<Asset>(h.m_bytes, entry(Section::asset)).data;
		h.m_levels = view<Level>(h.m_bytes, entry(Section::levels));
		h.m_nodes = view<Node>(h.m_bytes, entry(Section::nodes));
		h.m_cullBoxes = view<OrientedBox>(h.m_bytes, entry(Section::cullBoxes));
		h.m_children = view<std::uint32_t>(h.m_bytes, entry(Section::children));
		h.m_faces = view<Face>(h.m_bytes, entry(Section::faces));
		h.m_hullX = view<float>(h.m_bytes, entry(Section::hullX)).data;
		h.m_hullY = view<float>(h.m_bytes, entry(Section::hullY)).data;
		h.m_hullZ = view<float>(h.m_bytes, entry(Section::hullZ)).data;
		h.m_hullSize = std::size_t(entry(Section::hullX).count);
		h.m_contentHash = XXH3_64bits(h.m_bytes.data(), h.m_bytes.size());
		for (std::uint32_t i = 0; i < h.m_levels.size; ++i)
			if ((h.m_levels[i].flags & kClodNode) != 0) h.m_coarsestClodLevel = i;
	}

	static Result<std::shared_ptr<const Hierarchy>> read(std::vector<std::byte> bytes)
	{
		std::string problem = checkFileStart(startOf(bytes), bytes.size());
		if (!problem.empty()) return Error{problem};
		if (isPacked(bytes))
		{
			problem = checkPacked(bytes, bytes.data() + kFileStartBytes, bytes.size() - kFileStartBytes);
			if (!problem.empty()) return Error{problem};
			Result<std::vector<std::byte>> block = unpack(bytes);
			if (!block) return Error{block.error()};
			bytes = std::move(block.value());
		}
		SectionEntry table[kSectionCount];
		std::memcpy(table, bytes.data() + sizeof(FileHeader), sizeof table);
		problem = checkSections(bytes, table);
		if (problem.empty()) problem = checkCounts(table);
		if (!problem.empty()) return Error{problem};
		std::shared_ptr<const Hierarchy> hierarchy = own(std::move(bytes));
		problem = validate(*hierarchy);
		if (!problem.empty()) return Error{problem};
		return hierarchy;
	}

	// Precondition: bytes as encode() writes them.
	static std::shared_ptr<const Hierarchy> own(std::vector<std::byte> bytes, std::uint32_t finestLevel = 0)
	{
		const std::shared_ptr<Hierarchy> hierarchy(new Hierarchy);
		hierarchy->m_finestLevel = finestLevel;
		hierarchy->m_bytes = std::move(bytes);
		SectionEntry table[kSectionCount];
		std::memcpy(table, hierarchy->m_bytes.data() + sizeof(FileHeader), sizeof table);
		bind(*hierarchy, table);
		return hierarchy;
	}
};

Result<std::shared_ptr<const Hierarchy>> Hierarchy::fromBytes(std::vector<std::byte> bytes)
{
	return withinMemory("", [&] { return HierarchyReader::read(std::move(bytes)); });
}

std::shared_ptr<const Hierarchy> Hierarchy::fromOwnBytes(std::vector<std::byte> bytes, std::uint32_t finestLevel)
{
	return HierarchyReader::own(std::move(bytes), finestLevel);
}

std::vector<std::byte> encode(const HierarchyContent& content)
{
	const std::array<const void*, kSectionCount> sources = {
		&content.asset,           content.levels.data(),   content.nodes.data(),
		content.cullBoxes.data(), content.children.data(), content.faces.data(),
		content.hullX.data(),     content.hullY.data(),    content.hullZ.data()};
	const std::array<std::size_t, kSectionCount> counts = {1,
														   content.levels.size(),
														   content.nodes.size(),
														   content.cullBoxes.size(),
														   content.children.size(),
														   content.faces.size(),
														   content.hullX.size(),
														   content.hullY.size(),
														   content.hullZ.size()};
	SectionEntry table[kSectionCount];
	std::uint64_t end = kFileStartBytes;
	for (std::uint32_t i = 0; i < kSectionCount; ++i)
	{
		const std::size_t size = counts[i] * kStrides[i];
		table[i] = {i, kStrides[i], alignUp(end), counts[i], XXH3_64bits(sources[i], size)};
		end = table[i].offset + size;
	}
	std::vector<std::byte> bytes(std::size_t(end), std::byte(0));
	FileHeader header{};
	std::memcpy(header.magic, kFileMagic, sizeof kFileMagic);
	header.endianMark = kEndianMark;
	header.headerBytes = sizeof(FileHeader);
	header.sectionCount = kSectionCount;
	header.tableOffset = sizeof(FileHeader);
	std::memcpy(bytes.data(), &header, sizeof header);
	std::memcpy(bytes.data() + sizeof header, table, sizeof table);
	finishHeader(kFileVersion, bytes);
	for (std::uint32_t i = 0; i < kSectionCount; ++i)
		if (counts[i] > 0) std::memcpy(bytes.data() + table[i].offset, sources[i], counts[i] * kStrides[i]);
	return bytes;
}
}  // namespace clod
