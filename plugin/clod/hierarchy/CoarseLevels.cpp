// SPDX-License-Identifier: Zlib
// A hierarchy of a file's coarse levels alone. The file is read through once, as the checksums are of whole sections, a
// packed one at once and then unpacked section by section; what is finer is dropped as it comes, what is kept is
// numbered anew and held to the same rules.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

#include <xxhash.h>

#include "clod/hierarchy/Hierarchy.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/PackedFile.h"

namespace clod
{
namespace
{
constexpr std::size_t kChunk = 1 << 16;  // bytes read at once

// Section after section, in the file's order.
class SectionReader
{
public:
	// packed: what follows the start of a packed file, which the stream then is not asked for.
	SectionReader(std::ifstream& stream, const std::optional<std::vector<std::byte>>& packed, std::uint32_t version,
				  const SectionEntry* table)
		: m_stream(stream),
		  m_table(table),
		  m_version(version),
		  m_isPacked(packed.has_value()),
		  m_packed(m_isPacked ? packed->data() : nullptr, m_isPacked ? packed->data() + packed->size() : nullptr,
				   table),
		  m_hash(XXH3_createState(), &XXH3_freeState),
		  m_chunk(kChunk)
	{
		m_stream.seekg(std::streamoff(kFileStartBytes));
	}

	std::uint64_t countOf(Section section) const { return m_table[std::uint32_t(section)].count; }

	// Keeps its records from `first` on; empty where it is sound. Precondition: first is at most their count.
	template <class T>
	std::string read(Section section, std::uint64_t first, std::vector<T>& kept)
	{
		const SectionEntry& entry = m_table[std::uint32_t(section)];
		kept.resize(std::size_t(entry.count - first));
		std::byte* to = reinterpret_cast<std::byte*>(kept.data());
		std::uint64_t dropped = first * sizeof(T);
		if (m_isPacked) return unpack(section, dropped, to);
		while (m_at < entry.offset)
		{
			const std::size_t size = take(entry.offset - m_at);
			if (!m_stream) return unreadable(section);
			const auto end = m_chunk.begin() + std::ptrdiff_t(size);
			if (std::any_of(m_chunk.begin(), end, [](std::byte b) { return b != std::byte(0); }))
				return std::string("padding before section ") + sectionName(section) + " is not zero";
		}
		XXH3_64bits_reset(m_hash.get());
		for (const std::uint64_t end = entry.offset + entry.count * sizeof(T); m_at < end;)
		{
			const std::size_t size = take(end - m_at);
			if (!m_stream) return unreadable(section);
			XXH3_64bits_update(m_hash.get(), m_chunk.data(), size);
			const std::size_t skip = std::size_t(std::min<std::uint64_t>(size, dropped));
			dropped -= skip;
			if (size > skip) std::memcpy(to, m_chunk.data() + skip, size - skip);
			to += size - skip;
		}
		if (XXH3_64bits_digest(m_hash.get()) == entry.hash) return "";
		return std::string("damaged (checksum of section ") + sectionName(section) + ")";
	}

private:
	// Of one section at once.
	std::string unpack(Section section, std::uint64_t dropped, std::byte* to)
	{
		const SectionEntry& entry = m_table[std::uint32_t(section)];
		const std::size_t size = std::size_t(entry.count * entry.stride), skip = std::size_t(dropped);
		std::vector<std::byte> records(size);
		std::string problem = m_packed.read(records.data());
		if (!problem.empty()) return problem;
		if (section == Section::nodes)
			restoreInward(m_version, reinterpret_cast<Node*>(records.data()), std::size_t(entry.count));
		// Faces lack their planes still, corners that these follow from are dropped: the file's checksum holds them.
		if (section != Section::faces && XXH3_64bits(records.data(), size) != entry.hash)
			return std::string("damaged (checksum of section ") + sectionName(section) + ")";
		if (size > skip) std::memcpy(to, records.data() + skip, size - skip);
		return "";
	}
	std::size_t take(std::uint64_t wanted)
	{
		const std::size_t size = std::size_t(std::min<std::uint64_t>(wanted, kChunk));
		m_stream.read(reinterpret_cast<char*>(m_chunk.data()), std::streamsize(size));
		m_at += size;
		return size;
	}
	static std::string unreadable(Section section)
	{
		return std::string("cannot be read to the end of section ") + sectionName(section);
	}

