// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Motions.h"

#include <algorithm>
#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr int kSweeps = 400;
constexpr double kSettled = 1e-7;  // share of the motion that a sweep changes at most, at the end
constexpr double kPi = 3.14159265358979323846;

Mat3 inverseOf(const Mat3& m)
{
	const Vec3 x = cross(m.row[1], m.row[2]), y = cross(m.row[2], m.row[0]), z = cross(m.row[0], m.row[1]);
	const double scale = 1 / dot(m.row[0], x);
	return transposed({{scale * x, scale * y, scale * z}});
}

// Adds the response (velocity at the frame's origin, turning) to each unit wrench (force, moment about the origin).
void addInverseMass(double (&w)[6][6], double mass, const Vec3& center, const Mat3& inertia)
{
	const Mat3 inverseInertia = inverseOf(inertia);
	for (int k = 0; k < 6; ++k)
	{
		Vec3 force, moment;
		(k < 3 ? force : moment)[k % 3] = 1;
		const Vec3 turning = inverseInertia * (moment - cross(center, force));
		const Vec3 linear = (1 / mass) * force - cross(turning, center);
		for (int i = 0; i < 3; ++i)
		{
			w[i][k] += linear[i];
			w[i + 3][k] += turning[i];
		}
	}
}

// Faults of the best offset for this direction; all y.
int faultsAlong(const std::vector<Labelled>& motions, const Vec6& direction, double share)
{
	// Admitted above b: a deep one at h is a fault while b <= h; a free one while b > h + share |y|.
	std::vector<std::pair<double, int>> events;
	int faults = 0;
	for (const Labelled& motion : motions)
	{
		const double h = dot(direction, motion.y);
		if (motion.isDeep)
		{
			++faults;
			events.push_back({h, -1});
		}
		else if (motion.isFree)
			events.push_back({h + share * length(motion.y), 1});
	}
	std::sort(events.begin(), events.end());
	int best = faults;
	for (const auto& event : events) best = std::min(best, faults += event.second);
	return best;
}
}  // namespace

double uniform(Random& random, double low, double high)
{
	return low + (high - low) * double(random() >> 11) * 0x1p-53;
}

double normal(Random& random)
{
	const double u = uniform(random, 1e-12, 1), v = uniform(random, 0, 2 * kPi);
	return std::sqrt(-2 * std::log(u)) * std::cos(v);
}

Vec3 direction(Random& random)
{
	const double x = normal(random), y = normal(random), z = normal(random);
	return normalized(Vec3{x, y, z});
}

Mat3 rotation(Random& random, double largestAngle)
{
	const Vec3 axis = direction(random);
	const double half = 0.5 * uniform(random, 0, largestAngle), s = std::sin(half);
	return rotationFromQuaternion(s * axis.x, s * axis.y, s * axis.z, std::cos(half));
}

double dot(const Vec6& a, const Vec6& b)
{
	double sum = 0;
	for (std::size_t i = 0; i < 6; ++i) sum += a[i] * b[i];
	return sum;
}

double length(const Vec6& a)
{
	return std::sqrt(dot(a, a));
}

Vec6 operator+(const Vec6& a, const Vec6& b)
{
	Vec6 sum;
	for (std::size_t i = 0; i < 6; ++i) sum[i] = a[i] + b[i];
	return sum;
}

Vec6 operator*(double s, const Vec6& a)
{
	Vec6 product;
	for (std::size_t i = 0; i < 6; ++i) product[i] = s * a[i];
	return product;
}

MotionSpace::MotionSpace(const Solid& a, const Solid& b, const Transform& aFromB)
{
	double w[6][6] = {};
	addInverseMass(w, a.volume(), a.center(), a.inertia());
	const Mat3 inertiaOfB = aFromB.rotation * b.inertia() * transposed(aFromB.rotation);
	addInverseMass(w, b.volume(), aFromB * b.center(), inertiaOfB);
	for (int i = 0; i < 6; ++i)
		for (int k = 0; k <= i; ++k)
		{
			double sum = w[i][k];
			for (int j = 0; j < k; ++j) sum -= m_root[i][j] * m_root[k][j];
			m_root[i][k] = i == k ? std::sqrt(sum) : sum / m_root[k][k];
		}
}

