// SPDX-License-Identifier: GPL-3.0-or-later
// The README's example runs, and refuses what is not there; a saved world comes back.
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "clod/bullet/btClodShape.h"
#include "tests/bullet/PatchHierarchy.h"
#include "tests/support/Files.h"

namespace clod::test
{
namespace
{
struct Output
{
	int status = -1;
	std::string text;
};

Output run(const std::string& command)
{
	Output output;
	FILE* pipe = popen((command + " 2>&1").c_str(), "r");
	std::array<char, 256> line;
	while (pipe && std::fgets(line.data(), int(line.size()), pipe)) output.text += line.data();
	output.status = pipe ? pclose(pipe) : -1;
	return output;
}
}  // namespace

TEST(Example, TwoModelsComeToRestOnEachOther)
{
	const TemporaryFolder folder;
	const auto model = patchHierarchy(boxMesh({0.04, 0.02, 0.03}, {8, 4, 6}, 2));
	const Output output = run(CLOD_EXAMPLE " " + folder.fileOf("model.clod", model->bytes()));
	EXPECT_EQ(output.status, 0) << output.text;
	// The radius is 1, so half the height is 0.01 / 0.02693 = 0.371 of it; contacts rest 0.0005 apart.
	EXPECT_NE(output.text.find("step 480: heights  0.372  1.115"), std::string::npos) << output.text;
}

#ifdef CLOD_IMPORT
// Saved while it falls, read back by another program: it lands as a body of that shape and scale does.
TEST(Example, ASavedWorldIsReadBack)
{
	const TemporaryFolder folder;
	const auto model = patchHierarchy(boxMesh({1, 1, 1}, {2, 2, 2}, 1));
	btClodShape shape(model);
	const std::string file = folder.fileOf("model.clod", model->bytes());
	shape.setName(file);
	shape.setLocalScaling(btVector3(1, 2, 1));
	btBoxShape floor(btVector3(5, 1, 5));
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btSequentialImpulseConstraintSolver solver;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
	world.setGravity(btVector3(0, btScalar(-9.81), 0));
	btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(1, 1, 1)));
	btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floor));
	body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.2), 0)));
	ground.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
	world.addRigidBody(&body);
	world.addRigidBody(&ground);
	// One that floats, and one that meets nothing of the floor's group.
	btRigidBody floats(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(1, 1, 1)));
	btRigidBody passes(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(1, 1, 1)));
	floats.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 5, 0)));
	passes.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(3, 3, 0)));
	world.addRigidBody(&floats);
	floats.setGravity(btVector3(0, 0, 0));
	world.addRigidBody(&passes, btBroadphaseProxy::DebrisFilter, btBroadphaseProxy::DebrisFilter);
	btDefaultSerializer serializer;
	world.serialize(&serializer);
	world.removeRigidBody(&body);
	world.removeRigidBody(&ground);
	world.removeRigidBody(&floats);
	world.removeRigidBody(&passes);
	std::vector<std::byte> bytes(std::size_t(serializer.getCurrentBufferSize()));
	std::memcpy(bytes.data(), serializer.getBufferPointer(), bytes.size());
	const std::string saved = folder.fileOf("saved.bullet", bytes);
	const Output output = run(CLOD_IMPORT " " + saved);
	EXPECT_EQ(output.status, 0) << output.text;
	EXPECT_NE(output.text.find("at height 1.000"), std::string::npos) << output.text;
	EXPECT_NE(output.text.find("at height 5.0000"), std::string::npos) << output.text;
	EXPECT_NE(output.text.find("at height -1.925"), std::string::npos) << output.text;  // 3 less g (1 + 1/240) / 2
	// Another file under the name is told of.
	folder.fileOf("model.clod", patchHierarchy(boxMesh({1, 1, 1}, {3, 2, 2}, 1))->bytes());
	const Output other = run(CLOD_IMPORT " " + saved);
	EXPECT_NE(other.status, 0);
	EXPECT_NE(other.text.find("model.clod is not the file that was saved"), std::string::npos) << other.text;
}
#endif

TEST(Example, AMissingFileIsAnError)
{
	const Output output = run(CLOD_EXAMPLE " /nonexistent/model.clod");
	EXPECT_NE(output.status, 0);
	EXPECT_NE(output.text.find("/nonexistent/model.clod"), std::string::npos) << output.text;
}
}  // namespace clod::test