	std::ifstream& m_stream;
	const SectionEntry* m_table;
	const std::uint32_t m_version;
	const bool m_isPacked;
	PackedSections m_packed;
	std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> m_hash;
	std::vector<std::byte> m_chunk;
	std::uint64_t m_at = kFileStartBytes;
};

struct Coarse
{
	HierarchyContent content;
	std::uint32_t finest = 0;
	bool isWhole = true;  // no child of what is kept lies below
};

// Numbers as the rest alone has them. What is out of range stays so: validate() finds it.
void renumber(Coarse& coarse, std::uint32_t firstChild)
{
	HierarchyContent& kept = coarse.content;
	const std::uint32_t firstNode = kept.levels[0].firstNode, firstFace = kept.levels[0].firstFace;
	const std::uint32_t firstVertex = kept.nodes[0].firstVertex;
	for (Level& level : kept.levels)
	{
		level.firstNode -= firstNode;
		level.firstFace -= firstFace;
	}
	for (Node& node : kept.nodes)
	{
		const bool isLeaf = node.level == coarse.finest;
		node.firstChild = isLeaf ? 0 : node.firstChild - firstChild;
		if (isLeaf) node.childCount = node.primaryChildCount = 0;
		node.firstVertex -= firstVertex;
		node.firstFace -= firstFace;
		node.level -= coarse.finest;
	}
	for (std::uint32_t& child : kept.children)
	{
		coarse.isWhole = coarse.isWhole && child >= firstNode;
		child -= firstNode;
	}
	for (Face& face : kept.faces)
		for (std::uint32_t& neighbour : face.neighbour) neighbour -= firstFace;
}

std::string levelError(const std::vector<Level>& levels, std::uint32_t finest, const SectionReader& reader)
{
	std::size_t contactLevels = 0;
	while (contactLevels < levels.size() && (levels[contactLevels].flags & kClodNode) != 0) ++contactLevels;
	if (finest >= contactLevels)
		return "level " + std::to_string(finest) + " is asked for, its contact levels end at " +
			   std::to_string(std::int64_t(contactLevels) - 1);
	const Level& level = levels[finest];
	if (level.firstNode >= reader.countOf(Section::nodes) || level.firstFace > reader.countOf(Section::faces))
		return "level " + std::to_string(finest) + ": begins beyond the end";
	return "";
}

std::string readNodes(SectionReader& reader, Coarse& coarse, std::uint32_t& firstChild)
{
	HierarchyContent& kept = coarse.content;
	const std::uint32_t firstNode = kept.levels[0].firstNode;
	std::string problem = reader.read(Section::nodes, firstNode, kept.nodes);
	if (!problem.empty()) return problem;
	if (kept.nodes[0].firstVertex > reader.countOf(Section::hullX)) return "its vertices begin beyond the end";
	const auto above = std::find_if(kept.nodes.begin(), kept.nodes.end(),
									[&](const Node& node) { return node.level > coarse.finest; });
	firstChild = above == kept.nodes.end() ? std::uint32_t(reader.countOf(Section::children)) : above->firstChild;
	if (firstChild > reader.countOf(Section::children)) return "its children begin beyond the end";
	return "";
}

// Precondition: the file's start is sound. The first problem, or empty.
std::string readCoarse(std::ifstream& stream, const std::optional<std::vector<std::byte>>& packed,
					   std::uint32_t version, const SectionEntry* table, Coarse& coarse)
{
	HierarchyContent& kept = coarse.content;
	SectionReader reader(stream, packed, version, table);
	if (reader.countOf(Section::asset) != 1 || reader.countOf(Section::cullBoxes) != reader.countOf(Section::nodes))
		return "records of its sections do not belong together";
	if (reader.countOf(Section::hullX) != reader.countOf(Section::hullY) ||
		reader.countOf(Section::hullX) != reader.countOf(Section::hullZ))
		return "hull coordinates of different length";
	std::vector<Asset> assets;
	std::vector<Level> levels;
	std::uint32_t firstChild = 0;
	std::string problem = reader.read(Section::asset, 0, assets);
	if (problem.empty()) problem = reader.read(Section::levels, 0, levels);
	if (problem.empty()) problem = levelError(levels, coarse.finest, reader);
	if (!problem.empty()) return problem;
	kept.asset = assets[0];
	kept.levels.assign(levels.begin() + coarse.finest, levels.end());
	problem = readNodes(reader, coarse, firstChild);
	const std::uint32_t firstVertex = problem.empty() ? kept.nodes[0].firstVertex : 0;
	if (problem.empty()) problem = reader.read(Section::cullBoxes, kept.levels[0].firstNode, kept.cullBoxes);
	if (problem.empty()) problem = reader.read(Section::children, firstChild, kept.children);
	if (problem.empty()) problem = reader.read(Section::faces, kept.levels[0].firstFace, kept.faces);
	if (problem.empty()) problem = reader.read(Section::hullX, firstVertex, kept.hullX);
	if (problem.empty()) problem = reader.read(Section::hullY, firstVertex, kept.hullY);
	if (problem.empty()) problem = reader.read(Section::hullZ, firstVertex, kept.hullZ);
	if (!problem.empty()) return problem;
	renumber(coarse, firstChild);
	if (packed)
		restorePlanes(version, {kept.nodes.data(), kept.nodes.size(), kept.faces.data(), kept.faces.size(),
								kept.hullX.data(), kept.hullY.data(), kept.hullZ.data(), kept.hullX.size()});
	return problem;
}

Result<std::shared_ptr<const Hierarchy>> loadCoarse(const std::string& path, std::uint32_t finest)
{
	const auto refused = [&path](const std::string& problem) { return Error{path + ": " + problem}; };
	std::ifstream stream;
	const Result<std::uint64_t> size = openFile(path, stream);
	if (!size) return Error{size.error()};
	std::vector<std::byte> start;
	std::string problem = readFileStart(stream, size.value(), start);
	if (!problem.empty()) return refused(problem);
	SectionEntry table[kSectionCount];
	std::memcpy(table, start.data() + sizeof(FileHeader), sizeof table);
	std::optional<std::vector<std::byte>> packed;
	if (isPacked(start))
	{
		packed.emplace(std::size_t(size.value() - kFileStartBytes));
		stream.read(reinterpret_cast<char*>(packed->data()), std::streamsize(packed->size()));
		problem = stream ? checkPacked(start, packed->data(), packed->size()) : "cannot be read to its end";
		if (!problem.empty()) return refused(problem);
	}
	Coarse coarse;
	// Where what is coarser has children below the level they are loaded, too.
	for (coarse.finest = finest; coarse.finest > 0; coarse = Coarse{{}, coarse.finest - 1})
	{
		problem = readCoarse(stream, packed, versionOf(start), table, coarse);
		if (!problem.empty()) return refused(problem);
		if (!coarse.isWhole) continue;
		std::shared_ptr<const Hierarchy> hierarchy = Hierarchy::fromOwnBytes(encode(coarse.content), coarse.finest);
		problem = validate(*hierarchy);
		if (!problem.empty()) return refused("levels from " + std::to_string(coarse.finest) + " on: " + problem);
		return hierarchy;
	}
	return Hierarchy::load(path);
}
}  // namespace

Result<std::shared_ptr<const Hierarchy>> Hierarchy::load(const std::string& path, std::uint32_t finest)
{
	if (finest == 0) return load(path);
	return withinMemory(path + ": ", [&] { return loadCoarse(path, finest); });
}
}  // namespace clod
