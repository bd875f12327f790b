// SPDX-License-Identifier: GPL-3.0-or-later
// Coarse levels of a file alone: the same records and answers as of the whole, and what they cannot tell is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "clod/hierarchy/PackedFile.h"
#include "clod/distance/SignedGap.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/ScaledHierarchy.h"
#include "tests/query/Bodies.h"
#include "tests/support/Files.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
namespace
{
const Hierarchy& whole()
{
	return *body("torus", 900).hierarchy;
}

// Of a file as it is, and of a packed one.
class CoarseLevels : public testing::TestWithParam<bool>
{
protected:
	Result<std::shared_ptr<const Hierarchy>> load(std::uint32_t finest) { return Hierarchy::load(m_file, finest); }
	// As a file would be that has these bytes.
	std::string refusal(const std::vector<std::byte>& bytes, std::uint32_t finest)
	{
		const auto result = Hierarchy::load(m_folder.fileOf("other.clod", bytes), finest);
		return result ? "" : result.error();
	}

	static std::vector<std::byte> stored(const std::vector<std::byte>& block) { return GetParam() ? pack(block) : block; }

	TemporaryFolder m_folder;
	std::string m_file = m_folder.fileOf("torus.clod", stored(whole().bytes()));
};
INSTANTIATE_TEST_SUITE_P(Stored, CoarseLevels, testing::Bool(),
						 [](const auto& stored) { return std::string(stored.param ? "packed" : "asItIs"); });

template <class T>
bool sameBytes(const T& l, const T& r)
{
	return std::memcmp(&l, &r, sizeof(T)) == 0;
}

TEST_P(CoarseLevels, AreTheRecordsOfTheWhole)
{
	ASSERT_GE(whole().coarsestClodLevel(), 2u);
	EXPECT_EQ(load(0).value()->bytes(), whole().bytes());
	std::size_t before = whole().bytes().size();
	for (std::uint32_t finest = 1; finest <= whole().coarsestClodLevel(); ++finest)
	{
		const auto result = load(finest);
		ASSERT_TRUE(result) << result.error();
		const Hierarchy& coarse = *result.value();
		EXPECT_TRUE(coarse.isCoarse());
		EXPECT_EQ(coarse.finestLevel(), finest);
		EXPECT_LT(coarse.bytes().size(), before);
		before = coarse.bytes().size();
		ASSERT_EQ(coarse.levels().size, whole().levels().size - finest);
		EXPECT_EQ(coarse.coarsestClodLevel(), whole().coarsestClodLevel() - finest);
		EXPECT_EQ(coarse.asset().radius, whole().asset().radius);
		EXPECT_EQ(coarse.asset().volume, whole().asset().volume);
		const std::uint32_t first = whole().levels()[finest].firstNode;
		ASSERT_EQ(coarse.nodes().size, whole().nodes().size - first);
		for (std::uint32_t i = 0; i < coarse.nodes().size; ++i)
		{
			const Node &node = coarse.node(i), &same = whole().node(i + first);
			EXPECT_TRUE(sameBytes(coarse.cullBox(i), whole().cullBox(i + first)));
			EXPECT_EQ(node.cover, same.cover);
			EXPECT_EQ(node.featureVolume, same.featureVolume);
			ASSERT_EQ(node.vertexCount, same.vertexCount);
			for (std::uint32_t v = 0; v < node.vertexCount; ++v)
				EXPECT_EQ(coarse.hull(node).vertex(v), whole().hull(same).vertex(v));
			EXPECT_EQ(node.childCount, node.level == 0 ? 0 : same.childCount);
			for (std::uint32_t k = 0; k < node.childCount; ++k)
				EXPECT_EQ(coarse.children(node)[k] + first, whole().children(same)[k]);
		}
	}
}

TEST_P(CoarseLevels, AreRefusedWhereTheFileHasNoneSuchOrIsDamaged)
{
	const std::uint32_t none = whole().coarsestClodLevel() + 1;
	EXPECT_NE(load(none).error().find("level " + std::to_string(none) + " is asked for"), std::string::npos) << load(none).error();
	EXPECT_FALSE(load(kNone));
	EXPECT_NE(Hierarchy::load(m_file + ".none", 1).error().find("no such file"), std::string::npos);
	const std::vector<std::byte> bytes = stored(whole().bytes());
	for (std::size_t i = 0; i < bytes.size(); i += 97)
	{
		std::vector<std::byte> damaged = bytes;
		damaged[i] ^= std::byte(4);
		ASSERT_NE(refusal(damaged, 1), "") << i;  // of fine levels, too: their bytes are hashed
	}
	for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 50)
		ASSERT_NE(refusal({bytes.begin(), bytes.begin() + std::ptrdiff_t(size)}, 1), "") << size;
}

// What a program finds in sections whose hashes are right.
TEST_P(CoarseLevels, AreHeldToTheRulesOfAWhole)
{
	const auto refusalOf = [&](const std::function<void(HierarchyContent&)>& spoil)
	{
		HierarchyContent content = contentOf(whole());
		spoil(content);
		return refusal(stored(encode(content)), 1);
	};
	EXPECT_EQ(refusalOf([](HierarchyContent&) {}), "");
	const std::uint32_t first = whole().levels()[1].firstNode;
	EXPECT_NE(refusalOf([&](HierarchyContent& c) { c.nodes[first].cover = -1; }), "");
	EXPECT_NE(refusalOf([&](HierarchyContent& c) { c.nodes[first].firstVertex = kNone; }), "");
	EXPECT_NE(refusalOf([&](HierarchyContent& c) { c.nodes[whole().levels()[2].firstNode].firstChild = kNone; }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.levels[1].firstNode = kNone; }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.levels[1].firstFace = kNone; }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.children.back() = kNone; }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.hullY.pop_back(); }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.cullBoxes.pop_back(); }), "");
	EXPECT_NE(refusalOf([](HierarchyContent& c) { c.faces.back().neighbour[0] = 0; }), "");
}

