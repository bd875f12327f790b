// SPDX-License-Identifier: Zlib
#include "clod/hierarchy/ScaledHierarchy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "clod/hierarchy/BoundGrid.h"
#include "clod/hierarchy/HierarchyFormat.h"
#include "clod/hierarchy/HierarchyRules.h"
#include "clod/hierarchy/PrincipalAxes.h"
#include "clod/hierarchy/ThinnestWall.h"

namespace clod
{
namespace
{
constexpr double kRounding = 1.0 / (1 << 23);  // of the farthest coordinate: what rounding moves a vertex by, at most
constexpr double kRoom = 1 + 1e-6;             // for the rounding of sums and unit vectors
constexpr double kConeRoom = 1e-7;             // of coneCosine, as builders leave it
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of a vector along unit axes, from lowest to highest.
struct Extent
{
	double low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};
	void add(const Vec3 (&axis)[3], const Vec3& p)
	{
		for (int i = 0; i < 3; ++i)
		{
			const double at = dot(axis[i], p);
			low[i] = std::min(low[i], at);
			high[i] = std::max(high[i], at);
		}
	}
	// A box round a centre, given by its half edges.
	void add(const Vec3 (&axis)[3], const Vec3& center, const Vec3 (&half)[3])
	{
		for (int i = 0; i < 3; ++i)
		{
			const double at = dot(axis[i], center);
			const double reach =
				std::abs(dot(axis[i], half[0])) + std::abs(dot(axis[i], half[1])) + std::abs(dot(axis[i], half[2]));
			low[i] = std::min(low[i], at - reach);
			high[i] = std::max(high[i], at + reach);
		}
	}
};

class Scaling
{
public:
	Scaling(const Hierarchy& from, const Vec3& scale);
	const HierarchyContent& content() const { return m_to; }

private:
	Vec3 scaled(const Vec3& v) const { return {m_scale.x * v.x, m_scale.y * v.y, m_scale.z * v.z}; }
	double grown(double bound) const { return bound > 0 ? m_largest * bound * kRoom + m_rounding : 0; }
	void vertices();
	void sphere();
	void asset();
	void bounds();
	void masses();
	void faces();
	void node(std::uint32_t index);
	void normals(Node& n) const;
	double curvature(const Node& n) const;
	std::array<Vec3, 3> axesOf(const OrientedBox& old, const Vec3 (&edge)[3]) const;
	void box(std::uint32_t index);
	void levels();
	HullView hull(const Node& n) const
	{
		return {m_to.hullX.data() + n.firstVertex, m_to.hullY.data() + n.firstVertex, m_to.hullZ.data() + n.firstVertex,
				n.vertexCount, n.vertexCount};
	}
	Vec3 areaOf(const Node& n, const Face& f) const
	{
		const HullView h = hull(n);
		const Vec3 p = h.vertex(f.vertex[0]);
		return cross(h.vertex(f.vertex[1]) - p, h.vertex(f.vertex[2]) - p);
	}

	const Hierarchy& m_from;
	const Vec3 m_scale;
	const bool m_isUniform, m_isMirrored;
	double m_largest, m_volume;
	double m_rounding = 0;  // what rounding adds to a distance of two stored things
	HierarchyContent m_to;
};

Scaling::Scaling(const Hierarchy& from, const Vec3& scale)
	: m_from(from),
	  m_scale(scale),
	  m_isUniform(std::abs(scale.x) == std::abs(scale.y) && std::abs(scale.x) == std::abs(scale.z)),
	  m_isMirrored(scale.x * scale.y * scale.z < 0)
{
	const double s[3] = {std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)};
	m_largest = *std::max_element(s, s + 3);
	m_volume = s[0] * s[1] * s[2];
	m_to.asset = from.asset();
	m_to.levels.assign(from.levels().begin(), from.levels().end());
	m_to.nodes.assign(from.nodes().begin(), from.nodes().end());
	m_to.faces.assign(from.faces().begin(), from.faces().end());
	const std::uint32_t* const children = from.children(from.node(0)).data;  // a leaf has none: where the list begins
	m_to.children.assign(children, children + from.childrenSize());
	m_to.cullBoxes.reserve(from.nodes().size);
	vertices();
	sphere();
	asset();
	masses();
	faces();
	for (std::uint32_t i = 0; i < m_to.nodes.size(); ++i) node(i);
	bounds();
	levels();
	const double least = std::min({std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)});
	const bool isKnown = m_isUniform || from.isCoarse();
	m_to.asset.thinnestWall = boundAtMost(isKnown ? least * double(from.asset().thinnestWall) : thinnestWall(m_to));
}

