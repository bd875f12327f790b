// SPDX-License-Identifier: GPL-3.0-or-later
// One trajectory, whichever instructions the machine has and whoever compiled it (scripts/same-bits compares builds).
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "clod/collide/InstructionSets.h"
#include "tests/bullet/BulletWorld.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/support/ChildProgram.h"

namespace clod::test
{
namespace
{
constexpr int kSteps = 180;

void mix(std::uint64_t& hash, const btVector3& v)
{
	for (int i = 0; i < 3; ++i)
	{
		std::uint64_t bits = 0;
		std::memcpy(&bits, &v.m_floats[i], sizeof v.m_floats[i]);
		hash = (hash ^ bits) * 0x100000001B3u;
	}
}

// An L, a box and a ball fall on each other on a sheet that is not convex.
std::uint64_t trajectory()
{
	BulletWorld scene;
	const PatchedMesh sheet = boxMesh({8, 0.5, 8}, {8, 1, 8}, 2), box = boxMesh({1, 0.5, 0.7}, {4, 2, 3}, 2);
	scene.addBody(scene.addShape(patchHierarchy(merged(sheet, boxMesh({2, 0.3, 2}, {4, 1, 4}, 1), {0.4, 0.5, 0.2}))), 0,
				  {0, -0.25, 0});
	const auto angle = patchHierarchy(merged(box, boxMesh({0.4, 0.4, 0.4}, {2, 2, 2}, 1), {0.8, 0.3, 0.1}));
	scene.addBody(scene.addShape(angle), 1, {0.3, 1.2, 0.1}, btQuaternion(btScalar(0.3), btScalar(0.2), btScalar(0.1)));
	scene.addBody(scene.addShape(patchHierarchy(singleTriangles(ballMesh(0.5, 1)))), 1, {0.6, 2.2, 0.3});
	scene.addBody(scene.addShape(patchHierarchy(box)), 0.5, {-0.2, 3.0, 0.2}, btQuaternion(0, btScalar(0.7), btScalar(0.4)));
	std::uint64_t hash = 0;
	int contacts = 0;
	for (int i = 0; i < kSteps; ++i)
	{
		scene.step();
		contacts += scene.contacts();
		for (const auto& body : scene.bodies)
		{
			for (int r = 0; r < 3; ++r) mix(hash, body->getWorldTransform().getBasis()[r]);
			mix(hash, body->getWorldTransform().getOrigin());
			mix(hash, body->getLinearVelocity());
		}
	}
	EXPECT_GT(contacts, 2 * kSteps);  // they did meet
	return hash;
}
std::string described()
{
	char text[64];
	std::snprintf(text, sizeof text, "trajectory_hash %016llx", static_cast<unsigned long long>(trajectory()));
	return text;
}
constexpr const char* kWithout = "without AVX2";
}  // namespace

TEST(Trajectory, IsPrinted)
{
	std::printf("%s\n%s\n", described().c_str(), hasWideInstructions() ? "with AVX2" : kWithout);
}

TEST(Trajectory, IsTheSameWithoutAvx2)
{
	if (!hasWideInstructions()) GTEST_SKIP() << "no AVX2 on this machine";
	const std::string output = testing::TempDir() + "/clod-trajectory-" + std::to_string(getpid());
	char self[4096]{};
	ASSERT_GT(readlink("/proc/self/exe", self, sizeof self - 1), 0);
	setenv("CLOD_NO_AVX2", "1", 1);
	const pid_t child = startProgram({self, "--gtest_filter=Trajectory.IsPrinted"}, output, output + ".err");
	unsetenv("CLOD_NO_AVX2");
	ASSERT_EQ(waitForProgram(child), 0);
	std::ifstream file(output);
	const std::string printed((std::istreambuf_iterator<char>(file)), {});
	std::remove(output.c_str()), std::remove((output + ".err").c_str());
	EXPECT_NE(printed.find(described()), std::string::npos) << described() << "\n" << printed;
	EXPECT_NE(printed.find(kWithout), std::string::npos) << printed;
}
}  // namespace clod::test
