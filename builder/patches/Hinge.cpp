// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Guskov et al. 1999, sec. 3 (relaxation operator), in a closed form without signed areas.
#include "builder/patches/Hinge.h"

namespace clod::builder
{
std::optional<HingeWeights> hingeWeights(const Vec3& j, const Vec3& k, const Vec3& l1, const Vec3& l2,
										 double minimumLength)
{
	const double edge = length(k - j);
	if (edge < minimumLength) return {};
	const Vec3 along = (1 / edge) * (k - j);
	const double x1 = dot(l1 - j, along), x2 = dot(l2 - j, along);
	const double y1 = length(l1 - j - x1 * along), y2 = length(l2 - j - x2 * along);
	if (y1 < minimumLength || y2 < minimumLength) return {};
	const double t1 = x1 / edge, t2 = x2 / edge;
	return HingeWeights{1 / y1, 1 / y2, -((1 - t1) / y1 + (1 - t2) / y2), -(t1 / y1 + t2 / y2)};
}

Vec3 filteredPosition(const Vec3& centre, const Star& star, double minimumLength)
{
	const std::size_t n = star.ring.size();
	Vec3 weighted;
	double squares = 0;
	const auto add = [&](double own, const Vec3& others)
	{
		weighted += own * others;
		squares += own * own;
	};
	for (std::size_t i = 0; i < n; ++i)
	{
		const Vec3 &p = star.ring[i], &next = star.ring[(i + 1) % n], &previous = star.ring[(i + n - 1) % n];
		if (const auto c = hingeWeights(centre, p, next, previous, minimumLength))
			add(c->j, c->k * p + c->l1 * next + c->l2 * previous);
		if (const auto c = hingeWeights(p, next, centre, star.beyond[i], minimumLength))
			add(c->l1, c->j * p + c->k * next + c->l2 * star.beyond[i]);
	}
	return squares > 0 ? (-1 / squares) * weighted : centre;
}
}  // namespace clod::builder
