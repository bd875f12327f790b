// SPDX-License-Identifier: Zlib
#include "clod/bullet/ConvexPartner.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "clod/bullet/BodyState.h"
#include "clod/hierarchy/ConvexPiece.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
namespace
{
constexpr std::size_t kMostCorners = 256;        // of what is curved
constexpr std::size_t kMostHullCorners = 65535;  // that a face can name
constexpr double kCurved = 0.5 * kSkinShare;     // of the radius: how far a prism may be from its cylinder
constexpr double kSheet = 1e-5;                  // of its size: half the thickness of what is flat
constexpr std::size_t kMostUnused = 256;         // partners kept for shapes that may come again

// A circle about an axis of the frame.
struct Rim
{
	double radius, height;
	int up;
};

// A shape as points and rims or as a support function, grown by a radius. World lengths.
struct Description
{
	std::vector<double> numbers;
	std::vector<Vec3> points;
	std::vector<Rim> rims;
	bool isMesh = false;  // points are all corners of its triangles, of which numbers hold a hash
	double radius = 0;
	bool isBySupport = false;
	double size = 0;  // of what is known by its support: how far it reaches
	// Are numbers what is seen of it, and where it is? Else they are all that makes it.
	bool isSeen() const { return points.empty() && rims.empty(); }
};

Vec3 centerOf(const btMultiSphereShape& shape, int i)
{
	const Vec3 scaling = toVec3(shape.getLocalScaling()), center = toVec3(shape.getSpherePosition(i));
	return {center.x * scaling.x, center.y * scaling.y, center.z * scaling.z};
}

// The support of the spheres once the least radius is taken off all of them. Bullet's own support function takes off
// the margin instead, which may be more than a sphere's radius.
Vec3 coreSupport(const btMultiSphereShape& shape, double radius, const Vec3& direction)
{
	const Vec3 unit = normalized(direction);
	const double scale = double(shape.getLocalScaling().x());
	Vec3 best;
	double farthest = -std::numeric_limits<double>::infinity();
	for (int i = 0; i < shape.getSphereCount(); ++i)
	{
		const Vec3 point = centerOf(shape, i) + (double(shape.getSphereRadius(i)) * scale - radius) * unit;
		if (!(dot(point, direction) > farthest)) continue;
		farthest = dot(point, direction);
		best = point;
	}
	return best;
}

Vec3 coreSupport(const btConvexShape& shape, double radius, const Vec3& direction)
{
	if (shape.getShapeType() == MULTI_SPHERE_SHAPE_PROXYTYPE)
		return coreSupport(static_cast<const btMultiSphereShape&>(shape), radius, direction);
	if (shape.getShapeType() == UNIFORM_SCALING_SHAPE_PROXYTYPE)
	{
		const auto& scaled = static_cast<const btUniformScalingShape&>(shape);
		const double factor = double(scaled.getUniformScalingFactor());
		return factor * coreSupport(*scaled.getChildShape(), radius / factor, direction);
	}
	return toVec3(shape.localGetSupportingVertexWithoutMargin(
		btVector3(btScalar(direction.x), btScalar(direction.y), btScalar(direction.z))));
}

// A regular polygon around the rim such that its corners lie as far outside of the circle as its sides lie inside.
// Returns how far that is.
double addCorners(const Rim& rim, std::vector<Vec3>& points)
{
	const int sides = 4 * int(std::ceil(0.125 * 3.14159265358979 / std::sqrt(kCurved)));
	const double half = 3.14159265358979 / sides, corner = 2 * rim.radius / (1 + std::cos(half));
	for (int i = 0; i < sides; ++i)
	{
		Vec3 p;
		p[rim.up] = rim.height;
		p[(rim.up + 1) % 3] = corner * std::cos((2 * i + 1) * half);
		p[(rim.up + 2) % 3] = corner * std::sin((2 * i + 1) * half);
		points.push_back(p);
	}
	return rim.radius - corner * std::cos(half);
}

void describeCylinder(const btCylinderShape& shape, Description& description)
{
	const int up = shape.getUpAxis();
	const Vec3 half = toVec3(shape.getHalfExtentsWithoutMargin());
	const double radius = std::max(0.0, double(shape.getRadius()) - description.radius);
	const double height = std::max(0.0, half[up]);
	description.rims = {{radius, height, up}, {radius, -height, up}};
}

void describeCone(const btConeShape& shape, Description& description)
{
	const int up = shape.getConeUpIndex();
	Vec3 apex;
	apex[up] = 0.5 * double(shape.getHeight());
	description.points.push_back(apex);
	description.rims = {{double(shape.getRadius()), -apex[up], up}};
}

void describeCapsule(const btCapsuleShape& shape, Description& description)
{
	Vec3 end;
	end[shape.getUpAxis()] = double(shape.getHalfHeight());
	description.points = {end, -end};
}

// Spheres are grown by the least of their radii. Where all radii are equal only the centres are left; else the points
// tell which spheres they are.
void describeSpheres(const btMultiSphereShape& shape, Description& description)
{
	btScalar least = shape.getSphereRadius(0);
	for (int i = 1; i < shape.getSphereCount(); ++i) least = btMin(least, shape.getSphereRadius(i));
	description.radius = double(least) * double(shape.getLocalScaling().x());
	for (int i = 0; i < shape.getSphereCount(); ++i)
	{
		description.points.push_back(centerOf(shape, i));
		if (shape.getSphereRadius(i) != least) description.isBySupport = true;
	}
	for (int i = 0; description.isBySupport && i < shape.getSphereCount(); ++i)
	{
		const double radius = double(shape.getSphereRadius(i)) * double(shape.getLocalScaling().x());
		description.size = std::max(description.size, length(centerOf(shape, i)) + radius);
		description.points.push_back({radius, 0, 0});
	}
}

// All corners of its triangles as Bullet gives them, each as often as it is one: its hull's corners are among them.
// They are asked for each time, as a program may move them without a word. How many rows of corners there are is not
// asked: Bullet never reads that number, and a program need not set it.
void describeMesh(const btConvexTriangleMeshShape& shape, Description& description)
{
	struct : btInternalTriangleIndexCallback
	{
		std::vector<Vec3>* points = nullptr;
		void internalProcessTriangleIndex(btVector3* corners, int, int) override
		{
			for (int i = 0; i < 3; ++i) points->push_back(toVec3(corners[i]));
		}
	} sink;
	sink.points = &description.points;
	const btScalar far = BT_LARGE_FLOAT;
	shape.getMeshInterface()->InternalProcessAllTriangles(&sink, btVector3(-far, -far, -far), btVector3(far, far, far));
	description.isMesh = true;
	description.isBySupport = description.points.empty();
}

void describePolyhedron(const btPolyhedralConvexShape& shape, Description& description)
{
	for (int i = 0; i < shape.getNumVertices(); ++i)
	{
		btVector3 vertex;
		shape.getVertex(i, vertex);
		description.points.push_back(toVec3(vertex));
	}
	// The corners that Bullet gives for a box have the margin in them.
	if (shape.getShapeType() == BOX_SHAPE_PROXYTYPE) description.radius = 0;
	description.isBySupport = description.points.empty();
}

// What is seen of a shape along some directions tells when it changes, but not whether another is the same.
void look(const btConvexShape& shape, Description& description)
{
	std::vector<double>& numbers = description.numbers;
	numbers.push_back(double(reinterpret_cast<std::uintptr_t>(&shape)));
	for (int x = -1; x <= 1; ++x)
		for (int y = -1; y <= 1; ++y)
			for (int z = -1; z <= 1; ++z)
			{
				const Vec3 p = coreSupport(shape, description.radius, {double(x), double(y), double(z)});
				numbers.insert(numbers.end(), {p.x, p.y, p.z});
				description.size = std::max({description.size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
			}
}

void describeByKind(const btConvexShape& shape, Description& description);

void describeScaled(const btUniformScalingShape& shape, Description& description)
{
	describeByKind(*shape.getChildShape(), description);
	const double factor = double(shape.getUniformScalingFactor());
	for (Vec3& p : description.points) p = factor * p;
	for (Rim& rim : description.rims) rim = {factor * rim.radius, factor * rim.height, rim.up};
	description.radius *= factor;
	description.size *= factor;
}

void describeByKind(const btConvexShape& shape, Description& description)
{
	description.radius = double(shape.getMargin());
	if (shape.getShapeType() == CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE)
		describeMesh(static_cast<const btConvexTriangleMeshShape&>(shape), description);
	else if (shape.isPolyhedral())
		describePolyhedron(static_cast<const btPolyhedralConvexShape&>(shape), description);
	else if (shape.getShapeType() == SPHERE_SHAPE_PROXYTYPE)
		description.points.push_back({});
	else if (shape.getShapeType() == CAPSULE_SHAPE_PROXYTYPE)
		describeCapsule(static_cast<const btCapsuleShape&>(shape), description);
	else if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
		describeCylinder(static_cast<const btCylinderShape&>(shape), description);
	else if (shape.getShapeType() == CONE_SHAPE_PROXYTYPE)
		describeCone(static_cast<const btConeShape&>(shape), description);
	else if (shape.getShapeType() == MULTI_SPHERE_SHAPE_PROXYTYPE)
		describeSpheres(static_cast<const btMultiSphereShape&>(shape), description);
	else if (shape.getShapeType() == UNIFORM_SCALING_SHAPE_PROXYTYPE)
		describeScaled(static_cast<const btUniformScalingShape&>(shape), description);
	else
		description.isBySupport = true;
}

void describe(const btConvexShape& shape, Description& description)
{
	description.points.clear();
	description.rims.clear();
	description.isMesh = description.isBySupport = false;
	description.size = 0;
	describeByKind(shape, description);
	const std::vector<Vec3>& points = description.points;
	std::vector<double>& numbers = description.numbers;
	numbers.assign({double(shape.getShapeType()), description.radius, double(description.isBySupport)});
	numbers.push_back(double(description.rims.size()));
	if (description.isMesh)
	{
		const std::uint64_t hash = XXH3_64bits(points.data(), points.size() * sizeof(Vec3));
		numbers.insert(numbers.end(), {double(hash >> 32), double(hash & 0xFFFFFFFFu), double(points.size())});
	}
	else
		for (const Vec3& p : points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
	for (const Rim& rim : description.rims) numbers.insert(numbers.end(), {rim.radius, rim.height, double(rim.up)});
	if (description.isSeen()) look(shape, description);
}

// Makes a thin solid of a flat body, which encloses no volume.
ConvexPolyhedron thickened(const ConvexPolyhedron& flat)
{
	const std::array<std::uint32_t, 3>& t = flat.triangles[0];
	double size = 0;
	for (const Vec3& v : flat.vertices) size = std::max(size, length(v - flat.vertices[0]));
	const Vec3 &a = flat.vertices[t[0]], &b = flat.vertices[t[1]], &c = flat.vertices[t[2]];
	const Vec3 half = kSheet * size * normalized(cross(b - a, c - a));
	std::vector<Vec3> points;
	for (const Vec3& v : flat.vertices)
	{
		points.push_back(v + half);
		points.push_back(v - half);
	}
	return convexPolyhedron(points, kMostHullCorners);
}

// Would the polyhedron that stands for a shape known by its support come out the same again?
bool answersAsBefore(const btConvexShape& shape, double unit, double radius, const ConvexPartner& partner)
{
	return std::all_of(partner.answers.begin(), partner.answers.end(), [&](const std::array<Vec3, 2>& answer)
					   { return (1 / unit) * coreSupport(shape, radius, answer[0]) == answer[1]; });
}

void make(const btConvexShape& shape, double unit, const Description& description, ConvexPartner& partner)
{
	partner.radius = description.radius / unit;
	ConvexPolyhedron polyhedron;
	double error = 0;  // of rims
	if (description.isBySupport)
		polyhedron = convexPolyhedron(
			[&](const Vec3& d)
			{
				const Vec3 there = (1 / unit) * coreSupport(shape, description.radius, d);
				if (description.isSeen()) partner.answers.push_back({d, there});
				return there;
			},
			kCurved * (description.size + description.radius) / unit, kMostCorners);
	else
	{
		std::vector<Vec3> points = description.points;
		for (const Rim& rim : description.rims) error = addCorners(rim, points);
		for (Vec3& p : points) p = (1 / unit) * p;
		polyhedron = convexPolyhedron(points, kMostHullCorners);
	}
	partner.error = polyhedron.error + error / unit;
	Result<std::shared_ptr<const Hierarchy>> piece = convexPiece(polyhedron, partner.radius);
	if (!piece && !polyhedron.triangles.empty()) piece = convexPiece(thickened(polyhedron), partner.radius);
	if (piece)
		partner.hierarchy = piece.value();
	else
		partner.problem = piece.error();
}
}  // namespace

std::shared_ptr<const ConvexPartner> ConvexPartners::of(const btConvexShape& shape, double unit,
														const std::shared_ptr<const ConvexPartner>& known)
{
	thread_local Description description;  // asked once a pair and dispatch: buffers stay
	describe(shape, description);
	description.numbers.push_back(unit);
	if (known && known->shape == description.numbers) return known;
	ConvexPartner made;
	made.shape = description.numbers;
	const std::vector<Vec3>& points = description.points;  // of a mesh numbers have but their hash
	if (!std::all_of(made.shape.begin(), made.shape.end(), [](double v) { return std::isfinite(v); }) ||
		!std::all_of(points.begin(), points.end(), [](const Vec3& p) { return isFinite(p); }))
	{
		made.problem = "a number of the shape is not finite";
		return std::make_shared<const ConvexPartner>(made);
	}
	// Of a shape of which little is seen only the last partner is kept. Its functions are the program's, and not called
	// under the lock.
	const bool isSeen = description.isSeen();
	const double address = double(reinterpret_cast<std::uintptr_t>(&shape));
	const std::vector<double> key = isSeen ? std::vector<double>{address, unit} : made.shape;
	const std::shared_ptr<const ConvexPartner> kept = find(key);
	const auto isAsBefore = [&]
	{ return kept->shape == made.shape && answersAsBefore(shape, unit, description.radius, *kept); };
	if (kept && (!isSeen || isAsBefore())) return kept;
	make(shape, unit, description, made);
	const auto partner = std::make_shared<const ConvexPartner>(std::move(made));
	keep(key, partner);
	return partner;
}

std::shared_ptr<const ConvexPartner> ConvexPartners::find(const std::vector<double>& key)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	const auto found = m_partners.find(key);
	return found == m_partners.end() ? nullptr : found->second;
}

void ConvexPartners::keep(const std::vector<double>& key, const std::shared_ptr<const ConvexPartner>& partner)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_partners[key] = partner;
	for (auto i = m_partners.begin(); m_partners.size() > kMostUnused && i != m_partners.end();)
		i = i->second.use_count() == 1 ? m_partners.erase(i) : std::next(i);
}
}  // namespace clod