// Two toruses, one lying a little into the other.
ContactResult contactsOf(const Hierarchy& hierarchy, const Metric& metric)
{
	PairCache cache;
	ContactResult result;
	ContactSettings settings;
	settings.metric = metric;
	settings.tolerance = 0.02 * double(hierarchy.asset().radius);
	Transform aFromB;
	aFromB.translation = {0.3 * double(hierarchy.asset().radius), 0.1 * double(hierarchy.asset().radius),
						  0.35 * double(hierarchy.asset().radius)};
	contacts(hierarchy, hierarchy, aFromB, settings, cache, result);
	return result;
}

TEST_P(CoarseLevels, AnswerAsTheWholeWhereTheMetricAsksForNoFiner)
{
	const auto coarse = load(1).value();
	const std::uint32_t first = whole().levels()[1].firstNode;
	Metric metric;
	metric.weightedDeviation = 10 * double(whole().asset().radius);
	const ContactResult ofWhole = contactsOf(whole(), metric), ofCoarse = contactsOf(*coarse, metric);
	ASSERT_GT(ofWhole.contacts.size(), 0u);
	ASSERT_EQ(ofWhole.contacts.size(), ofCoarse.contacts.size());
	for (std::size_t i = 0; i < ofWhole.contacts.size(); ++i)
	{
		EXPECT_EQ(ofWhole.contacts[i].nodeA, ofCoarse.contacts[i].nodeA + first);
		EXPECT_EQ(ofWhole.contacts[i].nodeB, ofCoarse.contacts[i].nodeB + first);
		EXPECT_EQ(ofWhole.contacts[i].lower, ofCoarse.contacts[i].lower);
		EXPECT_EQ(ofWhole.contacts[i].pointOnA, ofCoarse.contacts[i].pointOnA);
	}
	EXPECT_EQ(ofCoarse.excess, 0);
	EXPECT_EQ(levelsError(*coarse, coarse.get(), metric), "");
	EXPECT_EQ(levelsError(whole(), &whole(), metric), "");
}

TEST_P(CoarseLevels, TellWhereTheMetricAsksForFiner)
{
	const auto coarse = load(1).value();
	Metric exact, tight, deviation;
	exact.exact = true;
	tight.maxError = 1e-4 * double(whole().asset().radius);
	deviation.weightedDeviation = 1e-6 * double(whole().asset().radius);
	for (const Metric& metric : {exact, tight, deviation})
	{
		EXPECT_EQ(levelsError(whole(), &whole(), metric), "");
		EXPECT_EQ(contactsOf(whole(), metric).excess, 0);
		EXPECT_GT(contactsOf(*coarse, metric).excess, 1);
		EXPECT_EQ(contactsOf(*coarse, metric).stats.finestLevel, 0u);
	}
	for (const Metric& metric : {exact, tight})
	{
		EXPECT_NE(levelsError(*coarse, coarse.get(), metric).find("levels from 1 on were loaded"), std::string::npos);
		EXPECT_NE(levelsError(*coarse, nullptr, metric), "");
		EXPECT_NE(levelsError(whole(), coarse.get(), metric), "");
		EXPECT_EQ(levelsError(whole(), nullptr, metric), "");
	}
	tight.maxError = double(whole().asset().radius);
	EXPECT_EQ(levelsError(*coarse, coarse.get(), tight), "");
	// It takes what is missing and what is too much, whichever is more, of both bodies.
	const double cover = 2 * double(coarse->levels()[0].maxCover), protrude = 2 * double(coarse->levels()[0].maxProtrude);
	ASSERT_GT(std::abs(cover - protrude), 1e-3 * cover);
	for (const double share : {0.01, 0.5, 0.99})
	{
		tight.maxError = share * cover + (1 - share) * protrude;
		EXPECT_NE(levelsError(*coarse, coarse.get(), tight), "") << share;
	}
}

// Of the gap nothing is claimed.
TEST_P(CoarseLevels, ProveNoGap)
{
	const auto coarse = load(1).value();
	GapSettings settings;
	settings.tolerance = 0.1 * double(whole().asset().radius);
	settings.metric.weightedDeviation = double(whole().asset().radius);
	Transform aFromB;
	aFromB.translation = {0, 0, 0.3 * double(whole().asset().radius)};
	GapCache cache, other;
	GapResult result;
	signedGap(*coarse, *coarse, aFromB, settings, cache, result);
	EXPECT_TRUE(std::isinf(result.errorBound));
	signedGap(whole(), whole(), aFromB, settings, other, result);
	EXPECT_TRUE(std::isfinite(result.errorBound));
}

TEST_P(CoarseLevels, AreScaledAsWhatTheyAre)
{
	const auto coarse = load(1).value();
	for (const Vec3& scale : {Vec3{2, 2, 2}, Vec3{1, 1.5, 0.7}})
	{
		const auto result = scaledHierarchy(*coarse, scale);
		ASSERT_TRUE(result) << result.error();
		EXPECT_EQ(result.value()->finestLevel(), 1u);
		EXPECT_EQ(validate(*result.value()), "");
		const auto ofWhole = scaledHierarchy(whole(), scale);
		EXPECT_GE(result.value()->asset().radius, ofWhole.value()->asset().radius * 0.999999F);
		for (std::uint32_t i = 0; i < result.value()->nodes().size; ++i)
			EXPECT_GE(result.value()->node(i).cover, 0.999F * ofWhole.value()->node(i + whole().levels()[1].firstNode).cover);
	}
}
}  // namespace
}  // namespace clod::test
