// SPDX-License-Identifier: Zlib
// Signed distance to a closed mesh and the interpenetration of two.
#include "demos/runner/Penetration.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace clod::demo
{
namespace
{
constexpr std::uint32_t kLeafTriangles = 4;

double boxDistanceSquared(const Vec3& p, const Vec3& low, const Vec3& high)
{
	double sum = 0;
	for (int i = 0; i < 3; ++i)
	{
		const double d = std::max({low[i] - p[i], 0.0, p[i] - high[i]});
		sum += d * d;
	}
	return sum;
}

double angle(const Vec3& u, const Vec3& v)
{
	return std::atan2(length(cross(u, v)), dot(u, v));
}

// Which part of a triangle is nearest: 0 the face, 1 + i the vertex i, 4 + i the edge (i, i+1).
struct TrianglePoint
{
	Vec3 point;
	int feature;
};

double clamped(double value)
{
	return std::min(1.0, std::max(0.0, value));
}

TrianglePoint nearestOnEdge(const Vec3& p, const Vec3& a, const Vec3& b, int edge)
{
	const Vec3 ab = b - a;
	const double squared = lengthSquared(ab);
	const double t = squared > 0 ? clamped(dot(p - a, ab) / squared) : 0;
	if (t == 0) return {a, 1 + edge};
	if (t == 1) return {b, 1 + (edge + 1) % 3};
	return {a + t * ab, 4 + edge};
}

TrianglePoint nearestOnTriangle(const Vec3& p, const Vec3 (&v)[3])
{
	const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
	const double squared = lengthSquared(n);
	bool inside = squared > 0;
	for (int i = 0; i < 3 && inside; ++i) inside = dot(cross(n, v[(i + 1) % 3] - v[i]), p - v[i]) >= 0;
	if (inside) return {p - (dot(n, p - v[0]) / squared) * n, 0};
	TrianglePoint best{};
	double bestSquared = std::numeric_limits<double>::infinity();
	for (int i = 0; i < 3; ++i)
	{
		const TrianglePoint candidate = nearestOnEdge(p, v[i], v[(i + 1) % 3], i);
		const double d = lengthSquared(p - candidate.point);
		if (d < bestSquared) best = candidate, bestSquared = d;
	}
	return best;
}
}  // namespace

struct SignedDistance::Nearest
{
	double squared = std::numeric_limits<double>::infinity();
	Vec3 point;
	std::uint32_t triangle = 0;
	int feature = 0;
	double bound = std::numeric_limits<double>::infinity();  // squared
};

SignedDistance::SignedDistance(Surface surface) : m_surface(std::move(surface)), m_order(m_surface.triangles.size())
{
	std::iota(m_order.begin(), m_order.end(), 0u);
	addNormals();
	if (!m_order.empty()) addBox(0, std::uint32_t(m_order.size()));
}

void SignedDistance::addNormals()
{
	const auto& positions = m_surface.vertices;
	m_vertexNormals.resize(positions.size());
	std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> edges;
	for (const auto& t : m_surface.triangles)
	{
		const Vec3 n = normalized(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
		m_faceNormals.push_back(n);
		for (int i = 0; i < 3; ++i)
		{
			const std::uint32_t v = t[i], next = t[(i + 1) % 3], previous = t[(i + 2) % 3];
			m_vertexNormals[v] += angle(positions[next] - positions[v], positions[previous] - positions[v]) * n;
			edges[std::minmax(v, next)] += n;
		}
	}
	for (const auto& t : m_surface.triangles)
		m_edgeNormals.push_back(
			{edges[std::minmax(t[0], t[1])], edges[std::minmax(t[1], t[2])], edges[std::minmax(t[2], t[0])]});
}

std::uint32_t SignedDistance::addBox(std::uint32_t first, std::uint32_t count)
{
	const std::uint32_t index = std::uint32_t(m_boxes.size());
	constexpr double infinity = std::numeric_limits<double>::infinity();
	Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}, first, count};
	for (std::uint32_t i = first; i < first + count; ++i)
		for (const std::uint32_t v : m_surface.triangles[m_order[i]])
			for (int k = 0; k < 3; ++k)
			{
				box.low[k] = std::min(box.low[k], m_surface.vertices[v][k]);
				box.high[k] = std::max(box.high[k], m_surface.vertices[v][k]);
			}
	m_boxes.push_back(box);
	if (count <= kLeafTriangles) return index;
	const Vec3 size = box.high - box.low;
	const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
	const auto center = [&](std::uint32_t t)
	{
		const auto& v = m_surface.triangles[t];
		return m_surface.vertices[v[0]][axis] + m_surface.vertices[v[1]][axis] + m_surface.vertices[v[2]][axis];
	};
	const std::uint32_t half = count / 2;
	std::nth_element(m_order.begin() + first, m_order.begin() + first + half, m_order.begin() + first + count,
					 [&](std::uint32_t l, std::uint32_t r)
					 { return std::make_pair(center(l), l) < std::make_pair(center(r), r); });
	addBox(first, half);
	const std::uint32_t second = addBox(first + half, count - half);
	m_boxes[index].first = second;
	m_boxes[index].count = 0;
	return index;
}

