// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Shewchuk 1997 (two-sum, two-product, expansion sums and scaling with zero elimination; error bound
// o3derrboundA).
#include "builder/patches/Orientation.h"

#include <vector>

namespace clod::builder
{
namespace
{
// A sum of doubles that do not overlap, in increasing magnitude: an exact number.
using Expansion = std::vector<double>;

void twoSum(double a, double b, double& sum, double& error)
{
	sum = a + b;
	const double bVirtual = sum - a;
	error = (a - (sum - bVirtual)) + (b - bVirtual);
}

void twoProduct(double a, double b, double& product, double& error)
{
	product = a * b;
	error = std::fma(a, b, -product);
}

// Adds one double to an expansion.
Expansion grow(const Expansion& e, double b)
{
	Expansion result;
	double carry = b;
	for (const double component : e)
	{
		double sum, error;
		twoSum(carry, component, sum, error);
		if (error != 0) result.push_back(error);
		carry = sum;
	}
	if (carry != 0) result.push_back(carry);
	return result;
}

Expansion sum(const Expansion& a, const Expansion& b)
{
	Expansion result = a;
	for (const double component : b) result = grow(result, component);
	return result;
}

Expansion product(const Expansion& a, const Expansion& b)
{
	Expansion result;
	for (const double x : a)
		for (const double y : b)
		{
			double high, low;
			twoProduct(x, y, high, low);
			result = grow(grow(result, low), high);
		}
	return result;
}

Expansion negated(Expansion e)
{
	for (double& component : e) component = -component;
	return e;
}

Expansion difference(double a, double b)
{
	return grow(a != 0 ? Expansion{a} : Expansion{}, -b);
}

int exactOrientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
	Expansion m[3][3];
	const Vec3* corner[3] = {&a, &b, &c};
	for (int i = 0; i < 3; ++i)
		for (int k = 0; k < 3; ++k) m[i][k] = difference((*corner[i])[k], d[k]);
	Expansion determinant;
	for (int i = 0; i < 3; ++i)
	{
		const Expansion* p = m[(i + 1) % 3];
		const Expansion* q = m[(i + 2) % 3];
		const Expansion minor = sum(product(p[1], q[2]), negated(product(p[2], q[1])));
		determinant = sum(determinant, product(m[i][0], minor));
	}
	if (determinant.empty()) return 0;
	return determinant.back() > 0 ? -1 : 1;
}
}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
	const Vec3 ad = a - d, bd = b - d, cd = c - d;
	const double bc = bd.y * cd.z, cb = bd.z * cd.y;
	const double ca = cd.y * ad.z, ac = cd.z * ad.y;
	const double ab = ad.y * bd.z, ba = ad.z * bd.y;
	const double determinant = ad.x * (bc - cb) + bd.x * (ca - ac) + cd.x * (ab - ba);
	const double magnitude = (std::fabs(bc) + std::fabs(cb)) * std::fabs(ad.x) +
							 (std::fabs(ca) + std::fabs(ac)) * std::fabs(bd.x) +
							 (std::fabs(ab) + std::fabs(ba)) * std::fabs(cd.x);
	const double bound = 7.7715611723761027e-16 * magnitude;
	if (determinant > bound) return -1;
	if (determinant < -bound) return 1;
	return magnitude == 0 ? 0 : exactOrientation(a, b, c, d);
}
}  // namespace clod::builder