void Scaling::vertices()
{
	const std::size_t count = m_from.hullSize();
	const HullView first = m_from.hull(m_from.node(0));
	const auto scale = [count](const float* from, double factor, std::vector<float>& to)
	{
		to.resize(count);
		float farthest = 0;
		for (std::size_t i = 0; i < count; ++i)
		{
			to[i] = float(factor * double(from[i]));
			farthest = std::max(farthest, std::abs(to[i]));
		}
		return double(farthest);
	};
	m_rounding = kRounding * std::max({scale(first.x, m_scale.x, m_to.hullX), scale(first.y, m_scale.y, m_to.hullY),
									   scale(first.z, m_scale.z, m_to.hullZ)});
}

void Scaling::sphere()
{
	Asset& a = m_to.asset;
	const float roughly = roundUp(m_largest * double(a.radius) * 1.001);
	const Vec3 center = scaled(toVec3(a.sphereCenter));
	for (int i = 0; i < 3; ++i) a.sphereCenter[i] = nearestAnchor(center[i], roughly);
	const Vec3 stored = toVec3(a.sphereCenter);
	if (m_from.isCoarse())
	{
		a.radius = roundUp(m_largest * double(a.radius) + length(stored - center));
		return;
	}
	double squared = 0;
	const Level& leaves = m_to.levels[0];
	for (std::uint32_t n = leaves.firstNode; n < leaves.firstNode + leaves.nodeCount; ++n)
	{
		const HullView h = hull(m_to.nodes[n]);
		for (std::uint32_t v = 0; v < h.count; ++v) squared = std::max(squared, lengthSquared(h.vertex(v) - stored));
	}
	a.radius = roundUp(std::sqrt(squared) * (1 + 1e-12));
}

void Scaling::asset()
{
	Asset& a = m_to.asset;
	a.storageTolerance = roundUp(kStorageShare * double(a.radius));
	a.areaTolerance = boundAtLeast(m_largest * double(a.areaTolerance));
	a.flags |= kScaled;
	const Vec3 origin = scaled({a.meshFromBody[0], a.meshFromBody[1], a.meshFromBody[2]});
	for (int i = 0; i < 3; ++i) a.meshFromBody[i] = origin[i];
}

// Of all thickened hulls.
void Scaling::bounds()
{
	const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
	Extent all;
	for (const Node& n : m_to.nodes)
	{
		const HullView h = hull(n);
		const Vec3 sweep = double(n.thickness) * toVec3(n.inward);
		for (std::uint32_t v = 0; v < h.count; ++v)
		{
			all.add(axes, h.vertex(v));
			if (n.thickness > 0) all.add(axes, h.vertex(v) + sweep);
		}
	}
	for (int i = 0; i < 3; ++i)
	{
		m_to.asset.boxMin[i] = roundDown(all.low[i]);
		m_to.asset.boxMax[i] = roundUp(all.high[i]);
	}
}

