// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/query/Bodies.h"

#include <cstdio>
#include <cstdlib>
#include <map>
#include <tuple>

#include "demos/models/Models.h"

namespace clod::test
{
namespace
{
[[noreturn]] void fail(const std::string& message)
{
	std::fprintf(stderr, "%s\n", message.c_str());
	std::abort();
}

// The mesh with its centre of mass at the origin, vertices rounded to float.
builder::Mesh bodyMesh(const demo::ModelMesh& model, double scale)
{
	Vec3 center;
	double volume = 0;
	for (const auto& t : model.triangles)
	{
		const Vec3 &p = model.vertices[t[0]], &q = model.vertices[t[1]], &r = model.vertices[t[2]];
		const double six = dot(p, cross(q, r));
		volume += six;
		center += 0.25 * six * (p + q + r);
	}
	center = (1 / volume) * center;
	builder::Mesh mesh;
	for (const Vec3& v : model.vertices) mesh.vertices.push_back(toVec3(toFloat3(scale * (v - center))));
	mesh.triangles.assign(model.triangles.begin(), model.triangles.end());
	return mesh;
}

Body build(const std::string& name, std::size_t triangles, const BodyOptions& options)
{
	auto model = demo::makeModel(name, triangles);
	if (!model) fail(model.error());
	return bodyOf(name, bodyMesh(*model, options.scale), options.paper);
}
}  // namespace

Body bodyOf(const std::string& name, const builder::Mesh& mesh, bool paper)
{
	const auto progress = [](const char*, double) { return true; };
	builder::BuildConfig config;
	config.paper = paper;
	auto hierarchy = Hierarchy::fromBytes(encode(builder::buildHierarchy(mesh, config, progress)));
	if (!hierarchy) fail(name + ": " + hierarchy.error());
	return {name, *hierarchy, inputTriangles(**hierarchy)};
}

std::vector<std::array<Vec3, 3>> inputTriangles(const Hierarchy& hierarchy)
{
	std::vector<std::array<Vec3, 3>> triangles;
	const Level& input = hierarchy.levels()[0];
	for (std::uint32_t n = input.firstNode; n < input.firstNode + input.nodeCount; ++n)
	{
		const Node& node = hierarchy.node(n);
		const HullView hull = hierarchy.hull(node);
		for (const Face& face : hierarchy.faces(node))
			triangles.push_back(
				{hull.vertex(face.vertex[0]), hull.vertex(face.vertex[1]), hull.vertex(face.vertex[2])});
	}
	return triangles;
}

const Body& body(const std::string& model, std::size_t triangles, const BodyOptions& options)
{
	static std::map<std::tuple<std::string, std::size_t, double, bool>, Body> bodies;
	const auto key = std::make_tuple(model, triangles, options.scale, options.paper);
	auto found = bodies.find(key);
	if (found == bodies.end()) found = bodies.emplace(key, build(model, triangles, options)).first;
	return found->second;
}

double uniform(Random& random, double low, double high)
{
	return low + (high - low) * double(random() >> 11) * 0x1p-53;
}

Vec3 randomDirection(Random& random)
{
	for (;;)
	{
		const Vec3 v{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
		if (lengthSquared(v) > 1e-3 && lengthSquared(v) < 1) return normalized(v);
	}
}

Mat3 randomRotation(Random& random, double largestAngle)
{
	const Vec3 axis = randomDirection(random);
	const double half = 0.5 * uniform(random, 0, largestAngle), s = std::sin(half);
	return rotationFromQuaternion(s * axis.x, s * axis.y, s * axis.z, std::cos(half));
}

Transform poseWithGap(Random& random, const Body& a, const Body& b, double gap)
{
	const double radiusA = a.hierarchy->asset().radius, radiusB = b.hierarchy->asset().radius;
	Transform pose{randomRotation(random), 4 * (radiusA + radiusB) * randomDirection(random)};
	Settings settings;
	settings.metric.exact = true;
	settings.distance = true;
	// Aim at a point of A, not always at its middle; then close in along that line until the bodies touch.
	const Vec3 target = uniform(random, 0, 0.8) * radiusA * randomDirection(random);
	const Vec3 way = normalized(target - pose.translation);
	GapCache cache;
	GapResult result;
	for (int i = 0; i < 200; ++i)
	{
		query(*a.hierarchy, *b.hierarchy, pose, settings, cache, result);
		if (result.minDistance < 1e-4 * smallerRadius(a, b) || result.contacts.size() > 1000000) break;
		if (dot(pose.translation - target, way) > 0) break;
		pose.translation += result.minDistance * way;
	}
	pose.translation += -gap * smallerRadius(a, b) * way;
	return pose;
}
}  // namespace clod::test
