// SPDX-License-Identifier: Zlib
#include "clod/bullet/btClodShape.h"

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btSerializer.h>
#include <xxhash.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <vector>

#include "clod/hierarchy/ScaledHierarchy.h"
#include "clod/manifold/ContactPoints.h"
#include "clod/manifold/ContactSurface.h"
#include "clod/query/TraversalTables.h"

namespace
{
using clod::OrientedBox;
using clod::Hierarchy;
using clod::kSameScale;
using clod::toVec3;
using clod::Vec3;

constexpr double kRayRoom = 1e-4;  // of the radius
constexpr const char* kSerializedAs = "clod:";
constexpr std::size_t kCheckLength = 9;

// Adds a checksum to the saved name, so that damage to it is noticed.
std::string withCheck(const std::string& text)
{
	char check[16];
	std::snprintf(check, sizeof check, "%08" PRIx32 ":", std::uint32_t(XXH32(text.data(), text.size(), 0)));
	return check + text;
}

btVector3 scaled(const Vec3& v, double scale)
{
	return {btScalar(v.x * scale), btScalar(v.y * scale), btScalar(v.z * scale)};
}

// The box asked about, in the hierarchy's unit. Bounds beyond any body are cut so that nothing overflows.
struct Query
{
	Vec3 center, half;
	bool separated(const OrientedBox& box) const
	{
		const Vec3 boxCenter = toVec3(box.center);
		for (int axis = 0; axis < 3; ++axis)
		{
			double extent = 0;
			for (int i = 0; i < 3; ++i) extent += double(box.half[i]) * std::abs(double(box.axis[i][axis]));
			if (std::abs(boxCenter[axis] - center[axis]) > extent + half[axis]) return true;
		}
		return false;
	}
};

Query boxQuery(const btVector3& low, const btVector3& high, double scale)
{
	Query query;
	for (int i = 0; i < 3; ++i)
	{
		const double from = std::max(double(low[i]) / scale, -1e30), to = std::min(double(high[i]) / scale, 1e30);
		query.center[i] = 0.5 * (from + to);
		query.half[i] = std::max(0.0, 0.5 * (to - from)) + 1e-6 * (std::abs(from) + std::abs(to));
	}
	return query;
}

// The way of a ray or convex sweep of Bullet's, in the shape's frame and the hierarchy's unit, up to its nearest hit so
// far.
struct Path
{
	Vec3 from, to, grown;
	const btScalar* share = nullptr;
	bool misses(const OrientedBox& box) const { return clod::misses(box, grown, from, from + double(*share) * (to - from)); }
};

// Nothing where the caller asks for the triangles in a box, and there is no ray or sweep.
std::optional<Path> pathOf(const btTriangleCallback& callback, double scale, double radius)
{
	const auto inUnit = [scale](const btVector3& v) {
		return (1 / scale) * Vec3{double(v.x()), double(v.y()), double(v.z())};
	};
	if (const auto* ray = dynamic_cast<const btTriangleRaycastCallback*>(&callback))
	{
		// Room for rounding, and for what Bullet lets a ray miss a triangle by: one along an edge hits.
		const Vec3 from = inUnit(ray->m_from), to = inUnit(ray->m_to);
		const double room = kRayRoom * radius + 1e-6 * (length(from) + length(to));
		return Path{from, to, Vec3{room, room, room}, &ray->m_hitFraction};
	}
	const auto* sweep = dynamic_cast<const btTriangleConvexcastCallback*>(&callback);
	if (!sweep) return {};
	// A swept shape may turn on its way. Its boxes at both ends and the sphere around it bound where it comes.
	const btTransform shapeFromWorld = sweep->m_triangleToWorld.inverse();
	const btTransform from = shapeFromWorld * sweep->m_convexShapeFrom, to = shapeFromWorld * sweep->m_convexShapeTo;
	btVector3 low, high, center;
	btScalar around = 0;
	sweep->m_convexShape->getAabb(btTransform(from.getBasis()), low, high);
	if (!(from.getBasis() == to.getBasis()))
	{
		sweep->m_convexShape->getBoundingSphere(center, around);
		around += center.length();
		low.setValue(-around, -around, -around);
		high = -low;
	}
	const btVector3 middle = btScalar(0.5) * (low + high);
	const btScalar room = sweep->m_triangleCollisionMargin + sweep->m_allowedPenetration;
	const btVector3 half = btScalar(0.5) * (high - low) + btVector3(room, room, room);
	return Path{inUnit(from.getOrigin() + middle), inUnit(to.getOrigin() + middle), inUnit(half),
				&sweep->m_hitFraction};
}

// Walks the tree to the input surface; `skip` cuts branches, `visit` gets the level-0 nodes.
template <class Skip, class Visit>
void walk(const Hierarchy& hierarchy, const Skip& skip, const Visit& visit)
{
	std::vector<std::uint32_t> stack(1, hierarchy.root());
	while (!stack.empty())
	{
		const std::uint32_t index = stack.back();
		stack.pop_back();
		if (skip(hierarchy.cullBox(index))) continue;
		const clod::Node& node = hierarchy.node(index);
		if (node.level == 0) visit(node);
		const clod::Span<std::uint32_t> children = hierarchy.children(node);
		for (std::size_t i = node.primaryChildCount; i-- > 0;) stack.push_back(children[i]);
	}
}
}  // namespace

