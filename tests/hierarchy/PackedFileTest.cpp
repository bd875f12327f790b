// SPDX-License-Identifier: GPL-3.0-or-later
// Packed files: the block comes back bit for bit, is much smaller, and whatever else is in the file is refused.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include <xxhash.h>

#include "clod/hierarchy/Hierarchy.h"
#include "clod/hierarchy/PackedFile.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
namespace
{
using Bytes = std::vector<std::byte>;

TEST(PackedFile, IsTheBlockAgainAndMuchSmaller)
{
	for (const char* name : {"torus-900", "cup-3000", "spoon-3000"})
	{
		const Bytes& block = body(name).hierarchy->bytes();
		const Bytes packed = pack(block);
		const auto hierarchy = Hierarchy::fromBytes(packed);
		ASSERT_TRUE(hierarchy) << hierarchy.error();
		EXPECT_EQ(hierarchy.value()->bytes(), block) << name;
		EXPECT_EQ(hierarchy.value()->contentHash(), body(name).hierarchy->contentHash()) << name;
		EXPECT_EQ(pack(block), packed) << name;
		EXPECT_LT(double(packed.size()), 0.45 * double(block.size())) << name;
	}
}

// Records of any bits: values of all widths, in all columns, numbers of records about whole groups.
TEST(PackedFile, HoldsAnyRecords)
{
	std::mt19937_64 random(1);
	for (std::size_t count = 1; count < 70; ++count)
	{
		HierarchyContent content;
		content.levels.resize(count % 5);
		content.nodes.resize(count);
		content.cullBoxes.resize(count);
		content.children.resize(count + 3);
		content.faces.resize(2 * count);
		content.hullX.resize(count), content.hullY.resize(count), content.hullZ.resize(count);
		Bytes block = encode(content);
		const int shift = int(random() % 64);
		for (std::size_t i = kFileStartBytes; i + 8 <= block.size(); i += 8)
		{
			const std::uint64_t bits = random() >> shift;
			std::memcpy(block.data() + i, &bits, 8);
		}
		SectionEntry table[kSectionCount];
		std::memcpy(table, block.data() + sizeof(FileHeader), sizeof table);
		std::uint64_t end = kFileStartBytes;
		for (const SectionEntry& entry : table)  // padding is no record
		{
			std::fill(block.begin() + std::ptrdiff_t(end), block.begin() + std::ptrdiff_t(entry.offset), std::byte(0));
			end = entry.offset + entry.count * entry.stride;
		}
		// Every other time two faces a node, with corners of its own, whose planes follow from them or from what is no number.
		for (std::size_t i = 0; count % 2 == 0 && i < count; ++i)
		{
			auto* const node = reinterpret_cast<Node*>(block.data() + table[std::uint32_t(Section::nodes)].offset) + i;
			auto* const face = reinterpret_cast<Face*>(block.data() + table[std::uint32_t(Section::faces)].offset) + 2 * i;
			node->firstFace = std::uint32_t(2 * i), node->faceCount = 2, node->firstVertex = std::uint32_t(random() % count);
			for (std::size_t k = 0; k < 6; ++k) face[k / 3].vertex[k % 3] = std::uint16_t(random() % count);
		}
		const Bytes packed = pack(block);
		ASSERT_EQ(checkFileStart({packed.begin(), packed.begin() + std::ptrdiff_t(kFileStartBytes)}, packed.size()), "");
		ASSERT_EQ(unpack(packed).value(), block) << count;
	}
}

TEST(PackedFile, EveryTruncationTrailingByteAndFlippedBitIsRefused)
{
	Bytes bytes = pack(body("patches-box").hierarchy->bytes());
	ASSERT_EQ(refusal(bytes), "");
	for (std::size_t size = 0; size < bytes.size(); ++size)
		ASSERT_NE(refusal(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size))), "") << size;
	Bytes longer = bytes;
	longer.push_back(std::byte(0));
	EXPECT_NE(refusal(longer), "");
	for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit)
	{
		bytes[bit / 8] ^= std::byte(1 << (bit % 8));
		ASSERT_NE(refusal(bytes), "") << bit;
		bytes[bit / 8] ^= std::byte(1 << (bit % 8));
	}
}

// Written by somebody who knows the hashes.
TEST(PackedFile, WhatCannotBeUnpackedIsRefused)
{
	const Bytes good = pack(body("patches-torus").hierarchy->bytes());
	std::mt19937_64 random(2);
	for (int i = 0; i < 3000; ++i)
	{
		Bytes bytes = good;
		for (std::uint64_t n = 1 + random() % 4; n > 0; --n)
			bytes[kFileStartBytes + random() % (bytes.size() - kFileStartBytes)] = std::byte(random());
		if (random() % 3 == 0) bytes.resize(kFileStartBytes + random() % (bytes.size() - kFileStartBytes));
		if (random() % 3 == 0) bytes.push_back(std::byte(random()));
		finishHeader(kPackedVersion, bytes);
		const std::string problem = refusal(bytes);
		EXPECT_TRUE(!problem.empty() || Hierarchy::fromBytes(bytes).value()->bytes() == body("patches-torus").hierarchy->bytes()) << i;
	}
	Bytes longer = good;
	longer.push_back(std::byte(0));
	finishHeader(kPackedVersion, longer);
	EXPECT_NE(refusal(longer).find("bytes follow the last section"), std::string::npos) << refusal(longer);
	// Far more records than the file can hold: refused before anything is allocated.
	for (const std::uint64_t count : {std::uint64_t(1) << 30, std::uint64_t(0xFFFFFFFE)})
	{
		Bytes bytes = good;
		SectionEntry last;
		const std::size_t at = kFileStartBytes - sizeof last;
		std::memcpy(&last, bytes.data() + at, sizeof last);
		last.count = count;
		std::memcpy(bytes.data() + at, &last, sizeof last);
		finishHeader(kPackedVersion, bytes);
		EXPECT_NE(refusal(bytes).find("do not fit into the file"), std::string::npos) << refusal(bytes);
	}
}
}  // namespace
}  // namespace clod::test
