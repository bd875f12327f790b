// SPDX-License-Identifier: GPL-3.0-or-later
// The .clod file: every truncation, every flipped bit, every wrong count is refused; every rule of Layout.h fires.
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <array>
#include <stdexcept>
#include <filesystem>
#include <functional>
#include <limits>

#include "clod/hierarchy/BoundGrid.h"
#include "clod/hierarchy/DerivedData.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "tests/query/Bodies.h"
#include "tests/support/Files.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
namespace
{
using Bytes = std::vector<std::byte>;

const HierarchyContent& box()
{
	static const HierarchyContent content = contentOf(*body("patches-box").hierarchy);
	return content;
}

const HierarchyContent& levels()
{
	static const HierarchyContent content = contentOf(*body("patches-torus").hierarchy);
	return content;
}

void setHeaderHash(Bytes& bytes)
{
	if (bytes.size() < kFileStartBytes) throw std::invalid_argument("no header to hash");
	const auto at = bytes.begin() + offsetof(FileHeader, headerHash);
	std::fill_n(at, 8, std::byte{0});
	const std::uint64_t hash = XXH3_64bits(bytes.data(), kFileStartBytes);
	std::array<std::byte, 8> stored;
	std::memcpy(stored.data(), &hash, stored.size());
	std::copy(stored.begin(), stored.end(), at);
}

TEST(HierarchyFile, RoundTripIsByteForByte)
{
	const Bytes bytes = encode(levels());
	const auto loadedOnce = loaded(levels());
	EXPECT_EQ(loadedOnce->bytes(), bytes);
	EXPECT_EQ(loadedOnce->asset().triangleCount, 256u);
	EXPECT_EQ(loadedOnce->root(), levels().nodes.size() - 1);
	const auto answers = [](const Level& level) { return (level.flags & kClodNode) != 0; };
	const auto count = std::count_if(levels().levels.begin(), levels().levels.end(), answers);
	EXPECT_GE(count, 2);  // the two of the mesh, and bridged ones
	EXPECT_EQ(loadedOnce->coarsestClodLevel(), count - 1);
	EXPECT_EQ(encode(levels()), bytes);
}

TEST(HierarchyFile, EveryTruncationAndTrailingByteIsRefused)
{
	const Bytes bytes = encode(box());
	for (std::size_t size = 0; size < bytes.size(); ++size)
		ASSERT_NE(refusal(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size))), "") << size;
	Bytes longer = bytes;
	longer.push_back(std::byte(0));
	EXPECT_NE(refusal(longer), "");
}

TEST(HierarchyFile, EveryFlippedBitIsRefused)
{
	Bytes bytes = encode(box());
	for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit)
	{
		bytes[bit / 8] ^= std::byte(1 << (bit % 8));
		ASSERT_NE(refusal(bytes), "") << bit;
		bytes[bit / 8] ^= std::byte(1 << (bit % 8));
	}
	EXPECT_EQ(refusal(bytes), "");
}

TEST(HierarchyFile, WrongCountsAreRefusedBeforeAnythingIsRead)
{
	const Bytes good = encode(levels());
	for (std::uint32_t section = 0; section < kSectionCount; ++section)
	{
		const std::size_t at = sizeof(FileHeader) + section * sizeof(SectionEntry) + offsetof(SectionEntry, count);
		std::uint64_t n;
		std::memcpy(&n, good.data() + at, 8);
		for (std::uint64_t count :
			 {std::uint64_t(0), n - 1, n + 1, std::uint64_t(1) << 31, (std::uint64_t(1) << 31) - 1,
			  (std::uint64_t(1) << 32) - 1, std::uint64_t(1) << 63, ~std::uint64_t(0)})
		{
			Bytes bytes = good;
			std::memcpy(bytes.data() + at, &count, 8);
			setHeaderHash(bytes);
			if (count == n) continue;
			ASSERT_NE(refusal(bytes), "") << section << " " << count;
			const bool isNamed = refusal(bytes).find("do not fit into the file") != std::string::npos;
			EXPECT_TRUE(isNamed || count <= bytes.size()) << refusal(bytes);
		}
	}
}

