// SPDX-License-Identifier: Zlib
// One call that sets up a Bullet world for contacts of detailed concave bodies, and one that makes a body from a file.
#pragma once
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <memory>
#include <string>

#include "clod/Export.h"
#include "clod/bullet/btClodShape.h"
#include "clod/hierarchy/Result.h"

class btDynamicsWorld;

namespace clod
{
struct WorldSettings
{
	// The largest number of passes of the solver over all contacts of a step. With 10, Bullet's default, piles and
	// joints are soft; stacks of a hundred bodies need 50, bodies between ones a hundred times as heavy 200, unless the
	// world is a btClodDynamicsWorld, and linkages that are held by contacts and jam under load 400.
	int solverIterations = 40;
	// The passes end once no row changes a speed by more than this share of what gravity adds in 1/240 s; with 0, only
	// when nothing changes. Larger values let bodies creep on slopes. The gravity is the one that the world has when it
	// is set up, so set it first.
	double leastChange = 1e-3;
	// The share of an error that a step corrects: erp of joints, erp2 of overlaps at contacts (by split impulse, which
	// adds no momentum).
	double erp = 0.2, erp2 = 0.8;
	// Overlaps deeper than the negative of this, in world lengths, are corrected by split impulse, the others by
	// velocity, which remains as energy. It must be below -kTokenOverlap (SolverTerms.h): contacts of turning bodies
	// need velocities.
	double splitImpulsePenetrationThreshold = -1e-6;
	// The share of the last step's impulses that a step starts from. Finding the remaining share anew keeps piles
	// moving: with 0.98 they move a tenth as much (SolverTerms.h), and arches of many stones need 1. Keep Bullet's 0.85
	// if bodies in joints touch: impulses of joints start from zero, and a door is thrown from its stop.
	double warmstartingFactor = 0.85;
};

// Sets the solver of `world`; call it before the first step. Besides the settings it turns on split impulse and two
// friction directions, because with one, along the slip, a leaning body creeps sideways for ever. Gravity, bodies and
// dispatch stay as they are.
CLOD_API void configureWorld(btDynamicsWorld& world, const WorldSettings& settings = {});
// Does the same and registers our shapes with the world's dispatcher, which is all that a world needs. Call it before
// the first pair exists; the context must outlive the world. Returns how many pairs of shape types were registered.
CLOD_API Result<int> setUpWorld(btDynamicsWorld& world, Context& context, const WorldSettings& settings = {});

struct BodySettings
{
	double mass = 0;  // 0: static
	btVector3 scale = btVector3(1, 1, 1);
	btTransform worldFromMesh = btTransform::getIdentity();  // pose of the file's mesh, without the scale
	double friction = 0.5, restitution = 0;
};

// A rigid body and what it owns. As Bullet requires, its frame is that of its principal axes of inertia, with the
// origin at the centre of mass. If these are not the mesh's own axes, the shape is the only child of a compound.
class CLOD_API ClodBody
{
public:
	// Loads the file, or tells what is wrong with it or with the settings. The body is in no world yet.
	static Result<std::unique_ptr<ClodBody>> load(const std::string& path, const BodySettings& settings = {});
	// Bodies may share a hierarchy.
	static Result<std::unique_ptr<ClodBody>> make(const std::shared_ptr<const Hierarchy>& hierarchy,
												  const BodySettings& settings = {});
	btRigidBody& body() { return *m_body; }
	btClodShape& shape() { return *m_shape; }
	// The pose of the file's mesh now, without the scale.
	btTransform worldFromMesh() const { return m_body->getWorldTransform() * m_bodyFromMesh; }

private:
	ClodBody() = default;
	std::unique_ptr<btClodShape> m_shape;
	std::unique_ptr<btCompoundShape> m_compound;
	std::unique_ptr<btRigidBody> m_body;
	btTransform m_bodyFromMesh;
};
}  // namespace clod
