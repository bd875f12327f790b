// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/query/Bodies.h"

#include <cstdio>
#include <cstdlib>
#include <map>

namespace clod::test
{
namespace
{
Body loadBody(const std::string& name)
{
	auto hierarchy = Hierarchy::load(CLOD_FIXTURES "/" + name + ".clod");
	if (hierarchy) return bodyOf(name, *hierarchy);
	std::fprintf(stderr, "fixture %s (tests/fixtures/Recipes.cpp, scripts/fixtures): %s\n", name.c_str(),
				 hierarchy.error().c_str());
	std::abort();
}
}  // namespace

Body bodyOf(const std::string& name, std::shared_ptr<const Hierarchy> hierarchy)
{
	std::vector<std::array<Vec3, 3>> triangles = inputTriangles(*hierarchy);
	return {name, std::move(hierarchy), std::move(triangles)};
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

const Body& body(const std::string& name)
{
	static std::map<std::string, Body> bodies;
	auto found = bodies.find(name);
	if (found == bodies.end()) found = bodies.emplace(name, loadBody(name)).first;
	return found->second;
}

const Body& body(const std::string& model, std::size_t triangles)
{
	return body(model + "-" + std::to_string(triangles));
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

Vec3 randomVector(Random& random, double shortest, double longest)
{
	const Vec3 direction = randomDirection(random);
	return uniform(random, shortest, longest) * direction;
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
	const Vec3 target = randomVector(random, 0, 0.8 * radiusA);
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