btClodShape::btClodShape(std::shared_ptr<const clod::Hierarchy> hierarchy, int shapeType)
	: m_given(std::move(hierarchy)), m_hierarchy(m_given), m_scaling(1, 1, 1)
{
	m_shapeType = shapeType;
	m_collisionMargin = 0;
	m_hierarchy->derived<clod::TraversalTables>();  // now, not in the first step
	updateBounds();
}

void btClodShape::updateBounds()
{
	const clod::Asset& asset = m_hierarchy->asset();
	for (int i = 0; i < 3; ++i)
	{
		// Rounded outward, by one step, for the rounding of the product.
		m_localMin[i] = std::nextafter(btScalar(double(asset.boxMin[i]) * m_scale), -BT_LARGE_FLOAT);
		m_localMax[i] = std::nextafter(btScalar(double(asset.boxMax[i]) * m_scale), BT_LARGE_FLOAT);
	}
}

void btClodShape::setLocalScaling(const btVector3& scaling)
{
	const Vec3 factors{double(scaling.x()), double(scaling.y()), double(scaling.z())};
	const Vec3 before{double(m_scaling.x()), double(m_scaling.y()), double(m_scaling.z())};
	if (factors == before) return m_scalingError.clear();  // what is kept of contacts stays
	const double scale = factors.x;
	const double spread = std::max(std::abs(factors.y - scale), std::abs(factors.z - scale));
	const bool isUniform = isFinite(factors) && scale > 0 && spread <= kSameScale * scale;
	if (isUniform)
	{
		m_hierarchy = m_given;
		m_scale = scale;
		m_scalingError.clear();
	}
	else
	{
		clod::Result<std::shared_ptr<const Hierarchy>> derived =
			m_given->derived<clod::ScaledHierarchies>().by(factors);
		m_scalingError = derived ? std::string() : derived.error();
		if (!derived) return;
		m_hierarchy = derived.value();
		m_hierarchy->derived<clod::TraversalTables>();
		m_scale = 1;
	}
	m_inWorldLengths.reset();
	m_isDerived = false;
	m_scaling = scaling;
	++m_revision;
	updateBounds();
}

double btClodShape::leastScale() const
{
	return std::min({std::abs(double(m_scaling.x())), std::abs(double(m_scaling.y())), std::abs(double(m_scaling.z()))});
}

