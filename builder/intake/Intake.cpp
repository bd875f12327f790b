// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/Intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "builder/intake/ReadMesh.h"

namespace clod::builder
{
namespace
{
// A volume below this share of extent times surface is rounding.
constexpr double kLeastVolume = 1e-12;

struct Box
{
	Vec3 low, high;
	Vec3 center() const { return 0.5 * low + 0.5 * high; }
	double extent() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

Box boundsOf(const std::vector<Vec3>& vertices)
{
	Box box{vertices.front(), vertices.front()};
	for (const Vec3& v : vertices)
		for (int i = 0; i < 3; ++i)
		{
			box.low[i] = std::min(box.low[i], v[i]);
			box.high[i] = std::max(box.high[i], v[i]);
		}
	return box;
}

// Volume integrals relative to the box centre, so that a far origin costs no digits.
Vec3 centerOfMass(const WeldedMesh& mesh, const Box& box)
{
	const Vec3 origin = box.center();
	double volume = 0, area = 0;
	Vec3 moment;
	for (const auto& t : mesh.triangles)
	{
		const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin, c = mesh.vertices[t[2]] - origin;
		const double sixfold = dot(a, cross(b, c));
		volume += sixfold;
		area += 0.5 * length(cross(b - a, c - a));
		moment += sixfold * (a + b + c);
	}
	if (std::abs(volume) <= 6 * kLeastVolume * box.extent() * area)
		throw Refused(Reason::zeroVolume, fmt::format("the mesh encloses a volume of {}", volume / 6));
	if (volume < 0)
		throw Refused(Reason::inverted, fmt::format("the mesh is inside out from face {} on, at {}: its volume is {}",
													mesh.polygonInFile.front(),
													placeOf(mesh.vertices[mesh.triangles.front()[0]]), volume / 6));
	return origin + (0.25 / volume) * moment;
}

double rounded(double x)
{
	const float value = roundToFloat(x);
	// Denormal coordinates are far below the rounding of any extent allowed here; -0 becomes 0.
	return std::abs(value) < std::numeric_limits<float>::min() ? 0 : double(value);
}

void checkDistinct(const std::vector<Vec3>& vertices, const WeldedMesh& mesh)
{
	std::vector<std::uint32_t> order(vertices.size());
	std::iota(order.begin(), order.end(), 0u);
	const auto key = [&](std::uint32_t i) { return std::tie(vertices[i].x, vertices[i].y, vertices[i].z); };
	std::sort(order.begin(), order.end(),
			  [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
	for (std::size_t i = 1; i < order.size(); ++i)
		if (vertices[order[i]] == vertices[order[i - 1]])
			throw Refused(Reason::rounding,
						  fmt::format("vertices {} and {} meet once rounded to float round the centre of mass, at {}",
									  mesh.vertexInFile[order[i - 1]], mesh.vertexInFile[order[i]],
									  placeOf(mesh.vertices[order[i]])));
}
}  // namespace

Intake intake(const Soup& soup)
{
	const WeldedMesh welded = weldAndTriangulate(soup);
	const Box box = boundsOf(welded.vertices);
	checkTopology(welded);
	Intake result;
	result.meshFromBody = centerOfMass(welded, box);
	result.weldedCount = welded.weldedCount;
	result.unusedCount = welded.unusedCount;
	for (const Vec3& v : welded.vertices)
	{
		const Vec3 p = v - result.meshFromBody;
		result.mesh.vertices.push_back({rounded(p.x), rounded(p.y), rounded(p.z)});
	}
	result.mesh.triangles = welded.triangles;
	checkDistinct(result.mesh.vertices, welded);
	std::vector<std::uint32_t> componentOf;
	result.componentCount = components(welded, componentOf);
	result.cavityCount = checkSolid(result.mesh, welded, componentOf);
	return result;
}

Intake intakeFile(const std::string& path)
{
	return intake(readMesh(path));
}
}  // namespace clod::builder
