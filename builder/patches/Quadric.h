// SPDX-License-Identifier: GPL-3.0-or-later
// Sum of squared distances to planes, weighted by area, and its minimiser.
// Source: M. Garland, P. Heckbert, Surface Simplification Using Quadric Error Metrics, SIGGRAPH 1997.
#pragma once
#include "builder/patches/Orientation.h"

namespace clod::builder
{
class Quadric
{
public:
	void addTriangle(const Vec3& a, const Vec3& b, const Vec3& c);
	Quadric& operator+=(const Quadric& other);
	// Squared error at x, in area times length squared.
	double at(const Vec3& x) const;
	// Minimiser nearest to start: directions whose eigenvalue is below 1e-3 of the largest stay at start.
	Vec3 minimiser(const Vec3& start) const;

private:
	double m_xx = 0, m_xy = 0, m_xz = 0, m_yy = 0, m_yz = 0, m_zz = 0;
	Vec3 m_linear;
	double m_constant = 0;
	Vec3 gradientHalf(const Vec3& x) const;
};
}  // namespace clod::builder
