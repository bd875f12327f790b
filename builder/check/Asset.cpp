// SPDX-License-Identifier: GPL-3.0-or-later
// What belongs to the whole asset: bounds, mass properties by a second method, and equality with a given mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "builder/check/Rounding.h"
#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
Invariant bounds(const Subject& s)
{
	Tally tally("asset-bounds");
	const Asset& a = s.h.asset();
	const Vec3 center{double(a.sphereCenter[0]), double(a.sphereCenter[1]), double(a.sphereCenter[2])};
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		double excess = 0;
		for (const Vec3& p : s.thickHull(i))
		{
			for (int k = 0; k < 3; ++k)
				excess = std::max({excess, double(a.boxMin[k]) - p[k], p[k] - double(a.boxMax[k])});
			if (s.h.node(i).level == 0 && s.h.node(i).thickness == 0)
				excess = std::max(excess, length(p - center) - s.radius);
		}
		tally.add(i, excess, fmt::format("node {}: its hull leaves the asset's bounds by {:.3g}", i, excess));
	}
	Box box;
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
		for (const Vec3& p : s.thickHull(i)) box.add(p);
	bool tight = true;
	for (int k = 0; k < 3; ++k)
		tight = tight && isNextBelow(a.boxMin[k], box.low[k], 0) &&
				isNextAbove(a.boxMax[k], box.high[k], 0);
	tally.add(s.h.nodes().size, tight ? 0 : 1, "the asset's box is larger than its hulls");
	return tally.result();
}

// Integrals over the surface of x, x^2 and x^3 by the divergence theorem, with quadrature exact for cubics over each
// triangle: another route than sums over tetrahedra.
struct Moments
{
	long double volume = 0, first[3] = {}, second[3] = {}, mixed[3] = {};
	double rounding = 0;  // that the first may be off by where corners are off by half a float step
};

Moments integrate(const Subject& s)
{
	Moments m;
	// Strang and Fix's seven points would do; products of barycentric monomials are exact and shorter:
	// integral of u^a v^b w^c over a triangle = 2 area a! b! c! / (a + b + c + 2)!
	const Level& level = s.h.levels()[0];
	for (std::uint32_t f = 0; f < level.faceCount; ++f)
	{
		const Triangle t = s.triangle(level.firstFace + f);
		const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);  // 2 area * normal
		m.rounding += 0x1p-25 * length(n) * std::max({lengthSquared(t[0]), lengthSquared(t[1]), lengthSquared(t[2])});
		for (int i = 0; i < 3; ++i)
		{
			const int j = (i + 1) % 3;
			long double x[3], y[3];
			for (std::size_t k = 0; k < 3; ++k)
			{
				x[k] = static_cast<long double>(t[k][i]);
				y[k] = static_cast<long double>(t[k][j]);
			}
			const long double sum = x[0] + x[1] + x[2];
			const long double squares = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
			const long double cubes = x[0] * x[0] * x[0] + x[1] * x[1] * x[1] + x[2] * x[2] * x[2];
			const long double ySum = y[0] + y[1] + y[2];
			const long double xy = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
			const long double xxy = x[0] * x[0] * y[0] + x[1] * x[1] * y[1] + x[2] * x[2] * y[2];
			const long double ni = static_cast<long double>(n[i]);
			// h1, h2, h3: complete homogeneous sums of x; the last with one factor y.
			const long double h2 = (sum * sum + squares) / 2;
			const long double h3 = (sum * sum * sum + 3 * sum * squares + 2 * cubes) / 6;
			const long double h2y = (h2 * ySum + sum * xy + xxy);
			if (i == 0) m.volume += ni * sum / 6;
			m.first[i] += ni * h2 / 24;
			m.second[i] += ni * h3 / 60;
			m.mixed[i] += ni * h2y / 120;
		}
	}
	return m;
}

