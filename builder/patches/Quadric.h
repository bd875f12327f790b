// SPDX-License-Identifier: GPL-3.0-or-later
// Sum of squared distances to planes, weighted by area, and its minimiser.
// Sources: M. Garland, P. Heckbert, Surface Simplification Using Quadric Error Metrics, SIGGRAPH 1997; P. Trettner,
// L. Kobbelt, Fast and Robust QEF Minimization using Probabilistic Quadrics, Eurographics 2020.
#pragma once
#include "builder/patches/Orientation.h"

namespace clod::builder
{
class Quadric
{
public:
	// The expected squared distance where each component of the unit normal has this variance and the plane turns about
	// the triangle's middle. 0: the plane as it is.
	void addTriangle(const Vec3& a, const Vec3& b, const Vec3& c, double normalVariance = 0);
	Quadric& operator+=(const Quadric& other);
	// Squared error at x, in area times length squared.
	double at(const Vec3& x) const;
	// Of the triangles added without variance.
	double area() const { return m_xx + m_yy + m_zz; }
	// Minimiser nearest to start: directions whose eigenvalue is below 1e-3 of the largest stay at start.
	Vec3 minimiser(const Vec3& start) const;

private:
	double m_xx = 0, m_xy = 0, m_xz = 0, m_yy = 0, m_yz = 0, m_zz = 0;
	Vec3 m_linear;
	double m_constant = 0;
	Vec3 gradientHalf(const Vec3& x) const;
};
}  // namespace clod::builder
