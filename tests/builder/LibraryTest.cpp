// SPDX-License-Identifier: GPL-3.0-or-later
// The builder as a library: the whole asset of solids with closed forms, progress, cancellation, and nothing thrown.
#include "clod/builder/Builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tests/support/Meshes.h"

namespace clod::builder
{
namespace
{
const Vec3 kHalf{1, 2, 3}, kPlace{10, -4, 7};

TriangleMesh movedBox()
{
	const Mesh box = test::boxMesh(kHalf, 2);
	TriangleMesh mesh{box.vertices, box.triangles};
	for (Vec3& vertex : mesh.vertices) vertex += kPlace;
	return mesh;
}

TEST(BuilderLibrary, FillsTheWholeAsset)
{
	const Outcome built = build(movedBox());
	ASSERT_EQ(built.status, Status::built) << built.message;
	const Asset& asset = built.hierarchy->asset();
	EXPECT_NEAR(asset.volume, 48, 1e-9);
	const double place[3] = {kPlace.x, kPlace.y, kPlace.z};
	const double squares[3] = {1, 4, 9};  // of kHalf
	for (int i = 0; i < 3; ++i)
	{
		EXPECT_NEAR(asset.meshFromBody[i], place[i], 1e-9);
		EXPECT_NEAR(asset.inertia[i], 48.0 / 3 * (squares[(i + 1) % 3] + squares[(i + 2) % 3]), 1e-9);
		EXPECT_NEAR(asset.inertia[3 + i], 0, 1e-9);
	}
	EXPECT_NEAR(double(asset.radius), std::sqrt(14.0), 1e-5);
	EXPECT_EQ(asset.componentCount, 1u);
	EXPECT_EQ(asset.triangleCount, movedBox().triangles.size());
	EXPECT_TRUE(built.changes.empty());
	EXPECT_EQ(built.moved, 0);
}

TEST(BuilderLibrary, FileAndMeshGiveTheSameBytes)
{
	const std::string path = (std::filesystem::temp_directory_path() / "clod-library-test.obj").string();
	{
		std::ofstream file(path);
		const TriangleMesh mesh = movedBox();
		for (const Vec3& v : mesh.vertices) file << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
		for (const auto& t : mesh.triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
	}
	const Outcome ofFile = buildFile(path), ofMesh = build(movedBox());
	ASSERT_EQ(ofFile.status, Status::built) << ofFile.message;
	ASSERT_EQ(ofMesh.status, Status::built) << ofMesh.message;
	EXPECT_EQ(ofFile.hierarchy->bytes(), ofMesh.hierarchy->bytes());
	FileOptions options;
	options.unit = "cm";
	const Outcome smaller = buildFile(path, options);
	ASSERT_EQ(smaller.status, Status::built) << smaller.message;
	EXPECT_NEAR(smaller.hierarchy->asset().volume, 48e-6, 1e-10);
	EXPECT_NEAR(smaller.hierarchy->asset().meshFromBody[0], 0.1, 1e-9);
	for (const char* wrong : {"furlong", "Cm"})
	{
		options.unit = wrong;
		EXPECT_EQ(buildFile(path, options).status, Status::refused);
	}
	std::filesystem::remove(path);
	EXPECT_EQ(buildFile(path).status, Status::refused);
}

TEST(BuilderLibrary, TellsItsProgressAndCanBeCancelledAtEveryCall)
{
	const auto cancelledAt = [](unsigned threads, int call, int& calls)
	{
		Options options;
		options.threads = threads;
		calls = 0;
		return build(movedBox(), options,
					 [&](const char* phase, double fraction)
					 {
						 EXPECT_TRUE(phase[0] != 0 && fraction >= 0 && fraction <= 1) << phase << ' ' << fraction;
						 return calls++ != call;
					 });
	};
	for (const unsigned threads : {1u, 3u})
	{
		int all = 0;
		ASSERT_EQ(cancelledAt(threads, -1, all).status, Status::built);
		ASSERT_GT(all, 3);
		const int fewest = threads == 1 ? all : 3;  // on several threads the number of calls varies
		for (int call = 0; call < fewest; ++call)
		{
			int calls = 0;
			const Outcome cancelled = cancelledAt(threads, call, calls);
			EXPECT_EQ(cancelled.status, Status::cancelled) << call << " of " << all << ": " << cancelled.message;
			EXPECT_EQ(calls, call + 1) << "called again after it said no";
			EXPECT_EQ(cancelled.hierarchy, nullptr);
		}
	}
}

// Mending and wrapping, too, are told of and end when the callback says so.
TEST(BuilderLibrary, CanBeCancelledWhileItMends)
{
	TriangleMesh open = movedBox();
	open.triangles.pop_back();
	for (const bool wraps : {false, true})
	{
		Options options;
		options.threads = 1;
		options.repair = !wraps;
		options.wrap = wraps ? 0.5 : 0;
		std::vector<std::string> phases;
		const Outcome built = build(open, options,
									[&](const char* phase, double fraction)
									{
										EXPECT_TRUE(fraction >= 0 && fraction <= 1) << phase << ' ' << fraction;
										phases.push_back(phase);
										return true;
									});
		ASSERT_EQ(built.status, Status::built) << built.message;
		const std::string mending = wraps ? "wrap" : "repair";
		ASSERT_GT(std::count(phases.begin(), phases.end(), mending), 1);
		for (std::size_t call = 0; call < phases.size() && phases[call] != "decompose"; ++call)
		{
			std::size_t calls = 0;
			EXPECT_EQ(build(open, options, [&](const char*, double) { return calls++ != call; }).status,
					  Status::cancelled);
			EXPECT_EQ(calls, call + 1);
		}
	}
}

TEST(BuilderLibrary, RefusesOptionsThatMakeNoSense)
{
	const auto messageOf = [](const auto& change)
	{
		Options options;
		change(options);
		const Outcome refused = build(movedBox(), options);
		EXPECT_EQ(refused.status, Status::refused);
		return refused.message;
	};
	EXPECT_EQ(messageOf([](Options& o) { o.threads = 1u << 27; }), "134217728 threads, at most 1024");
	EXPECT_EQ(messageOf([](Options& o) { o.wrap = -1; }), "wrap is not a length");
	EXPECT_EQ(messageOf([](Options& o) { o.wrap = std::nan(""); }), "wrap is not a length");
	EXPECT_EQ(messageOf([](Options& o) { o.repair = true, o.maxMove = -1; }), "maxMove is not a length");
	EXPECT_EQ(messageOf([](Options& o) { o.repair = true, o.wrap = 1; }), "a wrap stands for a repair: one of the two");
	EXPECT_EQ(messageOf([](Options& o) { o.maxMove = 1; }), "maxMove is of a repair");
}

TEST(BuilderLibrary, ThrowsNothing)
{
	for (const unsigned threads : {1u, 3u})
		for (int last = 1; last <= 4; ++last)
		{
			Options options;
			options.threads = threads;
			int calls = 0;
			const Outcome failed = build(movedBox(), options,
										 [&](const char*, double)
										 {
											 if (++calls == last) throw std::runtime_error("of the callback");
											 return true;
										 });
			EXPECT_EQ(failed.status, Status::failed) << "call " << last;
			EXPECT_EQ(failed.message, "of the callback");
			calls = 0;
			const auto throwsNumber = [&](const char*, double) { return ++calls == last ? throw last : true; };
			EXPECT_EQ(build(movedBox(), options, throwsNumber).status, Status::failed) << "call " << last;
		}
	TriangleMesh open = movedBox();
	open.triangles.pop_back();
	const Outcome refused = build(open);
	EXPECT_EQ(refused.status, Status::refused);
	EXPECT_NE(refused.message.find("open boundary"), std::string::npos) << refused.message;
	TriangleMesh wild = movedBox();
	wild.triangles[3][1] = 4000000000u;
	EXPECT_EQ(build(wild).status, Status::refused);
	wild = movedBox();
	wild.vertices[3].y = std::nan("");
	EXPECT_EQ(build(wild).status, Status::refused);
	EXPECT_EQ(build({}).status, Status::refused);
}

TEST(BuilderLibrary, MendsWhereAsked)
{
	TriangleMesh open = movedBox();
	open.triangles.pop_back();
	Options options;
	options.repair = true;
	const Outcome mended = build(open, options);
	ASSERT_EQ(mended.status, Status::built) << mended.message;
	EXPECT_FALSE(mended.changes.empty());
	EXPECT_NEAR(mended.hierarchy->asset().volume, 48, 1e-6);
}
}  // namespace
}  // namespace clod::builder
