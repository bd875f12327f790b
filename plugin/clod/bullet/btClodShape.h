// SPDX-License-Identifier: Zlib
// A rigid, possibly moving, triangle solid with contact levels of detail, as a Bullet shape. Many shapes share one
// hierarchy; the hierarchy is never changed and may be used by many threads.
//
// Frame: the hierarchy's body frame, that is the mesh's axes with the origin at the centre of mass. Give Bullet
//   worldFromBody = worldFromMesh * shape.meshFromBody().
// Unit: the hierarchy's times the shape's scale. A body stretched or mirrored has a hierarchy of its own, derived from the
// one given, and the scale 1. Bullet's own constants (0.02 breaking threshold, 0.04 split-impulse
// threshold, sleeping speeds) suit bodies of about one unit: scale small things up (100 for tableware in metres).
#pragma once
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <LinearMath/btTransform.h>

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
inline constexpr double kBreakingShare = 0.003;  // of the radius: points that Bullet remembers drift no farther
}

ATTRIBUTE_ALIGNED16(class)
CLOD_API btClodShape : public btConcaveShape
{
public:
	BT_DECLARE_ALIGNED_ALLOCATOR();
	// The type must be the one registerAlgorithm was given. Margin 0.
	explicit btClodShape(std::shared_ptr<const clod::Hierarchy> hierarchy, int shapeType = FAST_CONCAVE_MESH_PROXYTYPE);

	// The one in use.
	const clod::Hierarchy& hierarchy() const
	{
		return *m_hierarchy;
	}
	const std::shared_ptr<const clod::Hierarchy>& sharedHierarchy() const
	{
		return m_hierarchy;
	}

	// What messages and serialised worlds call it: the file it is of, say. Empty at first.
	void setName(const std::string& name)
	{
		m_name = name;
	}
	const std::string& name() const
	{
		return m_name;
	}

	// Thresholds of every pair this shape takes part in; none = the context's. Takes effect at the next dispatch.
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

	// Any factors along the body frame's axes but zero, from the hierarchy as given. A uniform positive one costs nothing,
	// but where bodies of different scales meet, which are then derived (hierarchy/ScaledHierarchy.h) once a shape; any
	// other derives one here: some milliseconds for 10,000 triangles. What is refused leaves the old scale, and
	// scalingError() tells why; the shape's pairs warn of it.
	void setLocalScaling(const btVector3& scaling) override;
	// Empty, or why the last setLocalScaling was refused.
	const std::string& scalingError() const
	{
		return m_scalingError;
	}
	const btVector3& getLocalScaling() const override
	{
		return m_scaling;
	}
	// World lengths a unit of hierarchy().
	double scale() const
	{
		return m_scale;
	}
	// World lengths a unit of the hierarchy as given, in the direction of the least scale.
	double leastScale() const;
	// hierarchy() in world lengths; null where floats cannot hold it. May be called by several threads.
	std::shared_ptr<const clod::Hierarchy> inWorldLengths() const;
	// Changes with every accepted setLocalScaling, so that pairs notice.
	int revision() const
	{
		return m_revision;
	}

	// What contacts at levels from `finest` on (0: all) need of the surface, made ahead: linear in a level's triangles,
	// paid by the first contact there otherwise. Not for what is derived where scales differ.
	void prepareContacts(std::uint32_t finest = 0) const;

	// Pose of the body frame in the frame of the mesh's vertices (a translation, scaled).
	btTransform meshFromBody() const;
	// Where off-diagonal inertia matters: the pose of the principal frame in the body frame, to put this shape into a
	// btCompoundShape with the inverse as its child's transform, and the inertia to go with it.
	btTransform bodyFromPrincipal() const;
	btVector3 principalInertia(btScalar mass) const;

	void getAabb(const btTransform& worldFromBody, btVector3& aabbMin, btVector3& aabbMax) const override;
	// The diagonal of the exact inertia of the input solid, about the body frame's axes.
	void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;
	// The input surface's triangles that meet the box, as (part 0, face index); rays visit only what they cross.
	void processAllTriangles(btTriangleCallback * callback, const btVector3& aabbMin, const btVector3& aabbMax)
		const override;
	btScalar getContactBreakingThreshold(btScalar defaultFactor) const override;
	const char* getName() const override
	{
		return "Clod";
	}

	// Bullet's files have no place for a shape of a kind of its own: what is written is a box of this shape's extent, which
	// any importer can read, under a name that tells a program of yours what to put in its place. It is given to the
	// serializer for this shape, unless it has another name there already. The surface stays in the .clod file.
	int calculateSerializeBufferSize() const override;
	const char* serialize(void* buffer, btSerializer* serializer) const override;
	// What such a name says; none where it is no such name, or a damaged one. An importer asks for the name of the box
	// (btWorldImporter::getNameForPointer) where it makes the body, and loads `name`, whose hierarchy must have the hash.
	struct Serialized
	{
		std::uint64_t contentHash;  // of the hierarchy as given
		btVector3 scaling;
		std::string name;
	};
	static std::optional<Serialized> readSerializedName(const char* name);
	// Does it begin, or go on, as such a name does? One that cannot be read is damaged then.
	static bool isSerializedName(const char* name);

private:
	std::shared_ptr<const clod::Hierarchy> m_given, m_hierarchy;
	mutable std::shared_ptr<const clod::Hierarchy> m_inWorldLengths;
	mutable std::mutex m_deriving;
	std::string m_scalingError, m_name;
	mutable std::string m_serializedName;  // serializers keep a pointer to it
	std::optional<clod::ContactMetric> m_metric;
	btVector3 m_scaling, m_localMin, m_localMax;
	double m_scale = 1;
	int m_revision = 0;
	void updateBounds();
};
