// SPDX-License-Identifier: GPL-3.0-or-later
// Judgements of the checker on shapes where the nearby wrong answer is easy to give: distances to slivers, inside or
// outside next to an acute edge, and the contact area of a surface that leaves the cap and comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "builder/Lod.h"
#include "builder/check/LevelSolid.h"
#include "tests/support/Meshes.h"

namespace clod::check
{
double outsideBox(const OrientedBox& box, const Vec3& p);  // Culling.cpp
}

namespace clod::test
{
namespace
{
HierarchyContent contentOf(const builder::Mesh& mesh)
{
	builder::BuildConfig config;
	config.threads = 1;
	return builder::buildHierarchy(mesh, config, [](const char*, double) { return true; });
}

std::shared_ptr<const Hierarchy> loaded(const HierarchyContent& content)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy) throw std::runtime_error(hierarchy.error());
	return hierarchy.value();
}

// A wedge of 0.1 at its edge, along z.
builder::Mesh wedge()
{
	return {{{0, 0, 0}, {2, 0, 0}, {2, 0.1875, 0}, {0, 0, 1}, {2, 0, 1}, {2, 0.1875, 1}},
			{{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}}};
}

bool isBehind(const check::Triangle& t, const Vec3& p)
{
	return dot(cross(t[1] - t[0], t[2] - t[0]), p - t[0]) <= 0;
}

// A box with a flat cavity: a hub with four arms; each turns round at 0.998 and comes back as a finger that ends before
// the hub. The box makes the radius 4, and so the cap of a contact area, a quarter of it, a disc of 1 round the hub's
// floor: the turn lies within it and outside of the polygon of 16 sides and the same area, whose sides are 0.994 away.
builder::Mesh hollowHubWithFingers()
{
	constexpr int kSectors = 32;
	const double hub = 0.3, tip = 0.4, turn = 0.998, outer = 1.2;
	builder::Mesh mesh = boxMesh({2.8125, 2.8125, 0.421875}, 1);
	std::map<std::array<double, 3>, std::uint32_t> number;
	const auto corner = [&](int sector, double r, double z)
	{
		const auto [entry, isNew] =
			number.emplace(std::array<double, 3>{double(sector % kSectors), r, z}, std::uint32_t(mesh.vertices.size()));
		const double angle = 2 * std::acos(-1.0) * sector / kSectors;
		if (isNew) mesh.vertices.push_back({roundToFloat(r * std::cos(angle)), roundToFloat(r * std::sin(angle)), z});
		return entry->second;
	};
	std::map<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>> sides;  // of the top, with what lies below
	const auto addCell = [&](const std::vector<std::pair<int, double>>& outline)
	{
		std::vector<std::uint32_t> top, bottom;
		for (const auto& [sector, r] : outline)
		{
			top.push_back(corner(sector, r, 0.125));
			bottom.push_back(corner(sector, r, -0.125));
		}
		for (std::size_t i = 0, n = top.size(); i < n; ++i)
		{
			if (i >= 2) mesh.triangles.push_back({top[0], top[i], top[i - 1]});
			if (i >= 2) mesh.triangles.push_back({bottom[0], bottom[i - 1], bottom[i]});
			sides[{top[i], top[(i + 1) % n]}] = {bottom[i], bottom[(i + 1) % n]};
		}
	};
	std::vector<std::pair<int, double>> round;
	for (int i = 0; i < kSectors; i += 8) round.insert(round.end(), {{i, hub}, {i + 1, hub}});
	addCell(round);
	const auto addRingCell = [&](int i, double from, double to) {
		addCell({{i, from}, {i, to}, {i + 1, to}, {i + 1, from}});
	};
	for (int i = 0; i < kSectors; i += 8)
	{
		addRingCell(i, hub, turn);
		for (int k = 0; k < 3; ++k) addRingCell(i + k, turn, outer);
		addRingCell(i + 2, tip, turn);
	}
	for (const auto& [edge, below] : sides)
	{
		if (sides.count({edge[1], edge[0]}) > 0) continue;
		mesh.triangles.push_back({edge[0], edge[1], below[0]});
		mesh.triangles.push_back({edge[1], below[1], below[0]});
	}
	return mesh;
}

check::Invariant contactAreas(const std::vector<check::Invariant>& all)
{
	for (const check::Invariant& i : all)
		if (i.name == "contact-areas") return i;
	throw std::runtime_error("contact-areas was not checked");
}
}  // namespace