// Second moments are scaled, the tensor follows.
void Scaling::masses()
{
	Asset& a = m_to.asset;
	const double half = 0.5 * (a.inertia[0] + a.inertia[1] + a.inertia[2]);
	double second[3][3];
	const double s[3] = {m_scale.x, m_scale.y, m_scale.z};
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			second[i][j] = m_volume * s[i] * s[j] * (i == j ? half - a.inertia[i] : -a.inertia[i + j + 2]);
	const double trace = second[0][0] + second[1][1] + second[2][2];
	double tensor[3][3];
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) tensor[i][j] = (i == j ? trace : 0) - second[i][j];
	a.volume *= m_volume;
	for (int i = 0; i < 3; ++i) a.inertia[i] = tensor[i][i];
	a.inertia[3] = tensor[0][1];
	a.inertia[4] = tensor[0][2];
	a.inertia[5] = tensor[1][2];
	if (m_isUniform && !m_isMirrored) return;
	const std::array<double, 4> principal = quaternionOf(
		eigenFrame({a.inertia[0], a.inertia[1], a.inertia[2], a.inertia[3], a.inertia[4], a.inertia[5]}).axes);
	std::copy(principal.begin(), principal.end(), a.principal);
}

void Scaling::faces()
{
	for (const Node& n : m_to.nodes)
		for (std::uint32_t i = n.firstFace; i < n.firstFace + n.faceCount; ++i)
		{
			Face& f = m_to.faces[i];
			if (m_isMirrored)
			{
				std::swap(f.vertex[1], f.vertex[2]);
				std::swap(f.neighbour[0], f.neighbour[2]);
			}
			Vec3 normal = normalized(areaOf(n, f));
			if (normal == Vec3{})
			{
				const Vec3 old = toVec3(f.normal);
				normal = normalized({old.x / m_scale.x, old.y / m_scale.y, old.z / m_scale.z});
			}
			store(f.normal, normal);
			const Vec3 stored = toVec3(f.normal);
			const HullView h = hull(n);
			f.offset = roundUp(std::max({dot(stored, h.vertex(f.vertex[0])), dot(stored, h.vertex(f.vertex[1])),
										 dot(stored, h.vertex(f.vertex[2]))}));
			// A stretched wall is another, along another normal.
			f.thickness = m_isUniform ? boundAtMost(m_largest * double(f.thickness) / kRoom) : 0;
		}
}

void Scaling::normals(Node& n) const
{
	Vec3 mean;
	double narrowest = 1;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f) mean += areaOf(n, m_to.faces[f]);
	mean = normalized(mean);
	if (mean == Vec3{}) mean = normalized(scaled(toVec3(n.meanNormal)));
	store(n.meanNormal, mean);
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		const Vec3 area = areaOf(n, m_to.faces[f]);
		narrowest = std::min(narrowest, dot(area != Vec3{} ? normalized(area) : toVec3(m_to.faces[f].normal), mean));
	}
	n.coneCosine = roundDown(std::max(-1.0, narrowest - kConeRoom));
}

// Layout.h: half the sum of length times signed dihedral over its edges, by its area.
double Scaling::curvature(const Node& n) const
{
	const HullView h = hull(n);
	double sum = 0, area = 0;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		const Face& face = m_to.faces[f];
		area += 0.5 * length(areaOf(n, face));
		for (int e = 0; e < 3; ++e)
		{
			const std::uint32_t other = face.neighbour[e];
			if (other < f || other >= n.firstFace + n.faceCount) continue;
			const Vec3 normal = normalized(areaOf(n, face)), there = normalized(areaOf(n, m_to.faces[other]));
			const Vec3 edge = h.vertex(face.vertex[(e + 1) % 3]) - h.vertex(face.vertex[e]);
			sum += 0.5 * std::atan2(dot(cross(normal, there), edge), length(edge) * dot(normal, there)) * length(edge);
		}
	}
	return area > 0 ? sum / area : 0;
}