Vec6 MotionSpace::coordinates(const RelativeMotion& motion) const
{
	Vec6 y;
	for (int i = 0; i < 6; ++i)
	{
		double sum = i < 3 ? motion.linear[i] : motion.angular[i - 3];
		for (int k = 0; k < i; ++k) sum -= m_root[i][k] * y[std::size_t(k)];
		y[std::size_t(i)] = sum / m_root[i][i];
	}
	return y;
}

RelativeMotion MotionSpace::motion(const Vec6& y, double timeStep) const
{
	RelativeMotion motion;
	motion.timeStep = timeStep;
	for (int i = 0; i < 6; ++i)
		for (int k = 0; k <= i; ++k)
			(i < 3 ? motion.linear : motion.angular)[i % 3] += m_root[i][k] * y[std::size_t(k)];
	return motion;
}

Vec6 MotionSpace::gradient(const Vec3& point, const Vec3& n) const
{
	const Vec3 moment = cross(point, n);
	Vec6 g{};
	for (int k = 0; k < 6; ++k)
		for (int i = k; i < 6; ++i) g[std::size_t(k)] += m_root[i][k] * (i < 3 ? n : moment)[i % 3];
	return g;
}

Vec6 withinCone(Random& random, const Vec6& axis, double angle, double scale)
{
	Vec6 side;
	for (double& x : side) x = normal(random);
	const double size = length(axis);
	if (size == 0) return axis;
	side = side + (-dot(side, axis) / (size * size)) * axis;
	// Area of the sphere's zones in six dimensions grows as the angle's fifth power.
	const double theta = angle * std::pow(uniform(random, 0, 1), 0.2);
	return (scale * std::cos(theta)) * axis + (scale * std::sin(theta) * size / length(side)) * side;
}

Vec6 leastChange(const std::vector<HalfSpace>& set, const Vec6& y)
{
	Vec6 now = y;
	std::vector<double> force(set.size(), 0.0);
	for (int sweep = 0; sweep < kSweeps; ++sweep)
	{
		double changed = 0;
		for (std::size_t i = 0; i < set.size(); ++i)
		{
			const double size = dot(set[i].gradient, set[i].gradient);
			if (size == 0) continue;
			const double wanted = force[i] - (dot(set[i].gradient, now) + set[i].offset) / size;
			const double step = std::max(0.0, wanted) - force[i];
			force[i] += step;
			now = now + step * set[i].gradient;
			changed = std::max(changed, std::fabs(step) * std::sqrt(size));
		}
		if (changed <= kSettled * length(y)) break;
	}
	return now;
}

bool admits(const std::vector<HalfSpace>& set, const Vec6& y, double slack)
{
	for (const HalfSpace& half : set)
		if (dot(half.gradient, y) + half.offset < -slack) return false;
	return true;
}

int bestHalfSpaceFaults(const std::vector<Labelled>& motions, double share, Random& random)
{
	Vec6 start{};
	double size = 0;
	int deep = 0, free = 0;
	for (const Labelled& motion : motions)
	{
		deep += motion.isDeep;
		free += motion.isFree;
		size = std::max(size, length(motion.y));
	}
	if (deep == 0 || free == 0) return 0;
	Vec6 means[2] = {};
	for (const Labelled& motion : motions)
	{
		if (motion.isFree) means[1] = means[1] + (1.0 / free) * motion.y;
		if (motion.isDeep) means[0] = means[0] + (1.0 / deep) * motion.y;
	}
	start = means[1] + (-1.0) * means[0];
	int best = std::min(deep, free);
	for (int attempt = 0; attempt < 6 && best > 0; ++attempt)
	{
		Vec6 w = start;
		if (attempt > 0)
			for (double& x : w) x += 0.5 * length(start) * normal(random) / std::sqrt(6.0);
		double offset = -0.5 * dot(w, means[0] + means[1]);
		for (int pass = 0; pass < 40 && best > 0; ++pass)
		{
			const double rate = 0.2 * length(w) / (1 + pass);
			for (const Labelled& motion : motions)
			{
				if (!motion.isDeep && !motion.isFree) continue;
				const double side = dot(w, motion.y) + offset;
				if ((side >= 0) == motion.isFree) continue;
				const double sign = motion.isFree ? 1 : -1;
				w = w + (sign * rate / size) * motion.y;
				offset += sign * rate * size;
			}
			if (length(w) == 0) break;
			if (pass % 4 == 3) best = std::min(best, faultsAlong(motions, (1 / length(w)) * w, share));
		}
	}
	return best;
}
}  // namespace clod::oracle
