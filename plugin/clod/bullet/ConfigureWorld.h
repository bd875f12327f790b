// SPDX-License-Identifier: Zlib
// What a Bullet world needs for contacts of detailed concave bodies, set by one call; and a body made of a file by another.
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
	// Most passes of the solver over all contacts of a step. 10 (Bullet's default) leave piles and joints soft; stacks of a
	// hundred bodies want 50.
	int solverIterations = 40;
	// They end once no row changes a speed by more than this share of what gravity adds in 1/240 s; 0: when nothing changes.
	// More lets bodies creep on slopes. Of the gravity that the world has when it is set up: set that first where it is far
	// from Bullet's 10.
	double leastChange = 1e-3;
	// Share of an overlap that a step takes away: of joints, and of contacts (whose push is no momentum: split
	// impulse).
	double erp = 0.2, erp2 = 0.8;
	// Overlaps deeper than the negative of it, in Bullet's lengths, are pushed out by split impulse; the others by
	// velocity, which stays as energy. Below -kTokenOverlap (SolverTerms.h): contacts of turning bodies need velocities.
	double splitImpulsePenetrationThreshold = -1e-6;
	// Share of the last step's impulses that a step begins with. What the rest has to make up for keeps piles moving: 0.98
	// stills them to a tenth (SolverTerms.h), 1 keeps up what stands by its thrust (arches of many stones). Not beyond
	// Bullet's 0.85 where bodies in joints touch: joints start from nothing, and a door is thrown from its stop.
	double warmstartingFactor = 0.85;
};

// Sets the solver of `world`; call it before the first step. Besides the settings: two friction directions, as one
// along the slip lets a leaning body creep sideways for ever, and split impulse. Gravity, bodies and dispatch stay as
// they are.
CLOD_API void configureWorld(btDynamicsWorld& world, const WorldSettings& settings = {});
// That, and the registration of our shapes with the world's dispatcher: all that a world needs. Before the first pair; the
// context must outlive the world. Value: how many pairs of types were registered.
CLOD_API Result<int> setUpWorld(btDynamicsWorld& world, Context& context, const WorldSettings& settings = {});

struct BodySettings
{
	double mass = 0;  // 0: static
	btVector3 scale = btVector3(1, 1, 1);
	btTransform worldFromMesh = btTransform::getIdentity();  // of the frame of the file's mesh, unscaled
	double friction = 0.5, restitution = 0;
};

// A rigid body and what it owns. Its frame is that of its principal axes of inertia at its centre of mass, which Bullet
// wants: where those are not the mesh's own axes the shape is the only child of a compound.
class CLOD_API ClodBody
{
public:
	// Loads the file, or says what is wrong with it or with the settings. The body is in no world yet.
	static Result<std::unique_ptr<ClodBody>> load(const std::string& path, const BodySettings& settings = {});
	// Bodies may share a hierarchy.
	static Result<std::unique_ptr<ClodBody>> make(const std::shared_ptr<const Hierarchy>& hierarchy,
												  const BodySettings& settings = {});
	btRigidBody& body() { return *m_body; }
	btClodShape& shape() { return *m_shape; }
	// Where the mesh of the file is now, unscaled.
	btTransform worldFromMesh() const { return m_body->getWorldTransform() * m_bodyFromMesh; }

private:
	ClodBody() = default;
	std::unique_ptr<btClodShape> m_shape;
	std::unique_ptr<btCompoundShape> m_compound;
	std::unique_ptr<btRigidBody> m_body;
	btTransform m_bodyFromMesh;
};
}  // namespace clod
