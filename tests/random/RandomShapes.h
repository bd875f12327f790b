// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes, places and numbers drawn from a seed, for worlds that nobody has thought of.
#pragma once
#include <btBulletDynamicsCommon.h>

#include <iterator>
#include <memory>
#include <vector>

#include "clod/bullet/btClodShape.h"
#include "tests/query/Bodies.h"

namespace clod::test
{
inline constexpr const char* kAnyModels[] = {"cup-3000", "spoon-3000", "torus-900", "number8-600", "ring",
										  "rod",	  "plate",		"box-12",	 "sphere-300"};

// Owns the shapes it makes.
class RandomShapes
{
public:
	explicit RandomShapes(std::uint64_t seed) : m_random(seed) {}

	std::size_t pick(std::size_t count) { return std::size_t(m_random() % count); }
	bool oneOf(std::size_t count) { return pick(count) == 0; }
	double between(double low, double high) { return uniform(m_random, low, high); }
	btVector3 vector(double longest)
	{
		const Vec3 v = randomVector(m_random, 0, longest);
		return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
	}
	btQuaternion turn()
	{
		const Vec3 axis = randomDirection(m_random);
		return btQuaternion(btVector3(btScalar(axis.x), btScalar(axis.y), btScalar(axis.z)), btScalar(between(0, 3.1)));
	}
	template <class Shape>
	Shape& add(std::unique_ptr<Shape> shape)
	{
		Shape& added = *shape;
		m_shapes.push_back(std::move(shape));
		return added;
	}
	// As the model is, stretched or mirrored.
	btClodShape& ours(double radius)
	{
		const Body& model = body(kAnyModels[pick(std::size(kAnyModels))]);
		btClodShape& shape = add(std::make_unique<btClodShape>(model.hierarchy));
		shape.setName(CLOD_FIXTURES "/" + model.name + ".clod");
		btVector3 scale(1, 1, 1);
		const std::size_t kind = pick(4);
		if (kind == 0)
			for (int k = 0; k < 3; ++k) scale[k] = btScalar(between(0.6, 1.5));
		if (kind == 1) scale.setX(-1);
		shape.setLocalScaling(scale * btScalar(radius / double(model.hierarchy->asset().radius)));
		return shape;
	}
	// Of two of ours.
	btCompoundShape& compound(double radius)
	{
		auto& whole = add(std::make_unique<btCompoundShape>());
		for (const double side : {-0.5, 0.5})
		{
			btTransform place(turn());
			place.setOrigin(btVector3(btScalar(side * radius), 0, 0));
			whole.addChildShape(place, &ours(0.5 * radius));
		}
		return whole;
	}
	btConvexInternalShape& bullets(double radius)
	{
		const btScalar r = btScalar(radius);
		switch (pick(4))
		{
			case 0: return add(std::make_unique<btBoxShape>(btScalar(0.5) * btVector3(r, r, r)));
			case 1: return add(std::make_unique<btSphereShape>(btScalar(0.8) * r));
			case 2: return add(std::make_unique<btCapsuleShape>(btScalar(0.3) * r, r));
			default: return add(std::make_unique<btCylinderShape>(btScalar(0.5) * btVector3(r, r, r)));
		}
	}
	// A box of ours, the upper side at height 0.
	btClodShape& slab(double half, double thickness)
	{
		btClodShape& box = add(std::make_unique<btClodShape>(body("box-12").hierarchy));
		box.setName(CLOD_FIXTURES "/box-12.clod");
		btVector3 least, most;
		box.getAabb(btTransform::getIdentity(), least, most);
		box.setLocalScaling(btVector3(btScalar(half) / most.x(), btScalar(thickness) / most.y(), btScalar(half) / most.z()));
		return box;
	}

private:
	Random m_random;
	std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
};
}  // namespace clod::test
