// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/assemble/Geometry.h"

namespace clod::builder
{
ClosestPoint closestPoint(const Vec3& p, const Triangle& t)
{
	const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
	const double d1 = dot(ab, ap), d2 = dot(ac, ap);
	if (d1 <= 0 && d2 <= 0) return {t.a, Feature::vertexA};
	const Vec3 bp = p - t.b;
	const double d3 = dot(ab, bp), d4 = dot(ac, bp);
	if (d3 >= 0 && d4 <= d3) return {t.b, Feature::vertexB};
	const double vc = d1 * d4 - d3 * d2;
	if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t.a + (d1 - d3 > 0 ? d1 / (d1 - d3) : 0) * ab, Feature::edgeAB};
	const Vec3 cp = p - t.c;
	const double d5 = dot(ab, cp), d6 = dot(ac, cp);
	if (d6 >= 0 && d5 <= d6) return {t.c, Feature::vertexC};
	const double vb = d5 * d2 - d1 * d6;
	if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t.a + (d2 - d6 > 0 ? d2 / (d2 - d6) : 0) * ac, Feature::edgeCA};
	const double va = d3 * d6 - d5 * d4, along = (d4 - d3) + (d5 - d6);
	if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
		return {t.b + (along > 0 ? (d4 - d3) / along : 0) * (t.c - t.b), Feature::edgeBC};
	const double scale = 1 / (va + vb + vc);
	return {t.a + (vb * scale) * ab + (vc * scale) * ac, Feature::face};
}
}  // namespace clod::builder
