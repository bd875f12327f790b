// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Eberly, "Polyhedral Mass Properties (Revisited)".
#include "builder/assemble/MassProperties.h"

#include "builder/assemble/Geometry.h"
#include "clod/hierarchy/PrincipalAxes.h"

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
}  // namespace

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
	m.principal = quaternionOf(frame.axes);
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