Invariant mass(const Subject& s)
{
	Tally tally("mass-properties");
	const Asset& a = s.h.asset();
	const Moments m = integrate(s);
	const double volume = double(m.volume);
	const double scale = s.radius;
	double worst = std::abs(volume - a.volume) / a.volume;
	// Of a mesh far from its frame's origin the centre is known to half a step of the numbers that tell where it is;
	// that of a sheet moves when its sides are rounded.
	double offCenter = 0, center[3];
	for (std::size_t i = 0; i < 3; ++i)
	{
		center[i] = double(m.first[i] / m.volume);
		offCenter = std::max(offCenter, std::abs(center[i]) - 0x1p-53 * std::abs(a.meshFromBody[i]));
	}
	// About the centre of mass; second: xx, yy, zz, mixed: xy, yz, zx about the origin.
	const auto second = [&](std::size_t i) { return double(m.second[i]) - volume * center[i] * center[i]; };
	const auto mixed = [&](std::size_t i) { return double(m.mixed[i]) - volume * center[i] * center[(i + 1) % 3]; };
	const double xx = second(0), yy = second(1), zz = second(2);
	const double expected[6] = {yy + zz, xx + zz, xx + yy, -mixed(0), -mixed(2), -mixed(1)};
	const double unit = std::max({expected[0], expected[1], expected[2]});
	for (int i = 0; i < 6; ++i) worst = std::max(worst, std::abs(expected[i] - a.inertia[i]) / unit);
	// In the principal frame the tensor is diagonal.
	const Mat3 frame = rotationFromQuaternion(a.principal[0], a.principal[1], a.principal[2], a.principal[3]);
	const Mat3 tensor = {{{expected[0], expected[3], expected[4]},
						  {expected[3], expected[1], expected[5]},
						  {expected[4], expected[5], expected[2]}}};
	const Mat3 turned = transposed(frame) * tensor * frame;
	double offDiagonal = 0;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			if (i != j) offDiagonal = std::max(offDiagonal, std::abs(turned.row[i][j]) / unit);
	constexpr double kTolerance = 1e-6;
	tally.add(0, worst - kTolerance, fmt::format("volume or inertia is off by {:.3g} of its value", worst));
	tally.add(1, offCenter / scale - std::max(kTolerance, m.rounding / volume / scale),
			  fmt::format("the centre of mass is {:.3g} from the origin", offCenter));
	tally.add(2, offDiagonal - kTolerance, "the principal axes do not diagonalise the inertia");
	return tally.result();
}

using Corner = std::tuple<float, float, float>;
using Polygon = std::vector<Corner>;

Corner rounded(const Vec3& p)
{
	const auto flush = [](double x)
	{
		const float value = float(x);
		return std::abs(value) < std::numeric_limits<float>::min() ? 0.0f : value;
	};
	return {flush(p.x), flush(p.y), flush(p.z)};
}

Polygon fromLowest(Polygon corners)
{
	std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
	return corners;
}

// Triangles of the mesh must be faces of level 0; the faces left over must tile the mesh's larger polygons.
Invariant equalsGiven(const Subject& s, const GivenMesh& given)
{
	Tally tally("equals-mesh");
	const double* const shift = s.h.asset().meshFromBody;
	const Vec3 meshFromBody{shift[0], shift[1], shift[2]};
	std::multiset<Polygon> stored;
	const Level& level = s.h.levels()[0];
	for (std::uint32_t f = 0; f < level.faceCount; ++f)
	{
		const Triangle t = s.triangle(level.firstFace + f);
		stored.insert(fromLowest({rounded(t[0]), rounded(t[1]), rounded(t[2])}));
	}
	std::size_t expected = 0;
	std::vector<std::set<Corner>> larger;
	for (std::size_t p = 0; p < given.polygons.size(); ++p)
	{
		Polygon corners;
		for (const std::uint32_t v : given.polygons[p])
			corners.push_back(v < given.vertices.size() ? rounded(given.vertices[v] - meshFromBody) : Corner{});
		expected += corners.size() - 2;
		if (corners.size() > 3)
		{
			larger.emplace_back(corners.begin(), corners.end());
			continue;
		}
		const auto found = stored.find(fromLowest(corners));
		tally.add(p, found == stored.end() ? 1 : 0, fmt::format("face {} of the mesh is not in level 0", p));
		if (found != stored.end()) stored.erase(found);
	}
	tally.add(given.polygons.size(), expected == level.faceCount ? 0 : 1,
			  fmt::format("the mesh has {} triangles, level 0 {}", expected, level.faceCount));
	std::map<Corner, std::vector<std::size_t>> polygonsAt;
	for (std::size_t p = 0; p < larger.size(); ++p)
		for (const Corner& c : larger[p]) polygonsAt[c].push_back(p);
	std::uint64_t element = given.polygons.size();
	for (const Polygon& t : stored)
	{
		bool inside = false;
		for (const std::size_t p : polygonsAt[t[0]])
			inside = inside || (larger[p].count(t[1]) > 0 && larger[p].count(t[2]) > 0);
		tally.add(++element, inside ? 0 : 1, "a face of level 0 belongs to no face of the mesh");
	}
	return tally.result();
}
}  // namespace

Invariants checkAsset(const Subject& s)
{
	return {bounds(s), mass(s)};
}

Invariants checkGiven(const Subject& s)
{
	if (s.options.given == nullptr) return {};
	return {equalsGiven(s, *s.options.given)};
}
}  // namespace clod::check