void Scaling::node(std::uint32_t index)
{
	Node& n = m_to.nodes[index];
	const bool isAbove = n.level > 0 || m_from.isCoarse();
	n.cover = isAbove ? boundAtLeast(grown(double(n.cover))) : 0;
	n.reach = isAbove ? boundAtLeast(grown(double(n.reach))) : 0;
	n.surf = isAbove ? boundAtLeast(grown(double(n.surf))) : 0;
	n.hausdorff = isAbove ? boundAtLeast(grown(double(n.hausdorff))) : 0;
	n.protrude = boundAtLeast(m_largest * double(n.protrude) * kRoom + m_rounding);
	n.deviation = std::max({n.cover, n.protrude, n.surf});
	n.resolution = boundAtMost(double(n.resolution) / m_largest);
	n.contactArea = boundAtMost(double(n.contactArea) * m_volume / m_largest);
	if (std::isfinite(n.featureVolume) && n.featureVolume > 0)
	{
		const double squared = double(n.resolution) * double(n.resolution);
		const double byResolution = n.resolution > 0 ? double(n.deviation) / squared : 0;
		n.featureVolume =
			boundAtLeast(std::max(double(n.featureVolume) * m_largest * m_largest * m_largest, byResolution));
	}
	const Vec3 inward = scaled(toVec3(n.inward));
	n.thickness = boundAtMost(std::max(0.0, double(n.thickness) * length(inward) / kRoom - m_rounding));
	const bool isAgainstMean = toVec3(n.inward) == -toVec3(n.meanNormal);
	store(n.inward, normalized(inward));
	if (n.faceCount > 0)
	{
		normals(n);
		n.curvature = roundToFloat(curvature(n));
		if (m_isUniform && isAgainstMean) store(n.inward, -toVec3(n.meanNormal));
	}
	box(index);
}

// Of a box's image: of a uniform scale its own axes, else those of its two longest edges, made orthogonal.
std::array<Vec3, 3> Scaling::axesOf(const OrientedBox& old, const Vec3 (&edge)[3]) const
{
	Vec3 image[3];
	for (int i = 0; i < 3; ++i) image[i] = scaled(toVec3(old.axis[i]));
	int order[3] = {0, 1, 2};
	if (!m_isUniform)
		std::sort(order, order + 3, [&](int i, int j) { return lengthSquared(edge[i]) > lengthSquared(edge[j]); });
	Vec3 first = normalized(image[order[0]]), second = image[order[1]];
	if (!m_isUniform) second -= dot(second, first) * first;
	second = normalized(second);
	// Axes to more than the precision that they are stored in are at right angles.
	return {first, second, cross(first, second)};
}

// Nothing that the old box holds lies outside its image, and nothing outside what the node's own hull and the boxes
// below it hold.
void Scaling::box(std::uint32_t index)
{
	const Node& n = m_to.nodes[index];
	const OrientedBox& old = m_from.cullBox(index);
	Vec3 edge[3];
	for (int i = 0; i < 3; ++i) edge[i] = scaled(double(old.half[i]) * toVec3(old.axis[i]));
	const std::array<Vec3, 3> axis = axesOf(old, edge);
	OrientedBox to{};
	Vec3 stored[3];
	for (int i = 0; i < 3; ++i)
	{
		store(to.axis[i], axis[std::size_t(i)]);
		stored[i] = toVec3(to.axis[i]);
	}
	Extent image, within;
	image.add(stored, scaled(toVec3(old.center)), edge);
	const HullView h = hull(n);
	const Vec3 sweep = double(n.thickness) * toVec3(n.inward);
	for (std::uint32_t v = 0; v < h.count; ++v)
	{
		within.add(stored, h.vertex(v));
		if (n.thickness > 0) within.add(stored, h.vertex(v) + sweep);
	}
	for (std::uint32_t k = 0; k < n.childCount; ++k)
	{
		const OrientedBox& below = m_to.cullBoxes[m_to.children[n.firstChild + k]];
		const Vec3 half[3] = {double(below.half[0]) * toVec3(below.axis[0]),
							  double(below.half[1]) * toVec3(below.axis[1]),
							  double(below.half[2]) * toVec3(below.axis[2])};
		within.add(stored, toVec3(below.center), half);
	}
	Vec3 center;
	double half[3];
	for (int i = 0; i < 3; ++i)
	{
		const double low = std::max(image.low[i] - m_rounding, within.low[i]);
		const double high = std::min(image.high[i] + m_rounding, within.high[i]);
		half[i] = 0.5 * (high - low);
		center += 0.5 * (low + high) * stored[i];
	}
	double corner = 0;
	for (int i = 0; i < 3; ++i) to.center[i] = nearestAnchor(center[i], m_to.asset.radius);
	const double moved = length(toVec3(to.center) - center) + m_rounding;
	for (int i = 0; i < 3; ++i)
	{
		to.half[i] = boundAtLeast(std::max(0.0, half[i]) * kRoom + moved);
		corner += double(to.half[i]) * double(to.half[i]);
	}
	const double ofSphere =
		m_largest * double(old.radius) * kRoom + length(toVec3(to.center) - scaled(toVec3(old.center))) + m_rounding;
	to.radius = boundAtLeast(std::min(std::sqrt(corner) * kRoom, ofSphere));
	m_to.cullBoxes.push_back(to);
}

