// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies for tests of the plugin: small .clod files that the real builder wrote, and their input triangles read back.
#pragma once
#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/query/Ask.h"

namespace clod::test
{
struct Body
{
	std::string name;
	std::shared_ptr<const Hierarchy> hierarchy;
	std::vector<std::array<Vec3, 3>> triangles;  // level 0, body frame
};

// Those of level 0, in the body frame.
std::vector<std::array<Vec3, 3>> inputTriangles(const Hierarchy& hierarchy);
Body bodyOf(const std::string& name, std::shared_ptr<const Hierarchy> hierarchy);

// NAME.clod of tests/fixtures, loaded once a process; of a benchmark model MODEL-TRIANGLES.clod. Aborts where there is
// none.
const Body& body(const std::string& name);
const Body& body(const std::string& model, std::size_t triangles);

using Random = std::mt19937_64;
double uniform(Random& random, double low, double high);
Vec3 randomDirection(Random& random);
// A random direction, and then how long: two draws in one expression come in the order that the compiler likes.
Vec3 randomVector(Random& random, double shortest, double longest);
Mat3 randomRotation(Random& random, double largestAngle = 3.14159265358979);

// A random pose whose gap is `gap` of the smaller radius to within the hull distance (apart), or the depth reached by
// pushing B that far beyond first contact (gap < 0).
Transform poseWithGap(Random& random, const Body& a, const Body& b, double gap);

inline double smallerRadius(const Body& a, const Body& b)
{
	return std::min(double(a.hierarchy->asset().radius), double(b.hierarchy->asset().radius));
}
}  // namespace clod::test
