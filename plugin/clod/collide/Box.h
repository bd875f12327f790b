// SPDX-License-Identifier: Zlib
// A box along the axes.
#pragma once
#include <algorithm>
#include <limits>

#include "clod/collide/Vector.h"

namespace clod
{
struct Box
{
	Vec3 low, high;
	static Box none()
	{
		constexpr double kFar = std::numeric_limits<double>::infinity();
		return {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
	}
	void add(const Vec3& p)
	{
		low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
		high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
	}
	void add(const Box& box)
	{
		add(box.low);
		add(box.high);
	}
	double squaredTo(const Box& other) const
	{
		const auto out = [](double l, double h, double otherLow, double otherHigh)
		{ return std::max(0.0, std::max(otherLow - h, l - otherHigh)); };
		return lengthSquared({out(low.x, high.x, other.low.x, other.high.x), out(low.y, high.y, other.low.y, other.high.y),
							  out(low.z, high.z, other.low.z, other.high.z)});
	}
	bool meets(const Box& other) const
	{
		return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y &&
			   low.z <= other.high.z && other.low.z <= high.z;
	}
	bool meets(const Box& other, double reach) const
	{
		return low.x <= other.high.x + reach && other.low.x <= high.x + reach && low.y <= other.high.y + reach &&
			   other.low.y <= high.y + reach && low.z <= other.high.z + reach && other.low.z <= high.z + reach;
	}
};
}  // namespace clod