TEST(HierarchyFile, OtherVersionsAndByteOrdersAreNamed)
{
	Bytes bytes = encode(box());
	ASSERT_EQ(bytes[offsetof(FileHeader, version)], std::byte(1));
	bytes[offsetof(FileHeader, version)] = std::byte(0);
	setHeaderHash(bytes);
	EXPECT_EQ(refusal(bytes), "format version 0; this library reads versions 1 to 3: build it again from its mesh");
	bytes[offsetof(FileHeader, version)] = std::byte(4);
	setHeaderHash(bytes);
	EXPECT_EQ(refusal(bytes), "format version 4; this library reads versions 1 to 3: a newer library is needed");
	bytes = encode(box());
	std::swap(bytes[offsetof(FileHeader, endianMark)], bytes[offsetof(FileHeader, endianMark) + 3]);
	EXPECT_NE(refusal(bytes).find("byte order"), std::string::npos);
}

TEST(BoundGrid, RoundsToTheNextOfThirteenBits)
{
	for (const double v : {0.0, 1e-44, 3e-39, 1.0 / 3, 1.0, 1.0 + 1e-9, 4097.0 / 4096, 12345.678, 3e38})
	{
		const float above = boundAtLeast(v), below = boundAtMost(v);
		EXPECT_TRUE(isBound(above) && isBound(below)) << v;
		EXPECT_GE(double(above), v);
		EXPECT_LE(double(below), v);
		if (v < 1e-37) continue;
		EXPECT_LE(double(above), v * (1 + 0x1p-12)) << v;
		EXPECT_GE(double(below), v * (1 - 0x1p-12)) << v;
	}
	EXPECT_EQ(boundAtLeast(double(kLargestBound)), kLargestBound);
	EXPECT_FALSE(isBound(std::nextafter(1.0f, 2.0f)));
	EXPECT_TRUE(isAnchor(nearestAnchor(0.123456789, 0.7f), 0.7f));
	EXPECT_NEAR(double(nearestAnchor(-0.123456789, 0.7f)), -0.123456789, 0x1p-22);
	EXPECT_FALSE(isAnchor(0.123456789f, 0.7f));
}

// Files of each version as it was first written (a solid L of 2 x 3 x 1): they can be read as long as the version is.
TEST(HierarchyFile, ReadsTheFirstFilesOfItsVersions)
{
	for (const char* version : {"1", "2", "3"})
	{
		const std::string path = std::string(CLOD_FILE_OF_VERSION) + version + ".clod";
		const auto ell = Hierarchy::load(path);
		ASSERT_TRUE(ell) << ell.error();
		const Hierarchy& h = *ell.value();
		EXPECT_EQ(h.contentHash(), 14043706252299576452ull);
		EXPECT_EQ(h.asset().triangleCount, 20u);
		EXPECT_NEAR(h.asset().volume, 4, 1e-12);
		EXPECT_EQ(h.levels()[0].nodeCount, 2u);
		EXPECT_EQ(h.node(h.root()).vertexCount, 10u);
		EXPECT_EQ(h.node(h.root()).flags, 0u);
	}
}

TEST(HierarchyFile, LoadReadsRegularFilesOnly)
{
	const TemporaryFolder folder;
	const std::string good = folder.fileOf("good.clod", encode(box()));
	const std::string fifo = folder.file("fifo"), huge = folder.file("huge", "x");
	EXPECT_TRUE(Hierarchy::load(good));
	std::filesystem::resize_file(huge, std::uintmax_t(1) << 33);
	ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
	for (const std::string& path : {folder.path().string(), fifo, std::string("/dev/zero"), huge, good + ".missing"})
	{
		const auto result = Hierarchy::load(path);
		ASSERT_FALSE(result) << path;
		EXPECT_NE(result.error().find(path), std::string::npos);
	}
	std::filesystem::resize_file(huge, 1 << 20);
	EXPECT_FALSE(Hierarchy::load(huge));
}

// Each breaks one rule of an otherwise sound content; the message must name it.
struct Fault
{
	const char* message;
	std::function<void(HierarchyContent&)> plant;
};

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

float next(float v)
{
	return std::nextafter(v, std::numeric_limits<float>::infinity());
}

