// SPDX-License-Identifier: Zlib
// Worlds saved by btSerializer, with shapes of ours, read back: an importer of Bullet's Extras that puts a shape of the same
// file and scale where the saved world has a box under our name (btClodShape::serialize). Children of compounds stay boxes.
//   clod_import saved.bullet
#pragma once
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <clod/bullet/btClodShape.h>

#include <memory>
#include <string>
#include <vector>

class ClodImporter : public btBulletWorldImporter
{
public:
	explicit ClodImporter(btDynamicsWorld* world) : btBulletWorldImporter(world) {}
	~ClodImporter() override { deleteAllData(); }
	// What was not found as it was saved; its bodies are boxes.
	const std::vector<std::string>& problems() const { return m_problems; }

	btRigidBody* createRigidBody(bool isDynamic, btScalar mass, const btTransform& pose, btCollisionShape* shape,
								 const char* bodyName) override
	{
		const auto saved = btClodShape::readSerializedName(getNameForPointer(shape));
		if (btClodShape* ours = saved ? load(*saved) : nullptr) shape = ours;
		return btBulletWorldImporter::createRigidBody(isDynamic, mass, pose, shape, bodyName);
	}

private:
	btClodShape* load(const btClodShape::Serialized& saved)
	{
		const auto hierarchy = clod::Hierarchy::load(saved.name);
		if (!hierarchy || hierarchy.value()->contentHash() != saved.contentHash)
		{
			m_problems.push_back(hierarchy ? saved.name + " is not the file that was saved" : hierarchy.error());
			return nullptr;
		}
		auto shape = std::make_unique<btClodShape>(hierarchy.value());
		shape->setName(saved.name);
		shape->setLocalScaling(saved.scaling);
		m_allocatedCollisionShapes.push_back(shape.get());  // deleted with the importer's own
		return shape.release();
	}

	std::vector<std::string> m_problems;
};