// Null where floats cannot hold the scaled hierarchy.
std::shared_ptr<const Hierarchy> btClodShape::inWorldLengths() const
{
	if (m_scale == 1) return m_hierarchy;
	if (m_isDerived.load(std::memory_order_acquire)) return m_inWorldLengths;  // without a lock, as each dispatch asks
	const std::lock_guard<std::mutex> lock(m_deriving);
	if (m_isDerived.load(std::memory_order_relaxed)) return m_inWorldLengths;
	clod::Result<std::shared_ptr<const Hierarchy>> derived =
		m_hierarchy->derived<clod::ScaledHierarchies>().by({m_scale, m_scale, m_scale});
	if (!derived) return nullptr;
	m_inWorldLengths = derived.value();
	m_isDerived.store(true, std::memory_order_release);
	return m_inWorldLengths;
}

void btClodShape::prepareContacts(std::uint32_t finest, bool meetsOtherScales) const
{
	const std::shared_ptr<const Hierarchy> hierarchy = meetsOtherScales ? inWorldLengths() : m_hierarchy;
	if (!hierarchy) return;
	hierarchy->derived<clod::TraversalTables>();
	const clod::ContactSurfaces& surfaces = hierarchy->derived<clod::ContactSurfaces>();
	for (std::uint32_t level = finest; level <= hierarchy->coarsestClodLevel(); ++level)
		surfaces.level(level).makeTree();
}

btTransform btClodShape::meshFromBody() const
{
	const double* origin = m_hierarchy->asset().meshFromBody;
	return btTransform(btQuaternion::getIdentity(), scaled({origin[0], origin[1], origin[2]}, m_scale));
}

btTransform btClodShape::bodyFromPrincipal() const
{
	const double* q = m_hierarchy->asset().principal;
	return btTransform(btQuaternion(btScalar(q[0]), btScalar(q[1]), btScalar(q[2]), btScalar(q[3])));
}

btVector3 btClodShape::principalInertia(btScalar mass) const
{
	const clod::Asset& asset = m_hierarchy->asset();
	const double* q = asset.principal;
	const double* t = asset.inertia;
	const clod::Mat3 rotation = clod::rotationFromQuaternion(q[0], q[1], q[2], q[3]);
	const clod::Mat3 tensor = {{{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}}};
	Vec3 moments;
	for (int i = 0; i < 3; ++i) moments[i] = dot(rotation.column(i), tensor * rotation.column(i));
	return scaled(moments, double(mass) / asset.volume * m_scale * m_scale);
}

void btClodShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const
{
	const clod::Asset& asset = m_hierarchy->asset();
	inertia =
		scaled({asset.inertia[0], asset.inertia[1], asset.inertia[2]}, double(mass) / asset.volume * m_scale * m_scale);
}

void btClodShape::getAabb(const btTransform& worldFromBody, btVector3& aabbMin, btVector3& aabbMax) const
{
	clod::warnIfUnregistered();
	// Compounds drop a child's pair, and its memory, as soon as these boxes part: they must hold every resting contact.
	const double resting = (clod::kRestingShare + clod::kSkinShare) * double(m_hierarchy->asset().radius) * m_scale;
	btTransformAabb(m_localMin, m_localMax, m_collisionMargin + btScalar(resting), worldFromBody, aabbMin, aabbMax);
}

btScalar btClodShape::getContactBreakingThreshold(btScalar defaultFactor) const
{
	const btScalar fine = btScalar(clod::kBreakingShare * double(m_hierarchy->asset().radius) * m_scale);
	return btMin(btConcaveShape::getContactBreakingThreshold(defaultFactor), fine);
}

int btClodShape::calculateSerializeBufferSize() const
{
	return int(sizeof(btConvexInternalShapeData));
}