const Fault kFaults[] = {
	{"volume", [](auto& c) { c.asset.volume = -1; }},
	{"quaternion", [](auto& c) { c.asset.principal[0] += 0.5; }},
	{"buildSeconds", [](auto& c) { c.asset.buildSeconds = 1; }},
	{"radius", [](auto& c) { c.asset.radius = kNan; }},
	{"unknown flags", [](auto& c) { c.asset.flags = 8; }},
	{"componentCount", [](auto& c) { c.asset.componentCount = 0; }},
	{"triangleCount", [](auto& c) { ++c.asset.triangleCount; }},
	{"asset: padding", [](auto& c) { c.asset.padding[1] = 1; }},
	{"inside out", [](auto& c) { std::swap(c.asset.boxMin[0], c.asset.boxMax[0]); }},
	{"outside the asset's box", [](auto& c) { c.asset.boxMax[1] = 0; }},
	{"outside the bounding sphere", [](auto& c) { c.asset.radius *= 0.5f; }},
	{"does not follow the level", [](auto& c) { ++c.levels[1].firstNode; }},
	{"has no nodes", [](auto& c) { c.levels[1].nodeCount = 0; }},
	{"not smaller", [](auto& c) { c.levels[1].nodeCount = c.levels[0].nodeCount; }},
	{"not a contact level", [](auto& c) { c.levels[0].flags = 0; }},
	{"above a completion", [](auto& c) { c.levels.back().flags = kClodNode; }},
	{"level 1: padding", [](auto& c) { c.levels[1].padding = 1; }},
	{"patchTolerance", [](auto& c) { c.levels[1].patchTolerance = -1; }},
	{"not all", [](auto& c) { c.levels.pop_back(); }},
	{"a maximum is not", [](auto& c) { c.levels[1].maxCover *= 2; }},
	{"level 1 is not 0", [](auto& c) { c.nodes[0].level = 1; }},
	{"flags are not", [](auto& c) { c.nodes[0].flags = 0; }},
	{"do not follow those", [](auto& c) { ++c.nodes[2].firstFace; }},
	{"impossible number", [](auto& c) { c.nodes[0].vertexCount = 0; }},
	{"node 0: padding", [](auto& c) { c.nodes[0].padding[5] = 1; }},
	{"more primary", [](auto& c) { c.nodes.back().primaryChildCount = 9; }},
	{"no primary child", [](auto& c) { c.nodes.back().primaryChildCount = 0; }},
	{"does not exist", [](auto& c) { c.children.back() = 1u << 31; }},
	{"not of a finer level", [](auto& c) { c.children.back() = std::uint32_t(c.nodes.size() - 1); }},
	{"two primary parents", [](auto& c) { c.children.back() = c.children[c.children.size() - 2]; }},
	{"shared children in a paper",
	 [](auto& c)
	 {
		 c.asset.flags = kPaperBuild;
		 --c.nodes.back().primaryChildCount;
	 }},
	{"vertex is not finite", [](auto& c) { c.hullX[0] = kNan; }},
	{"padding does not repeat", [](auto& c) { c.hullX[3] = c.hullX[0]; }},
	{"thickness is not a length", [](auto& c) { c.nodes[0].thickness = -1; }},
	{"inward", [](auto& c) { c.nodes[0].inward[0] = 3; }},
	{"meanNormal", [](auto& c) { c.nodes[0].meanNormal[0] = 3; }},
	{"coneCosine", [](auto& c) { c.nodes[0].coneCosine = 2; }},
	{"curvature", [](auto& c) { c.nodes[0].curvature = kNan; }},
	{"no mean normal", [](auto& c) { c.nodes.back().coneCosine = 0; }},
	{"certified number", [](auto& c) { c.nodes[0].protrude = kNan; }},
	{"deviation is not", [](auto& c) { c.nodes.back().deviation *= 2; }},
	{"reach is less", [](auto& c) { c.nodes.back().reach *= 0.5f; }},
	{"contactArea is not positive", [](auto& c) { c.nodes[0].contactArea = 0; }},
	{"contactArea exceeds", [](auto& c) { c.nodes.back().contactArea *= 100; }},
	{"resolution exceeds", [](auto& c) { c.nodes.back().resolution *= 100; }},
	{"featureVolume of a completion", [](auto& c) { c.nodes.back().featureVolume = 1; }},
	{"must be 0 at level 0", [](auto& c) { c.nodes[0].hausdorff = 1; }},
	{"less than that of child", [](auto& c) { c.nodes.back().surf = 0; }},
	{"outside its node", [](auto& c) { c.faces[0].vertex[0] = 60000; }},
	{"same vertex twice", [](auto& c) { c.faces[0].vertex[0] = c.faces[0].vertex[1]; }},
	{"face 0: two corners in one place",
	 [](auto& c)
	 {
		 // Not the last vertex, which the padding repeats.
		 const std::uint16_t(&v)[3] = c.faces[0].vertex;
		 const int i = v[0] + 1U == c.nodes[0].vertexCount ? 1 : 0;
		 for (auto* x : {&c.hullX, &c.hullY, &c.hullZ}) (*x)[v[i]] = (*x)[v[i + 1]];
	 }},
	{"face 0: padding", [](auto& c) { c.faces[0].padding = 1; }},
	{"face 0: thickness", [](auto& c) { c.faces[0].thickness = kNan; }},
	{"normal is not", [](auto& c) { c.faces[0].normal[0] = 2; }},
	{"below a vertex", [](auto& c) { c.faces[0].offset -= 0.1f; }},
	{"above every vertex", [](auto& c) { c.faces[0].offset += 0.1f; }},
	{"points inward", [](auto& c) { std::swap(c.faces[0].vertex[0], c.faces[0].vertex[1]); }},
	{"source belongs", [](auto& c) { c.faces[0].source = kNone; }},
	{"triangle of its own", [](auto& c) { c.faces[0].source = c.faces[1].source; }},
	{"neighbour outside", [](auto& c) { c.faces[0].neighbour[0] = std::uint32_t(c.faces.size() - 1); }},
	{"does not share", [](auto& c) { std::swap(c.faces[0].neighbour[0], c.faces[0].neighbour[1]); }},
	{"leaves the culling box", [](auto& c) { c.cullBoxes.back().half[0] *= 0.9f; }},
	{"leaves the culling box", [](auto& c) { c.cullBoxes[0].radius *= 0.5f; }},
	{"axis of the culling box", [](auto& c) { c.cullBoxes[0].axis[0][0] += 0.5f; }},
	{"axis of the culling box", [](auto& c) { c.cullBoxes[0].axis[0][0] *= 1 + 1e-6f; }},
	{"axes of the culling box",
	 [](auto& c)
	 {
		 float(&axis)[3][3] = c.cullBoxes[0].axis;
		 for (int k = 0; k < 3; ++k) axis[0][k] += 5e-7f * axis[1][k];
	 }},
	{"culling box is larger", [](auto& c) { c.cullBoxes[0].half[0] = 256; }},
	{"half extent", [](auto& c) { c.cullBoxes[0].half[1] = kNan; }},
	{"areaTolerance is off", [](auto& c) { c.asset.areaTolerance = next(c.asset.areaTolerance); }},
	{"thinnestWall is off", [](auto& c) { c.asset.thinnestWall = next(c.asset.thinnestWall); }},
	{"sphereCenter is off", [](auto& c) { c.asset.sphereCenter[1] += 1e-7f; }},
	{"level 1: patchTolerance is off", [](auto& c) { c.levels[1].patchTolerance = next(c.levels[1].patchTolerance); }},
	{"thickness is off", [](auto& c) { c.nodes[0].thickness = next(c.nodes[0].thickness); }},
	{"reach is off", [](auto& c) { c.nodes.back().reach = next(c.nodes.back().reach); }},
	{"hausdorff is off",
	 [](auto& c) { c.levels.back().maxHausdorff = c.nodes.back().hausdorff = next(c.nodes.back().hausdorff); }},
	{"contactArea is off", [](auto& c) { c.nodes[0].contactArea = next(c.nodes[0].contactArea); }},
	{"the size of its culling box is off", [](auto& c) { c.cullBoxes[0].half[1] = next(c.cullBoxes[0].half[1]); }},
	{"the size of its culling box is off", [](auto& c) { c.cullBoxes[0].radius = next(c.cullBoxes[0].radius); }},
	{"the centre of its culling box is off", [](auto& c) { c.cullBoxes[0].center[2] += 1e-7f; }},
	{"face 0: thickness is off", [](auto& c) { c.faces[0].thickness = next(c.faces[0].thickness); }},
	{"culling boxes for", [](auto& c) { c.cullBoxes.pop_back(); }},
	{"different length", [](auto& c) { c.hullZ.pop_back(); }},
};

TEST(HierarchyRules, EachFiresOnItsPlantedFault)
{
	for (const Fault& fault : kFaults)
	{
		HierarchyContent content = levels();
		fault.plant(content);
		const std::string message = refusal(encode(content));
		EXPECT_NE(message.find(fault.message), std::string::npos) << fault.message << " / got: " << message;
	}
}

struct Doubled
{
	explicit Doubled(int value) : twice(2 * value) {}
	int twice;
};
struct Halved
{
	explicit Halved(double value) : half(value / 2) {}
	double half;
};

TEST(DerivedData, EachKindIsMadeOnce)
{
	const DerivedData data;
	const Doubled& doubled = data.get<Doubled>(3);
	const Halved& halved = data.get<Halved>(3.0);
	EXPECT_EQ(doubled.twice, 6);
	EXPECT_EQ(halved.half, 1.5);
	EXPECT_EQ(&data.get<Doubled>(4), &doubled) << "of what it was made of first";
	EXPECT_EQ(&data.get<Halved>(4.0), &halved);
}
}  // namespace
}  // namespace clod::test
