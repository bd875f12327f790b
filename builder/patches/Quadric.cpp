// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Garland & Heckbert 1997; truncated eigen-decomposition so that flat and cylindrical surroundings stay put.
#include "builder/patches/Quadric.h"

#include <Eigen/Eigenvalues>

namespace clod::builder
{
void Quadric::addTriangle(const Vec3& a, const Vec3& b, const Vec3& c, double normalVariance)
{
	const Vec3 scaled = cross(b - a, c - a);
	const double area = 0.5 * length(scaled);
	const Plane plane = planeOf(a, b, c);
	const Vec3& n = plane.normal;
	m_xx += area * n.x * n.x;
	m_xy += area * n.x * n.y;
	m_xz += area * n.x * n.z;
	m_yy += area * n.y * n.y;
	m_yz += area * n.y * n.z;
	m_zz += area * n.z * n.z;
	m_linear += (-area * plane.offset) * n;
	m_constant += area * plane.offset * plane.offset;
	if (normalVariance <= 0) return;
	const double weight = area * normalVariance;
	const Vec3 middle = (1.0 / 3) * (a + b + c);
	m_xx += weight;
	m_yy += weight;
	m_zz += weight;
	m_linear -= weight * middle;
	m_constant += weight * dot(middle, middle);
}

Quadric& Quadric::operator+=(const Quadric& other)
{
	m_xx += other.m_xx;
	m_xy += other.m_xy;
	m_xz += other.m_xz;
	m_yy += other.m_yy;
	m_yz += other.m_yz;
	m_zz += other.m_zz;
	m_linear += other.m_linear;
	m_constant += other.m_constant;
	return *this;
}

Vec3 Quadric::gradientHalf(const Vec3& x) const
{
	return Vec3{m_xx * x.x + m_xy * x.y + m_xz * x.z, m_xy * x.x + m_yy * x.y + m_yz * x.z,
				m_xz * x.x + m_yz * x.y + m_zz * x.z} +
		   m_linear;
}

double Quadric::at(const Vec3& x) const
{
	return std::fmax(0.0, dot(x, gradientHalf(x)) + dot(m_linear, x) + m_constant);
}

Vec3 Quadric::minimiser(const Vec3& start) const
{
	Eigen::Matrix3d matrix;
	matrix << m_xx, m_xy, m_xz, m_xy, m_yy, m_yz, m_xz, m_yz, m_zz;
	const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
	const Vec3 slope = gradientHalf(start);
	const double smallest = 1e-3 * solver.eigenvalues()(2);
	Vec3 result = start;
	for (int i = 0; i < 3; ++i)
	{
		const double eigenvalue = solver.eigenvalues()(i);
		if (eigenvalue <= smallest || eigenvalue <= 0) continue;
		const Vec3 axis{solver.eigenvectors()(0, i), solver.eigenvectors()(1, i), solver.eigenvectors()(2, i)};
		result -= (dot(axis, slope) / eigenvalue) * axis;
	}
	return result;
}
}  // namespace clod::builder