void Scaling::levels()
{
	for (Level& level : m_to.levels)
	{
		level.patchTolerance = boundAtLeast(m_largest * double(level.patchTolerance) * kRoom + m_rounding);
		level.maxHausdorff = level.maxDeviation = level.maxCover = level.maxProtrude = level.maxSurf = 0;
		for (std::uint32_t i = level.firstNode; i < level.firstNode + level.nodeCount; ++i)
		{
			const Node& n = m_to.nodes[i];
			level.maxHausdorff = std::max(level.maxHausdorff, n.hausdorff);
			level.maxDeviation = std::max(level.maxDeviation, n.deviation);
			level.maxCover = std::max(level.maxCover, n.cover);
			level.maxProtrude = std::max(level.maxProtrude, n.protrude);
			level.maxSurf = std::max(level.maxSurf, n.surf);
		}
	}
}
}  // namespace

Result<std::shared_ptr<const Hierarchy>> scaledHierarchy(const Hierarchy& hierarchy, const Vec3& scale)
{
	const std::string name = "scale (" + std::to_string(scale.x) + ", " + std::to_string(scale.y) + ", " +
							 std::to_string(scale.z) + ") ";
	if (!isFinite(scale) || scale.x == 0 || scale.y == 0 || scale.z == 0)
		return Error{name + "must be finite and not zero"};
	const double largest = std::max({std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)});
	const double farthest = largest * hierarchy.originRadius();
	// The cube of a length, and its inverse, must be a float.
	if (!(farthest < 1e12) || !(farthest > 1e-12))
		return Error{name + "makes a body that is too large or too small for its file"};
	const auto make = [&]() -> Result<std::shared_ptr<const Hierarchy>>
	{
		std::shared_ptr<const Hierarchy> result =
			Hierarchy::fromOwnBytes(encode(Scaling(hierarchy, scale).content()), hierarchy.finestLevel());
		// What rounding may break; the rest holds as it held before.
		for (const auto rule : {rules::asset, rules::nodeNumbers, rules::faces})
			if (const std::string problem = rule(*result); !problem.empty())
				return Error{std::string(name).append("makes a body that floats cannot hold: ").append(problem)};
		return result;
	};
	return withinMemory(name, make);
}

Result<std::shared_ptr<const Hierarchy>> ScaledHierarchies::by(const Vec3& scale) const
{
	const std::lock_guard<std::mutex> lock(m_making);
	m_made.erase(std::remove_if(m_made.begin(), m_made.end(), [](const auto& made) { return made.second.expired(); }),
				 m_made.end());
	for (const auto& [factors, made] : m_made)
		if (factors == scale)
			if (std::shared_ptr<const Hierarchy> shared = made.lock()) return shared;
	Result<std::shared_ptr<const Hierarchy>> result = scaledHierarchy(m_hierarchy, scale);
	if (result) m_made.emplace_back(scale, result.value());
	return result;
}
}  // namespace clod
