// SPDX-License-Identifier: Zlib
// Worlds saved by btSerializer, with shapes of ours, read back: an importer of Bullet's Extras that puts a shape of the
// same file and scale where the saved world has a box under our name (btClodShape::serialize), in compounds, too.
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
		if ((file->getFlags() & bParse::FD_DOUBLE_PRECISION) != 0)
			restoreAll<btRigidBodyDoubleData, btCollisionObjectDoubleData>(*file);
		else
			restoreAll<btRigidBodyFloatData, btCollisionObjectFloatData>(*file);
		return isRead;
	}
	btRigidBody* createRigidBody(bool isDynamic, btScalar mass, const btTransform& pose, btCollisionShape* shape,
								 const char* bodyName) override
	{
		return btBulletWorldImporter::createRigidBody(isDynamic, mass, pose, inPlaceOf(shape), bodyName);
	}

private:
	// Bullet's importer makes bodies and objects anew: as their shapes alone have them turn, at rest, without a past,
	// solid, awake, meeting all others and under the world's gravity.
	template <class BodyData, class ObjectData>
	void restoreAll(bParse::btBulletFile& file)
	{
		for (int i = 0; i < file.m_rigidBodies.size(); ++i)
		{
			const auto& saved = *reinterpret_cast<const BodyData*>(file.m_rigidBodies[i]);
			if (btRigidBody* const body = made(&saved)) restoreBody(saved, *body);
		}
		for (int i = 0; i < file.m_collisionObjects.size(); ++i)
		{
			const auto& saved = *reinterpret_cast<const ObjectData*>(file.m_collisionObjects[i]);
			if (btRigidBody* const object = made(&saved)) restoreObject(saved, *object);
		}
	}
	btRigidBody* made(const void* saved)
	{
		btCollisionObject** const object = m_bodyMap.find(saved);
		return object ? btRigidBody::upcast(*object) : nullptr;
	}
	template <class Vector>
	static btVector3 vector(const Vector& stored)
	{
		return {btScalar(stored.m_floats[0]), btScalar(stored.m_floats[1]), btScalar(stored.m_floats[2])};
	}
	// As it was given: Bullet multiplies it by the factor.
	static btVector3 given(btVector3 stored, const btVector3& factor)
	{
		for (int i = 0; i < 3; ++i)
			if (factor[i] != 0) stored[i] /= factor[i];
		return stored;
	}
	template <class Data>
	void restoreBody(const Data& saved, btRigidBody& body)
	{
		body.setInvInertiaDiagLocal(vector(saved.m_invInertiaLocal));
		body.updateInertiaTensor();
		body.setLinearVelocity(vector(saved.m_linearVelocity));
		body.setAngularVelocity(vector(saved.m_angularVelocity));
		body.setDamping(btScalar(saved.m_linearDamping), btScalar(saved.m_angularDamping));
		body.setGravity(vector(saved.m_gravity_acceleration));
		body.applyCentralForce(given(vector(saved.m_totalForce), body.getLinearFactor()));
		body.applyTorque(given(vector(saved.m_totalTorque), body.getAngularFactor()));
		body.setSleepingThresholds(btScalar(saved.m_linearSleepingThreshold), btScalar(saved.m_angularSleepingThreshold));
		restoreObject(saved.m_collisionObjectData, body);
	}
	template <class Data>
	void restoreObject(const Data& saved, btRigidBody& body)
	{
		// Where it was last: a kinematic body's velocity is its way from there.
		const auto& lastPose = saved.m_interpolationWorldTransform;
		btTransform last(btMatrix3x3::getIdentity(), vector(lastPose.m_origin));
		for (int row = 0; row < 3; ++row) last.getBasis()[row] = vector(lastPose.m_basis.m_el[row]);
		body.setInterpolationWorldTransform(last);
		body.setInterpolationLinearVelocity(vector(saved.m_interpolationLinearVelocity));
		body.setInterpolationAngularVelocity(vector(saved.m_interpolationAngularVelocity));
		if ((saved.m_collisionFlags & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING) != 0)
			body.setContactStiffnessAndDamping(btScalar(saved.m_contactStiffness), btScalar(saved.m_contactDamping));
		body.setCollisionFlags(saved.m_collisionFlags);
		const int group = saved.m_collisionFilterGroup, mask = saved.m_collisionFilterMask;
		btBroadphaseProxy* const proxy = body.getBroadphaseHandle();
		if (group != 0 && proxy && (proxy->m_collisionFilterGroup != group || proxy->m_collisionFilterMask != mask))
		{
			proxy->m_collisionFilterGroup = group;
			proxy->m_collisionFilterMask = mask;
			m_dynamicsWorld->refreshBroadphaseProxy(&body);
		}
		body.setContactProcessingThreshold(btScalar(saved.m_contactProcessingThreshold));
		body.setRollingFriction(btScalar(saved.m_rollingFriction));
		body.setAnisotropicFriction(vector(saved.m_anisotropicFriction), saved.m_hasAnisotropicFriction);
		body.setCcdMotionThreshold(btScalar(saved.m_ccdMotionThreshold));
		body.setCcdSweptSphereRadius(btScalar(saved.m_ccdSweptSphereRadius));
		body.forceActivationState(saved.m_activationState1);
		body.setDeactivationTime(btScalar(saved.m_deactivationTime));
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
