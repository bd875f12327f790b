// SPDX-License-Identifier: Zlib
// The frame of a hierarchy's block, which is a .clod file of version 1: header, section table, sections. Files are
// written packed, as version 3 (PackedFile.h), and unpacked to this.
//
//   [header 64 bytes][table: kSectionCount entries of 32 bytes][zero padding][section][zero padding][section]...
//
// Every section starts at a multiple of 64 bytes; offsets follow from the counts, so there is exactly one file for one
// content. The header's hash (xxh3, 64 bits) covers header and table, each entry's hash covers its section; padding
// must be zero and nothing follows the last section. Little-endian.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "clod/hierarchy/Result.h"

namespace clod
{
inline constexpr char kFileMagic[8] = {'C', 'L', 'O', 'D', 'f', 'i', 'l', 'e'};
inline constexpr std::uint32_t kFileVersion = 1;
inline constexpr std::uint32_t kEndianMark = 0x04030201u;
inline constexpr std::uint64_t kSectionAlignment = 64;
// Larger files, and blocks of packed ones, are refused before anything is allocated.
inline constexpr std::uint64_t kMostBytes = std::uint64_t(1) << 32;

enum class Section : std::uint32_t
{
	asset,
	levels,
	nodes,
	cullBoxes,
	children,
	faces,
	hullX,
	hullY,
	hullZ,
	count
};
inline constexpr std::uint32_t kSectionCount = std::uint32_t(Section::count);

struct FileHeader
{
	char magic[8];
	std::uint32_t version;
	std::uint32_t endianMark;
	std::uint32_t headerBytes;
	std::uint32_t sectionCount;
	std::uint64_t fileBytes;
	std::uint64_t tableOffset;
	std::uint64_t headerHash;  // of header and table, with this field zero
	std::uint64_t packedHash;  // of all that follows the table of a packed file; else 0
	std::uint32_t padding[2];
};
static_assert(sizeof(FileHeader) == 64);

struct SectionEntry
{
	std::uint32_t kind;    // Section, in order
	std::uint32_t stride;  // bytes of one record
	std::uint64_t offset;
	std::uint64_t count;
	std::uint64_t hash;
};
static_assert(sizeof(SectionEntry) == 32);

inline constexpr std::uint64_t kFileStartBytes = sizeof(FileHeader) + kSectionCount * sizeof(SectionEntry);

// Checks header and table (the first kFileStartBytes of a file of fileBytes bytes); empty = sound. After it every
// section lies inside the file, or, of a packed one, inside a block that it can hold.
std::string checkFileStart(const std::vector<std::byte>& start, std::uint64_t fileBytes);
const char* sectionName(Section section);
std::uint32_t versionOf(const std::vector<std::byte>& start);
bool isPacked(const std::vector<std::byte>& start);
// As a file of the version has them, whole as it is: size and hashes.
void finishHeader(std::uint32_t version, std::vector<std::byte>& bytes);
// Of a packed file: empty where what follows its table is what was written.
std::string checkPacked(const std::vector<std::byte>& start, const std::byte* packed, std::size_t size);

// What `make` returns, a Result, or that there is too little memory for it.
template <class Make>
auto withinMemory(const std::string& name, const Make& make) -> decltype(make())
{
	try
	{
		return make();
	}
	catch (const std::bad_alloc&)
	{
	}
	catch (const std::length_error&)
	{
	}
	return Error{name + "there is not enough memory"};
}

// Opens a regular file that is no larger than any of ours: its size.
Result<std::uint64_t> openFile(const std::string& path, std::ifstream& stream);
// Its header and table, as much as there is of them, checked; empty = sound.
std::string readFileStart(std::ifstream& stream, std::uint64_t size, std::vector<std::byte>& start);
}  // namespace clod
