// SPDX-License-Identifier: GPL-3.0-or-later
// From a family's start to a case: the bodies are moved together until they meet.
#include "tests/oracle/Families.h"

#include <algorithm>
#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr double kTimeStep = 1.0 / 240;
constexpr int kStarts = 20, kMarch = 60, kBisections = 34;

// A centred mesh and where its centre was.
Vec3 center(TriangleMesh& mesh)
{
	const Vec3 middle = Solid(mesh).center();
	for (Vec3& v : mesh.vertices) v = toVec3(toFloat3(v - middle));
	return middle;
}

Transform translation(const Vec3& by)
{
	return {{}, by};
}

bool areApart(const Solid& a, const Solid& b, const Transform& aFromB)
{
	return Overlap(a, b, aFromB, 0).isApart();
}

// How far A goes until they meet, on the side where they are apart; negative: they do not.
double wayToTouch(const Solid& a, const Solid& b, const Transform& pose, const Start& start)
{
	const auto after = [&](double way) { return translation(-way * start.approach) * pose; };
	if (!areApart(a, b, pose)) return -1;
	double apart = 0, met = -1;
	for (int i = 1; i <= kMarch && met < 0; ++i)
	{
		const double way = start.travel * i / kMarch;
		if (areApart(a, b, after(way)))
			apart = way;
		else
			met = way;
	}
	if (met < 0) return -1;
	for (int i = 0; i < kBisections; ++i)
	{
		const double middle = 0.5 * (apart + met);
		(areApart(a, b, after(middle)) ? apart : met) = middle;
	}
	return apart;
}

RelativeMotion predicted(Random& random, const Vec3& approach, const Solid& a, double radius)
{
	const double kind = uniform(random, 0, 3);
	Vec3 linear = direction(random);
	if (kind < 1)
		linear = normalized(approach + 0.5 * linear);
	else if (kind < 2)
		linear = normalized(linear - dot(linear, approach) * approach + uniform(random, -0.05, 0.1) * approach);
	RelativeMotion motion;
	motion.timeStep = kTimeStep;
	motion.angular = (uniform(random, 0, 1) < 0.5 ? 0 : uniform(random, 0.1, 2) / a.radius()) * direction(random);
	const double size = radius * std::exp(uniform(random, std::log(2e-3), std::log(3e-2)));
	const double speed = size / kTimeStep / (1 + length(motion.angular) * a.radius());
	motion.angular = speed * motion.angular;
	motion.linear = speed * linear - cross(motion.angular, a.center());
	return motion;
}
}  // namespace

BodyPair::BodyPair(const TriangleMesh& meshA, const TriangleMesh& meshB) : a(meshA), b(meshB)
{
	offsetA = center(a);
	offsetB = center(b);
}

CaseChoice chooseCase(const Family& family, std::size_t pairs, std::uint64_t seed, std::size_t index)
{
	std::uint64_t key = seed;
	for (const char c : family.name) key = key * 1099511628211u + std::uint64_t(c);
	Random random(key * 0x9E3779B97F4A7C15u + index);
	return {index % pairs, random()};
}

std::optional<Case> makeCase(const Family& family, const BodyPair& pair, const CaseChoice& choice, const Solid& a,
							 const Solid& b)
{
	Random random(choice.seed);
	const double radius = std::min(a.radius(), b.radius());
	for (int attempt = 0; attempt < kStarts; ++attempt)
	{
		const Start start = family.start(random, choice.pair);
		const Transform pose = translation(-pair.offsetA) * start.aFromB * translation(pair.offsetB);
		const double way = wayToTouch(a, b, pose, start);
		if (way < 0) continue;
		Case made;
		const double kind = uniform(random, 0, 1), share = uniform(random, 0, 1);
		double gap = 0;
		if (family.isDeep)
			gap = -radius * std::exp(std::log(0.02) * (1 - share));
		else if (kind > 0.68)
			gap = -radius * std::exp(std::log(3e-5) + share * std::log(170.0));
		else if (kind > 0.34)
			gap = radius * std::exp(std::log(1e-5) + share * std::log(1000.0));
		made.gap = std::fabs(gap);
		made.aFromB = translation((gap - way) * start.approach) * pose;
		made.motion = predicted(random, start.approach, a, radius);
		return made;
	}
	return {};
}
}  // namespace clod::oracle
