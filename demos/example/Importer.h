// SPDX-License-Identifier: Zlib
// Worlds saved by btSerializer, with shapes of ours, read back: an importer of Bullet's Extras that puts a shape of the same
// file and scale where the saved world has a box under our name (btClodShape::serialize), in compounds, too.
//   clod_import saved.bullet
#pragma once
#include <BulletFileLoader/btBulletFile.h>
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <clod/bullet/btClodShape.h>

#include <map>
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

	bool convertAllObjects(bParse::btBulletFile* file) override
	{
		m_file = file;
		m_saved.clear();
		m_inPlaceOf.clear();
		const bool isRead = btBulletWorldImporter::convertAllObjects(file);
		for (int i = 0; i < file->m_rigidBodies.size(); ++i)
			if ((file->getFlags() & bParse::FD_DOUBLE_PRECISION) != 0)
				restore(*reinterpret_cast<const btRigidBodyDoubleData*>(file->m_rigidBodies[i]));
			else
				restore(*reinterpret_cast<const btRigidBodyFloatData*>(file->m_rigidBodies[i]));
		return isRead;
	}
	btRigidBody* createRigidBody(bool isDynamic, btScalar mass, const btTransform& pose, btCollisionShape* shape,
								 const char* bodyName) override
	{
		return btBulletWorldImporter::createRigidBody(isDynamic, mass, pose, inPlaceOf(shape), bodyName);
	}

private:
	// Bullet's importer makes bodies anew: as their shapes alone have them turn, at rest, solid, awake, meeting all others
	// and under the world's gravity.
	template <class Data>
	void restore(const Data& saved)
	{
		btCollisionObject** const made = m_bodyMap.find(&saved);
		btRigidBody* const body = made ? btRigidBody::upcast(*made) : nullptr;
		if (!body) return;
		const auto vector = [](const auto& stored)
		{ return btVector3(btScalar(stored.m_floats[0]), btScalar(stored.m_floats[1]), btScalar(stored.m_floats[2])); };
		body->setInvInertiaDiagLocal(vector(saved.m_invInertiaLocal));
		body->updateInertiaTensor();
		body->setLinearVelocity(vector(saved.m_linearVelocity));
		body->setAngularVelocity(vector(saved.m_angularVelocity));
		body->setDamping(btScalar(saved.m_linearDamping), btScalar(saved.m_angularDamping));
		const auto& object = saved.m_collisionObjectData;
		body->setCollisionFlags(object.m_collisionFlags);
		const int group = object.m_collisionFilterGroup, mask = object.m_collisionFilterMask;
		btBroadphaseProxy* const proxy = body->getBroadphaseHandle();
		if (group != 0 && proxy && (proxy->m_collisionFilterGroup != group || proxy->m_collisionFilterMask != mask))
		{
			proxy->m_collisionFilterGroup = group;
			proxy->m_collisionFilterMask = mask;
			m_dynamicsWorld->refreshBroadphaseProxy(body);
		}
		body->setGravity(vector(saved.m_gravity_acceleration));
		body->setRollingFriction(btScalar(object.m_rollingFriction));
		body->setAnisotropicFriction(vector(object.m_anisotropicFriction), object.m_hasAnisotropicFriction);
		body->setCcdMotionThreshold(btScalar(object.m_ccdMotionThreshold));
		body->setCcdSweptSphereRadius(btScalar(object.m_ccdSweptSphereRadius));
		body->setSleepingThresholds(btScalar(saved.m_linearSleepingThreshold), btScalar(saved.m_angularSleepingThreshold));
		body->forceActivationState(object.m_activationState1);
		body->setDeactivationTime(btScalar(object.m_deactivationTime));
	}
	// Once for all bodies of a shape. All shapes have been read when the first body is made.
	btCollisionShape* inPlaceOf(btCollisionShape* read)
	{
		if (m_saved.empty())
			for (int i = 0; i < m_file->m_collisionShapes.size(); ++i)
			{
				const void* const saved = m_file->m_collisionShapes[i];
				if (btCollisionShape** made = m_shapeMap.find(saved))
					m_saved[*made] = static_cast<const btCollisionShapeData*>(saved);
			}
		const auto saved = m_saved.find(read);
		if (saved == m_saved.end()) return read;
		const auto [place, isNew] = m_inPlaceOf.insert({read, nullptr});
		if (isNew) place->second = inPlaceOf(read, *saved->second);
		return place->second;
	}
	btCollisionShape* inPlaceOf(btCollisionShape* read, const btCollisionShapeData& saved)
	{
		if (btClodShape::isSerializedName(saved.m_name))
		{
			btClodShape* const ours = load(saved.m_name);
			if (!ours) return read;
			ours->setMargin(btScalar(reinterpret_cast<const btConvexInternalShapeData&>(saved).m_collisionMargin));
			return ours;
		}
		if (saved.m_shapeType != COMPOUND_SHAPE_PROXYTYPE) return read;
		auto& whole = *static_cast<btCompoundShape*>(read);
		const auto& children = reinterpret_cast<const btCompoundShapeData&>(saved);
		if (whole.getNumChildShapes() != children.m_numChildShapes) return read;  // there is one that Bullet does not read
		std::vector<btCollisionShape*> shapes;
		bool hasOurs = false;
		for (int i = 0; i < children.m_numChildShapes; ++i)
		{
			shapes.push_back(inPlaceOf(whole.getChildShape(i), *children.m_childShapePtr[i].m_childShape));
			hasOurs = hasOurs || shapes.back() != whole.getChildShape(i);
		}
		if (!hasOurs) return read;
		btCompoundShape* const made = createCompoundShape();
		for (int i = 0; i < children.m_numChildShapes; ++i)
			made->addChildShape(whole.getChildTransform(i), shapes[std::size_t(i)]);
		return made;
	}
	btClodShape* load(const char* name)
	{
		const auto saved = btClodShape::readSerializedName(name);
		if (!saved) return failed(std::string(name) + " is damaged");
		const auto hierarchy = clod::Hierarchy::load(saved->name);
		if (!hierarchy) return failed(hierarchy.error());
		if (hierarchy.value()->contentHash() != saved->contentHash)
			return failed(saved->name + " is not the file that was saved");
		auto shape = std::make_unique<btClodShape>(hierarchy.value());
		shape->setName(saved->name);
		shape->setLocalScaling(saved->scaling);
		if (!shape->scalingError().empty()) return failed(saved->name + ": " + shape->scalingError());
		m_allocatedCollisionShapes.push_back(shape.get());  // deleted with the importer's own
		return shape.release();
	}
	btClodShape* failed(const std::string& problem)
	{
		m_problems.push_back(problem);
		return nullptr;
	}

	const bParse::btBulletFile* m_file = nullptr;
	std::map<const btCollisionShape*, const btCollisionShapeData*> m_saved;
	std::map<const btCollisionShape*, btCollisionShape*> m_inPlaceOf;
	std::vector<std::string> m_problems;
};
