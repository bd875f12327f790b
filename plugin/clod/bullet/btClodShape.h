// SPDX-License-Identifier: Zlib
// A rigid, possibly moving, triangle solid with contact levels of detail, as a Bullet shape. Many shapes share one
// hierarchy; the hierarchy is never changed and may be used by many threads.
//
// Frame: the hierarchy's body frame, that is the mesh's axes with the origin at the centre of mass. Give Bullet
//   worldFromBody = worldFromMesh * shape.meshFromBody().
// Unit: the hierarchy's unit times the shape's scale. A stretched or mirrored shape derives a hierarchy of its own from
// the given one, and has the scale 1. Bullet's own constants (0.02 breaking threshold, 0.04 split-impulse threshold,
// sleeping speeds) suit bodies of about one unit: scale small objects up (by 100 for tableware in metres).
#pragma once
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <LinearMath/btTransform.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "clod/Export.h"
#include "clod/bullet/Context.h"
#include "clod/hierarchy/Hierarchy.h"

namespace clod
{
inline constexpr double kBreakingShare = 0.003;  // contact breaking threshold, as a share of the radius
inline constexpr double kSameScale = 1e-6;       // scales whose ratio differs from 1 by less are equal
}

ATTRIBUTE_ALIGNED16(class)
CLOD_API btClodShape : public btConcaveShape
{
public:
	BT_DECLARE_ALIGNED_ALLOCATOR();
	// shapeType must be the one given to registerAlgorithm. The margin is 0 at first.
	explicit btClodShape(std::shared_ptr<const clod::Hierarchy> hierarchy, int shapeType = FAST_CONCAVE_MESH_PROXYTYPE);

	// The hierarchy in use: the given one, or the one derived for a stretched or mirrored shape.
	const clod::Hierarchy& hierarchy() const
	{
		return *m_hierarchy;
	}
	const std::shared_ptr<const clod::Hierarchy>& sharedHierarchy() const
	{
		return m_hierarchy;
	}

	// The name that messages and serialised worlds use, such as that of the .clod file. Empty at first.
	void setName(const std::string& name)
	{
		m_name = name;
	}
	const std::string& name() const
	{
		return m_name;
	}

	// The accuracy of every pair that this shape takes part in; without one, the context's counts. Takes effect at the
	// next dispatch.
	void setMetric(const clod::ContactMetric& metric)
	{
		m_metric = metric;
	}
	void clearMetric()
	{
		m_metric.reset();
	}
	const std::optional<clod::ContactMetric>& metric() const
	{
		return m_metric;
	}

	// Scales the given hierarchy by any factors but zero along the axes of the body frame. A uniform positive scale
	// costs nothing until it meets a body of another scale; then each shape derives a scaled hierarchy once
	// (hierarchy/ScaledHierarchy.h), which shapes of the same hierarchy and scale share. Any other scale derives one in
	// this call, which takes some milliseconds for 10,000 triangles. A scale that is refused leaves the old one in
	// place: scalingError() tells why, and the shape's pairs warn of it.
	void setLocalScaling(const btVector3& scaling) override;
	// Why the last setLocalScaling was refused, or empty.
	const std::string& scalingError() const
	{
		return m_scalingError;
	}
	const btVector3& getLocalScaling() const override
	{
		return m_scaling;
	}
	// The world length of one unit of hierarchy().
	double scale() const
	{
		return m_scale;
	}
	// The world length of one unit of the given hierarchy, in the direction of the smallest scale.
	double leastScale() const;
	// hierarchy() in world lengths, or null if floats cannot hold it. May be called by several threads.
	std::shared_ptr<const clod::Hierarchy> inWorldLengths() const;
	// Changes with every accepted setLocalScaling, so that pairs notice it.
	int revision() const
	{
		return m_revision;
	}

	// Prepares what contacts at the levels from `finest` on (0: all) need of the surface; otherwise the first contact
	// at a level does so. Takes time linear in the triangles. meetsOtherScales: prepares what contacts with bodies of
	// another scale need, instead.
	void prepareContacts(std::uint32_t finest = 0, bool meetsOtherScales = false) const;

	// The pose of the body frame in the frame of the mesh's vertices: a translation, scaled as the shape is.
	btTransform meshFromBody() const;
	// If off-diagonal inertia matters, put this shape into a btCompoundShape, with the inverse of bodyFromPrincipal
	// (the pose of the principal frame in the body frame) as child transform, and use principalInertia. ClodBody does
	// so.
	btTransform bodyFromPrincipal() const;
	btVector3 principalInertia(btScalar mass) const;

	// Encloses every level, of which coarse ones protrude: also unturned it is wider than the mesh (a ring, a torus: by
	// 0.25 to 0.3 of the radius on a side). Place bodies by meshFromBody or by rays.
	void getAabb(const btTransform& worldFromBody, btVector3& aabbMin, btVector3& aabbMax) const override;
	// The diagonal of the exact inertia of the input solid, about the body frame's axes.
	void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;
	// Visits the triangles of the input surface that meet the box, as part 0 and the index of the face. For rays, only
	// triangles near the ray are visited.
	void processAllTriangles(btTriangleCallback * callback, const btVector3& aabbMin, const btVector3& aabbMax)
		const override;
	btScalar getContactBreakingThreshold(btScalar defaultFactor) const override;
	const char* getName() const override
	{
		return "Clod";
	}

	// Bullet's file format has no place for shapes of other libraries. What is written is a box of this shape's extent,
	// which any importer can read, under a name that tells your program what to put in its place. The serializer gets
	// this name for this shape, unless it has another name there already. The surface itself stays in the .clod file.
	int calculateSerializeBufferSize() const override;
	const char* serialize(void* buffer, btSerializer* serializer) const override;
	// Reads such a name; none if it is another kind of name, or damaged. An importer gets the name of the box from
	// btWorldImporter::getNameForPointer when it makes the body, and loads the hierarchy `name`, which must have the
	// hash.
	struct Serialized
	{
		std::uint64_t contentHash;  // of the given hierarchy
		btVector3 scaling;
		std::string name;
	};
	static std::optional<Serialized> readSerializedName(const char* name);
	// Whether it begins as such a name does, or goes on as one whose beginning is damaged. If so and readSerializedName
	// gives none, it is damaged.
	static bool isSerializedName(const char* name);

private:
	std::shared_ptr<const clod::Hierarchy> m_given, m_hierarchy;
	mutable std::shared_ptr<const clod::Hierarchy> m_inWorldLengths;
	mutable std::atomic<bool> m_isDerived{false};  // into the latter
	mutable std::mutex m_deriving;
	std::string m_scalingError, m_name;
	mutable std::string m_serializedName;  // serializers keep a pointer to it
	std::optional<clod::ContactMetric> m_metric;
	btVector3 m_scaling, m_localMin, m_localMax;
	double m_scale = 1;
	int m_revision = 0;
	void updateBounds();
};