const char* btClodShape::serialize(void* buffer, btSerializer* serializer) const
{
	// Written as the bits of floats, because decimal numbers depend on the machine's locale.
	std::uint32_t bits[3];
	for (int i = 0; i < 3; ++i)
	{
		const float factor = float(m_scaling[i]);
		std::memcpy(&bits[i], &factor, sizeof factor);
	}
	char numbers[64];
	std::snprintf(numbers, sizeof numbers, "%016" PRIx64 ":%08" PRIx32 ":%08" PRIx32 ":%08" PRIx32 ":",
				  m_given->contentHash(), bits[0], bits[1], bits[2]);
	m_serializedName = kSerializedAs + withCheck(numbers + m_name);
	if (!serializer->findNameForPointer(this)) serializer->registerNameForPointer(this, m_serializedName.c_str());
	auto& data = *static_cast<btConvexInternalShapeData*>(buffer);
	data = {};
	btConcaveShape::serialize(&data.m_collisionShapeData, serializer);
	data.m_collisionShapeData.m_shapeType = BOX_SHAPE_PROXYTYPE;
	btVector3(1, 1, 1).serializeFloat(data.m_localScaling);
	btVector3 farthest = m_localMin.absolute();
	farthest.setMax(m_localMax.absolute());
	farthest.serializeFloat(data.m_implicitShapeDimensions);
	data.m_collisionMargin = float(m_collisionMargin);
	return "btConvexInternalShapeData";
}

bool btClodShape::isSerializedName(const char* name)
{
	const std::size_t length = std::strlen(kSerializedAs);
	if (!name || std::strncmp(name, kSerializedAs, length) == 0) return name != nullptr;
	// Its beginning may be what is damaged: the check of the rest is no other name's.
	const std::string text = name;
	return text.size() > length + kCheckLength && text.substr(length) == withCheck(text.substr(length + kCheckLength));
}

std::optional<btClodShape::Serialized> btClodShape::readSerializedName(const char* name)
{
	if (!name || std::strncmp(name, kSerializedAs, std::strlen(kSerializedAs)) != 0) return {};
	const std::string text = name + std::strlen(kSerializedAs), numbers = text.substr(std::min(text.size(), kCheckLength));
	if (text != withCheck(numbers)) return {};
	std::uint64_t hash = 0;
	std::uint32_t bits[3];
	int end = 0;
	const int read = std::sscanf(numbers.c_str(), "%16" SCNx64 ":%8" SCNx32 ":%8" SCNx32 ":%8" SCNx32 ":%n", &hash, &bits[0],
								 &bits[1], &bits[2], &end);
	if (read != 4 || end == 0) return {};
	float factor[3];
	std::memcpy(factor, bits, sizeof factor);
	return Serialized{hash, btVector3(btScalar(factor[0]), btScalar(factor[1]), btScalar(factor[2])), numbers.substr(std::size_t(end))};
}

void btClodShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
									  const btVector3& aabbMax) const
{
	const Hierarchy& hierarchy = *m_hierarchy;
	const std::optional<Path> path = pathOf(*callback, m_scale, double(hierarchy.asset().radius));
	btVector3 low = aabbMin, high = aabbMax;
	if (path)  // Bullet's box has no room for rounding, and of what turns only that of the last pose
		for (const Vec3& end : {path->from, path->to})
		{
			low.setMin(scaled(end - path->grown, m_scale));
			high.setMax(scaled(end + path->grown, m_scale));
		}
	const Query query = boxQuery(low, high, m_scale);
	const auto skip = [&](const OrientedBox& box)
	{ return query.separated(box) || (path && path->misses(box)); };
	const auto visit = [&](const clod::Node& node)
	{
		const clod::HullView hull = hierarchy.hull(node);
		for (std::uint32_t i = 0; i < node.faceCount; ++i)
		{
			const clod::Face& face = hierarchy.faces()[node.firstFace + i];
			btVector3 corners[3];
			for (int k = 0; k < 3; ++k) corners[k] = scaled(hull.vertex(face.vertex[k]), m_scale);
			if (TestTriangleAgainstAabb2(corners, low, high))
				callback->processTriangle(corners, 0, int(node.firstFace + i));
		}
	};
	walk(hierarchy, skip, visit);
}