// Slivers turned aslant, points over them, and beyond a side by as much.
TEST(CheckGeometry, DistancesToSliversAreExact)
{
	const auto turned = [](const Vec3& v)
	{
		const Vec3 once{0.8 * v.x - 0.6 * v.y, 0.6 * v.x + 0.8 * v.y, v.z};
		return Vec3{once.x, 0.28 * once.y - 0.96 * once.z, 0.96 * once.y + 0.28 * once.z};
	};
	using builder::Feature;
	for (double width = 1e-2; width > 1e-8; width *= 0.1)
		for (int i = 1; i < 10; ++i)
			for (const double away : {1e-7, 1e-5, 1e-3})
			{
				const double along = 0.1 * i, up = 0.4 * width * std::min(along / 0.3, (1 - along) / 0.7);
				const check::Triangle t = {turned({0, 0, 0}), turned({1, 0, 0}), turned({0.3, width, 0})};
				const Vec3 over = turned({along, up, away}), beside = turned({along, -away, 0});
				EXPECT_NEAR(check::distance(t, over), away, 1e-14) << width << " " << along;
				EXPECT_NEAR(check::distance(t, beside), away, 1e-14) << width << " " << along;
				EXPECT_EQ(builder::closestPoint(over, t[0], t[1], t[2]).feature, Feature::face) << width << " " << along;
				EXPECT_EQ(builder::closestPoint(beside, t[0], t[1], t[2]).feature, Feature::edgeAB) << width << " " << along;
			}
}

TEST(CheckCulling, ABoxEndsAlongAllItsAxes)
{
	OrientedBox box{};
	box.radius = 10;
	for (int i = 0; i < 3; ++i)
	{
		box.axis[i][i] = 1;
		box.half[i] = 1;
	}
	for (int i = 0; i < 3; ++i)
		for (const double side : {1.0, -1.0})
		{
			Vec3 p;
			p[i] = 1.5 * side;
			EXPECT_DOUBLE_EQ(check::outsideBox(box, p), 0.5) << i;
			p[i] = 0.5 * side;
			EXPECT_LT(check::outsideBox(box, p), 0) << i;
		}
}

TEST(CheckSolid, TellsTheSideNextToAnAcuteEdge)
{
	const auto hierarchy = loaded(contentOf(wedge()));
	const check::Options options;
	const check::Subject subject(*hierarchy, options);
	const check::LevelSolid solid(subject, hierarchy->levels()[0]);
	const std::vector<check::Triangle>& faces = solid.surface().triangles();
	ASSERT_EQ(faces.size(), 8u);
	const double* const shift = hierarchy->asset().meshFromBody;
	std::mt19937_64 random(3);
	std::uniform_real_distribution<double> around(-0.5, 0.5), along(0.1, 0.9);
	int wrongByOneFace = 0, inside = 0;
	for (int i = 0; i < 2000; ++i)
	{
		const Vec3 p = Vec3{around(random), around(random), along(random)} - Vec3{shift[0], shift[1], shift[2]};
		bool isInside = true;  // the wedge is convex
		for (const check::Triangle& t : faces) isInside = isInside && isBehind(t, p);
		ASSERT_EQ(solid.holds(p), isInside) << i;
		inside += isInside ? 1 : 0;
		wrongByOneFace += isBehind(faces[solid.surface().nearest(p).triangle], p) != isInside ? 1 : 0;
	}
	EXPECT_GT(inside, 20);
	EXPECT_GT(wrongByOneFace, 100);  // the side of the nearest face alone says nothing there
}

TEST(CheckContactArea, SurfacesThatLeaveTheCapAndComeBackAreAccepted)
{
	HierarchyContent content = contentOf(hollowHubWithFingers());
	const check::Options options;
	const auto judged = [&]
	{
		const auto hierarchy = loaded(content);
		return contactAreas(checkLocalNumbers(check::Subject(*hierarchy, options)));
	};
	const check::Invariant sound = judged();
	EXPECT_EQ(sound.violations, 0u) << sound.firstViolation;
	// Each node by itself, with what follows from it above: load() refuses a parent whose area exceeds a child's.
	const HierarchyContent right = content;
	std::uint64_t found = 0;
	for (std::size_t wrong = 0; wrong < right.nodes.size(); ++wrong)
	{
		content.nodes[wrong].contactArea *= 0.5f;
		for (Node& n : content.nodes)
			for (std::uint32_t k = n.firstChild; k < n.firstChild + n.childCount; ++k)
				n.contactArea = std::min(n.contactArea, content.nodes[content.children[k]].contactArea);
		found += judged().violations > 0 ? 1 : 0;
		content.nodes = right.nodes;
	}
	EXPECT_GT(2 * found, sound.checked);
}
}  // namespace clod::test
