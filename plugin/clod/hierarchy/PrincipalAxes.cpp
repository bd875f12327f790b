// SPDX-License-Identifier: Zlib
// Source: Golub & Van Loan, Matrix Computations, sec. 8.5 (Jacobi).
#include "clod/hierarchy/PrincipalAxes.h"

#include <cmath>
#include <utility>

namespace clod
{
namespace
{
// One Jacobi rotation that zeroes a[p][q]; v collects the eigenvectors as columns.
void rotate(double a[3][3], double v[3][3], int p, int q)
{
	if (a[p][q] == 0) return;
	const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
	const double t = (theta >= 0 ? 1 : -1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
	const double c = 1 / std::sqrt(t * t + 1), s = t * c;
	for (int k = 0; k < 3; ++k)
	{
		const double x = a[k][p], y = a[k][q];
		a[k][p] = c * x - s * y;
		a[k][q] = s * x + c * y;
	}
	for (int k = 0; k < 3; ++k)
	{
		const double x = a[p][k], y = a[q][k];
		a[p][k] = c * x - s * y;
		a[q][k] = s * x + c * y;
		const double vx = v[k][p], vy = v[k][q];
		v[k][p] = c * vx - s * vy;
		v[k][q] = s * vx + c * vy;
	}
}
}  // namespace

EigenFrame eigenFrame(const std::array<double, 6>& s)
{
	double a[3][3] = {{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}};
	double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	for (int sweep = 0; sweep < 40; ++sweep)
	{
		rotate(a, v, 0, 1);
		rotate(a, v, 0, 2);
		rotate(a, v, 1, 2);
	}
	int order[3] = {0, 1, 2};
	for (int i : {0, 1, 0})
		if (a[order[i]][order[i]] > a[order[i + 1]][order[i + 1]]) std::swap(order[i], order[i + 1]);
	EigenFrame frame;
	for (int i = 0; i < 3; ++i)
	{
		frame.values[std::size_t(i)] = a[order[i]][order[i]];
		frame.axes.row[i] = {v[0][order[i]], v[1][order[i]], v[2][order[i]]};
	}
	if (dot(cross(frame.axes.row[0], frame.axes.row[1]), frame.axes.row[2]) < 0) frame.axes.row[2] = -frame.axes.row[2];
	return frame;
}

std::array<double, 4> quaternionOf(const Mat3& rows)
{
	const Mat3 m = transposed(rows);
	const double d[4] = {m.row[0].x - m.row[1].y - m.row[2].z, m.row[1].y - m.row[0].x - m.row[2].z,
						 m.row[2].z - m.row[0].x - m.row[1].y, m.row[0].x + m.row[1].y + m.row[2].z};
	int largest = 0;
	for (int i = 1; i < 4; ++i)
		if (d[i] > d[largest]) largest = i;
	const double r01 = m.row[0].y, r10 = m.row[1].x, r02 = m.row[0].z, r20 = m.row[2].x, r12 = m.row[1].z,
				 r21 = m.row[2].y;
	const double f = std::sqrt(1 + d[largest]);
	const double h = 0.5 / f;
	std::array<double, 4> q{};
	if (largest == 0) q = {0.5 * f, (r01 + r10) * h, (r02 + r20) * h, (r21 - r12) * h};
	if (largest == 1) q = {(r01 + r10) * h, 0.5 * f, (r12 + r21) * h, (r02 - r20) * h};
	if (largest == 2) q = {(r02 + r20) * h, (r12 + r21) * h, 0.5 * f, (r10 - r01) * h};
	if (largest == 3) q = {(r21 - r12) * h, (r02 - r20) * h, (r10 - r01) * h, 0.5 * f};
	const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	for (double& x : q) x /= n;
	return q;
}
}  // namespace clod
