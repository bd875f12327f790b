// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Eberly, "Polyhedral Mass Properties (Revisited)"; Golub & Van Loan, sec. 8.5 (Jacobi).
#include "builder/assemble/MassProperties.h"

#include <utility>

#include "builder/assemble/Geometry.h"

namespace clod::builder
{
namespace
{
Vec3 boxCenter(const Mesh& mesh)
{
	AxisBox box;
	for (const Vec3& v : mesh.vertices) box.add(v);
	return 0.5 * (box.low + box.high);
}

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

// Quaternion of the rotation whose matrix has the given columns (Shepperd's method).
std::array<double, 4> quaternion(const Mat3& rows)
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

MassProperties massProperties(const Mesh& mesh)
{
	const Vec3 origin = boxCenter(mesh);
	double volume6 = 0;
	Vec3 first;                      // 24 times the integral of x
	std::array<double, 6> second{};  // 120 times the integral of xx, yy, zz, xy, xz, yz
	constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
	for (const auto& t : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin, c = mesh.vertices[t[2]] - origin;
		const double det = dot(a, cross(b, c));
		const Vec3 sum = a + b + c;
		volume6 += det;
		first += det * sum;
		for (std::size_t k = 0; k < 6; ++k)
		{
			const int i = kPairs[k][0], j = kPairs[k][1];
			second[k] += det * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j]);
		}
	}
	MassProperties m;
	m.volume = volume6 / 6;
	if (!(m.volume > 0)) return m;
	const Vec3 center = (1 / (4 * volume6)) * first;
	m.center = origin + center;
	std::array<double, 6> moment{};
	for (std::size_t k = 0; k < 6; ++k)
		moment[k] = second[k] / 120 - m.volume * center[kPairs[k][0]] * center[kPairs[k][1]];
	m.inertia = {
		moment[1] + moment[2], moment[0] + moment[2], moment[0] + moment[1], -moment[3], -moment[4], -moment[5]};
	const EigenFrame frame = eigenFrame(m.inertia);
	m.moments = frame.values;
	m.principal = quaternion(frame.axes);
	return m;
}

Mat3 principalAxes(const std::vector<Vec3>& points)
{
	Vec3 mean;
	for (const Vec3& p : points) mean += (1.0 / double(points.size())) * p;
	std::array<double, 6> s{};
	for (const Vec3& p : points)
	{
		const Vec3 d = p - mean;
		s[0] += d.x * d.x, s[1] += d.y * d.y, s[2] += d.z * d.z;
		s[3] += d.x * d.y, s[4] += d.x * d.z, s[5] += d.y * d.z;
	}
	return eigenFrame(s).axes;
}
}  // namespace clod::builder
