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
constexpr int kStarts = 20, kBlocks = 30, kSteps = 2, kBisections = 34;

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

// How far A goes until they meet, on the side where they are apart; negative: they do not, or overlap already.
double wayToTouch(const Solid& a, const Solid& b, const Transform& pose, const Start& start)
{
	const double block = start.travel / kBlocks, step = block / kSteps;
	for (int i = 0; i < kBlocks; ++i)
	{
		Overlap overlap(a, b, translation(-i * block * start.approach) * pose, block);
		if (i == 0 && !overlap.isApart()) return -1;
		const auto isApart = [&](double way) { return !overlap.isAny(translation(way * start.approach), way); };
		int met = 1;
		while (met <= kSteps && isApart(met * step)) ++met;
		if (met > kSteps) continue;
		double apart = (met - 1) * step, touching = met * step;
		for (int k = 0; k < kBisections; ++k)
		{
			const double middle = 0.5 * (apart + touching);
			(isApart(middle) ? apart : touching) = middle;
		}
		return i * block + apart;
	}
	return -1;
}

// Of any size: linear about 1 at the centre, turning as fast as the body is large.
RelativeMotion anyMotion(Random& random, const Vec3& approach, const Solid& a)
{
	const double kind = uniform(random, 0, 3);
	Vec3 linear = direction(random);
	if (kind < 1)
		linear = normalized(approach + 0.5 * linear);
	else if (kind < 2)
		linear = normalized(linear - dot(linear, approach) * approach + uniform(random, -0.05, 0.1) * approach);
	RelativeMotion motion;
	const Vec3 axis = direction(random);  // operands are evaluated in the order that the compiler likes
	motion.angular = (uniform(random, 0, 1) < 0.5 ? 0 : uniform(random, 0.1, 2) / a.radius()) * axis;
	motion.linear = linear - cross(motion.angular, a.center());
	return motion;
}

RelativeMotion alongCourse(Random& random, const Start& start, const Vec3& offset, const Solid& a)
{
	RelativeMotion motion{start.course.velocity(offset), start.course.angular, 0};
	const double sign = uniform(random, 0, 1) < 0.5 ? -1 : 1;
	const double scale = sign / (length(motion.velocity(a.center())) + length(motion.angular) * a.radius());
	motion.linear = scale * motion.linear + uniform(random, 0, 0.1) * direction(random);
	motion.angular = scale * motion.angular;
	return motion;
}

RelativeMotion predicted(Random& random, const Start& start, const Vec3& offset, const Solid& a, double radius)
{
	const bool hasCourse = lengthSquared(start.course.angular) + lengthSquared(start.course.linear) > 0;
	RelativeMotion motion = hasCourse && uniform(random, 0, 1) < 0.5 ? alongCourse(random, start, offset, a)
																	 : anyMotion(random, start.approach, a);
	const double size = radius * std::exp(uniform(random, std::log(2e-3), std::log(3e-2))) / kTimeStep;
	const double scale = size / (length(motion.velocity(a.center())) + length(motion.angular) * a.radius());
	return {scale * motion.linear, scale * motion.angular, kTimeStep};
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
		made.motion = predicted(random, start, pair.offsetA, a, radius);
		return made;
	}
	return {};
}
}  // namespace clod::oracle
