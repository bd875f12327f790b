// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see DeviationGuard.h.
#include "builder/patches/DeviationGuard.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace clod::builder
{
namespace
{
// Which cells of a grid hold a sample already, on surface that faces this way: the other side of a thin wall, in the
// same cell, has samples of its own.
class SampledCells
{
public:
	SampledCells(const Vec3& low, double size) : m_low(low), m_size(size) {}
	bool take(const Vec3& p, const Vec3& normal)
	{
		int axis = 0;
		for (int k = 1; k < 3; ++k)
			if (std::fabs(normal[k]) > std::fabs(normal[axis])) axis = k;
		std::uint64_t key = std::uint64_t(2 * axis + (normal[axis] < 0 ? 1 : 0));
		for (int k = 0; k < 3; ++k) key = (key << 20) | std::uint64_t((p[k] - m_low[k]) / m_size);
		return m_taken.insert(key).second;
	}

private:
	const Vec3 m_low;
	const double m_size;
	std::unordered_set<std::uint64_t> m_taken;
};

// Rows along the longest edge, of which a needle needs one; no points where that edge is not longer than the spacing.
template <class Visit>
void forEachGridPoint(const TrianglePoints& t, double twiceArea, double spacing, const Visit& visit)
{
	const auto side = [&](std::size_t k) { return lengthSquared(t[(k + 1) % 3] - t[k]); };
	std::size_t first = 0;
	for (std::size_t k = 1; k < 3; ++k)
		if (side(k) > side(first)) first = k;
	const Vec3 &a = t[first], &b = t[(first + 1) % 3], &apex = t[(first + 2) % 3];
	const double longest = std::sqrt(side(first));
	if (longest <= spacing) return;
	const int rows = int(std::ceil(twiceArea / longest / spacing));
	for (int row = 0; row < rows; ++row)
	{
		const double up = double(row) / rows;
		const Vec3 from = a + up * (apex - a), to = b + up * (apex - b);
		const int steps = std::max(1, int(std::ceil((1 - up) * longest / spacing)));
		for (int i = 0; i <= steps; ++i) visit(from + (double(i) / steps) * (to - from));
	}
}
}  // namespace

DeviationGuard::DeviationGuard(const Mesh& input, double radius) : m_input(input)
{
	m_held.samples.resize(input.triangles.size());
	std::vector<Box> boxes;
	for (const auto& t : input.triangles)
		boxes.push_back(boxOf({input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]}));
	m_tree.build(boxes);
	Box all;
	for (const Box& box : boxes) all.include(box);
	const double spacing = 0.02 * radius;
	SampledCells cells(all.low, 0.5 * spacing);
	std::vector<char> sampled(input.vertices.size(), 0);
	const auto add = [&](std::uint32_t face, const Vec3& x)
	{
		m_held.samples[face].push_back(std::uint32_t(m_samples.size()));
		m_samples.push_back(x);
	};
	const auto normalOf = [&](const std::array<std::uint32_t, 3>& t)
	{ return cross(input.vertices[t[1]] - input.vertices[t[0]], input.vertices[t[2]] - input.vertices[t[0]]); };
	for (std::uint32_t f = 0; f < input.triangles.size(); ++f)
		for (const std::uint32_t v : input.triangles[f])
		{
			cells.take(input.vertices[v], normalOf(input.triangles[f]));
			if (sampled[v]) continue;
			sampled[v] = 1;
			add(f, input.vertices[v]);
		}
	for (std::uint32_t f = 0; f < input.triangles.size(); ++f)
	{
		const auto& t = input.triangles[f];
		const Vec3 normal = normalOf(t);
		forEachGridPoint({input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]}, length(normal), spacing,
						 [&](const Vec3& x)
						 {
							 if (cells.take(x, normal)) add(f, x);
						 });
	}
}

bool DeviationGuard::isNear(const Vec3& p) const
{
	const double limit = bound * bound;
	Box box;
	box.include(p);
	return !m_tree.search(
		box.grownBy(bound),
		[&](std::uint32_t f)
		{
			const auto& t = m_input.triangles[f];
			return squaredDistance(p, {m_input.vertices[t[0]], m_input.vertices[t[1]], m_input.vertices[t[2]]}) > limit;
		});
}

bool DeviationGuard::surfaceIsNear(const Vec3& centre, const std::vector<TrianglePoints>& star) const
{
	if (!isNear(centre)) return false;
	for (const TrianglePoints& t : star)
		for (std::size_t k = 0; k < 3; ++k)
			if (t[k] == centre && !isNear(0.5 * (centre + t[(k + 1) % 3]))) return false;
	for (const TrianglePoints& t : star)
		if (!isNear((1.0 / 3) * (t[0] + t[1] + t[2]))) return false;
	return true;
}

bool DeviationGuard::inputIsNear(const std::vector<std::uint32_t>& oldFaces, const std::vector<std::uint32_t>& newFaces,
								 const std::vector<TrianglePoints>& newPoints)
{
	m_handover.clear();
	const double limit = bound * bound;
	double worst = 0;
	for (const std::uint32_t old : oldFaces)
		for (const std::uint32_t sample : m_held.samples[old])
		{
			double best = 1e300;
			std::uint32_t holder = kNone;
			for (std::size_t i = 0; i < newFaces.size(); ++i)
			{
				const double d = squaredDistance(m_samples[sample], newPoints[i]);
				if (d >= best) continue;
				best = d;
				holder = newFaces[i];
			}
			if (best > limit) return false;
			worst = std::max(worst, best);
			m_handover.push_back({sample, holder});
		}
	m_trialReached = std::sqrt(worst);
	return true;
}

void DeviationGuard::commit(const std::vector<std::uint32_t>& oldFaces)
{
	for (const std::uint32_t face : oldFaces) m_held.samples[face].clear();
	for (const Handover& h : m_handover) m_held.samples[h.face].push_back(h.sample);
	m_held.reached = std::max(m_held.reached, m_trialReached);
}
}  // namespace clod::builder
