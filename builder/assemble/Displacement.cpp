// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Displacement.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
constexpr double kSlack = 1e-13;  // of the radius

double largest(const Displacement& d, const std::vector<Vec3>& points)
{
	double most = 0;
	for (const Vec3& p : points) most = std::max(most, length(d.at(p)));
	return most;
}

}  // namespace

bool meetsInterior(const Triangle& t, const std::vector<HalfSpace>& planes, double slack)
{
	static thread_local std::size_t last = 0;  // plane that separated: neighbours mostly share it
	const auto isAbove = [&](const HalfSpace& plane) {
		return std::min({dot(plane.normal, t.a), dot(plane.normal, t.b), dot(plane.normal, t.c)}) >
			   plane.offset + slack;
	};
	if (last < planes.size() && isAbove(planes[last])) return false;
	for (const HalfSpace& plane : planes)
		if (isAbove(plane))
		{
			last = std::size_t(&plane - planes.data());
			return false;
		}
	static thread_local std::vector<Vec3> polygon, next;
	static thread_local std::vector<double> height;
	polygon.assign({t.a, t.b, t.c});
	for (const HalfSpace& plane : planes)
	{
		height.clear();
		for (const Vec3& p : polygon) height.push_back(dot(plane.normal, p) - plane.offset - slack);
		if (std::all_of(height.begin(), height.end(), [](double h) { return h <= 0; })) continue;
		next.clear();
		for (std::size_t i = 0; i < polygon.size(); ++i)
		{
			const std::size_t k = i + 1 < polygon.size() ? i + 1 : 0;
			const Vec3 &p = polygon[i], &q = polygon[k];
			const double a = height[i], b = height[k];
			if (a <= 0) next.push_back(p);
			if ((a <= 0) != (b <= 0)) next.push_back(p + (a / (a - b)) * (q - p));
		}
		polygon.swap(next);
		if (polygon.empty()) return false;
	}
	return true;
}

double Cell::needed(const Displacement& displacement, double start, double limit)
{
	constexpr double kStep = 1.15;
	const double speed = largest(displacement, m_shape.corners);
	if (speed <= 0) return std::numeric_limits<double>::infinity();
	double amount = start;
	gather(limit);
	for (bool clear = false; !clear;)
	{
		clear = true;
		std::vector<HalfSpace> planes = moved(displacement, amount / speed);
		for (const Triangle& t : m_near)
			while (meetsInterior(t, planes, kSlack * m_scale.radius))
			{
				clear = false;
				amount *= kStep;
				if (amount > limit) return std::numeric_limits<double>::infinity();
				planes = moved(displacement, amount / speed);
			}
	}
	const Vec3 inside = m_center + (amount / speed) * displacement.at(m_center);
	return m_solid.signedDistance(inside) < 0 ? amount : std::numeric_limits<double>::infinity();
}

std::vector<HalfSpace> Cell::moved(const Displacement& d, double amount) const
{
	std::vector<HalfSpace> planes = m_shape.planes;
	for (HalfSpace& p : planes)
		p.offset += amount * (dot(p.normal, d.shift) + d.pull * (dot(p.normal, d.center) - p.offset));
	return planes;
}

void Cell::gather(double limit)
{
	if (limit <= m_gathered) return;
	m_gathered = limit;
	m_near.clear();
	AxisBox box;
	for (const Vec3& p : m_shape.corners) box.add(p);
	box.low = box.low - Vec3{limit, limit, limit};
	box.high = box.high + Vec3{limit, limit, limit};
	m_solid.tree().forEachIn(box,
							 [this](std::uint32_t i)
							 {
								 m_near.push_back(m_solid.tree().triangle(i));
								 return true;
							 });
}

double byDisplacement(Cell& cell, const std::vector<Vec3>& normals, double start, double limit)
{
	Vec3 inward;
	for (const Vec3& n : normals) inward -= n;
	inward = normalized(inward);
	double best = std::numeric_limits<double>::infinity();
	for (double pull : {0.1, 0.5, 2.0})
	{
		if (inward == Vec3{} || cell.radius() <= 0) break;
		best = std::min(best, cell.needed({inward, pull / cell.radius(), cell.center()}, start, std::min(limit, best)));
		if (best <= 1.4 * start) return best;
	}
	if (cell.radius() > 0)
		best = std::min(best, cell.needed({Vec3{}, 1 / cell.radius(), cell.center()}, start, std::min(limit, best)));
	return best;
}
}  // namespace clod::builder