void SignedDistance::visit(const Vec3& point, std::uint32_t triangle, Nearest& nearest) const
{
	const auto& t = m_surface.triangles[triangle];
	const Vec3 v[3] = {m_surface.vertices[t[0]], m_surface.vertices[t[1]], m_surface.vertices[t[2]]};
	const TrianglePoint candidate = nearestOnTriangle(point, v);
	const double squared = lengthSquared(point - candidate.point);
	if (squared < nearest.squared) nearest = {squared, candidate.point, triangle, candidate.feature, nearest.bound};
}

Vec3 SignedDistance::normalAt(const Nearest& nearest) const
{
	if (nearest.feature == 0) return m_faceNormals[nearest.triangle];
	if (nearest.feature < 4) return m_vertexNormals[m_surface.triangles[nearest.triangle][nearest.feature - 1]];
	return m_edgeNormals[nearest.triangle][nearest.feature - 4];
}

// The nearest point, or one at most 1 / sqrt(share) times as far; `bound`: nothing is nearer than its root.
SignedDistance::Nearest SignedDistance::search(const Vec3& point, double share) const
{
	Nearest nearest;
	std::vector<std::pair<double, std::uint32_t>> stack;
	stack.reserve(64);
	if (!m_boxes.empty()) stack.push_back({0.0, 0u});
	while (!stack.empty())
	{
		const auto [distance, index] = stack.back();
		stack.pop_back();
		if (distance >= share * nearest.squared)
		{
			nearest.bound = std::min(nearest.bound, distance);
			continue;
		}
		const Box& box = m_boxes[index];
		for (std::uint32_t i = 0; i < box.count; ++i) visit(point, m_order[box.first + i], nearest);
		if (box.count > 0) continue;
		std::pair<double, std::uint32_t> near = {0, index + 1}, far = {0, box.first};
		near.first = boxDistanceSquared(point, m_boxes[near.second].low, m_boxes[near.second].high);
		far.first = boxDistanceSquared(point, m_boxes[far.second].low, m_boxes[far.second].high);
		if (far.first < near.first) std::swap(near, far);
		stack.push_back(far);
		stack.push_back(near);
	}
	nearest.bound = std::min(nearest.bound, nearest.squared);
	return nearest;
}

double SignedDistance::operator()(const Vec3& point) const
{
	const Nearest nearest = search(point, 1);
	const double distance = std::sqrt(nearest.squared);
	return dot(point - nearest.point, normalAt(nearest)) < 0 ? -distance : distance;
}

double SignedDistance::clearance(const Vec3& point) const
{
	return std::sqrt(search(point, 0.25).bound);
}

PenetrationMeter::PenetrationMeter(std::shared_ptr<const SignedDistance> a, std::shared_ptr<const SignedDistance> b)
	: m_a(std::move(a)),
	  m_b(std::move(b)),
	  m_looksA(m_a->surface().vertices.size()),
	  m_looksB(m_b->surface().vertices.size())
{
}

double PenetrationMeter::depth(const Transform& aFromB)
{
	const Transform bFromA = inverse(aFromB);
	const auto deepestOf =
		[](const SignedDistance& solid, const Surface& other, const Transform& solidFromOther, std::vector<Look>& looks)
	{
		double deepest = 0;
		for (std::size_t i = 0; i < looks.size(); ++i)
		{
			const Vec3 point = solidFromOther * other.vertices[i];
			Look& last = looks[i];
			const double moved = length(point - last.place);
			if (moved < last.clear) continue;
			if (last.clear > 0)
			{
				const double clear = solid.clearance(point);
				if (moved < last.clear + clear)
				{
					last = {point, clear};
					continue;
				}
			}
			const double distance = solid(point);
			deepest = std::max(deepest, -distance);
			last = {point, std::max(0.0, distance)};
		}
		return deepest;
	};
	// Either body's vertices on a thread of their own.
	std::future<double> ofA =
		std::async(std::launch::async, [&] { return deepestOf(*m_b, m_a->surface(), bFromA, m_looksA); });
	const double ofB = deepestOf(*m_a, m_b->surface(), aFromB, m_looksB);
	return std::max(ofA.get(), ofB);
}
}  // namespace clod::demo
