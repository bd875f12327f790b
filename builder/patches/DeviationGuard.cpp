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

// A needle is so many times as long as it is high.
constexpr double kNeedle = 8;

// Samples on a triangle and its sides, but for its corners: `steps` of them along the two sides at p[0].
template <class Visit>
void forEachGridPoint(const TrianglePoints& p, const std::array<int, 2>& steps, const Visit& visit)
{
	for (int i = 0; i <= steps[0]; ++i)
		for (int j = 0; i * steps[1] + j * steps[0] <= steps[0] * steps[1]; ++j)
			if (i != steps[0] && j != steps[1] && i + j != 0)
				visit(p[0] + (double(i) / steps[0]) * (p[1] - p[0]) + (double(j) / steps[1]) * (p[2] - p[0]));
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
		TrianglePoints p = {input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]};
		const auto side = [&](std::size_t k) { return std::sqrt(lengthSquared(p[(k + 1) % 3] - p[k])); };
		const double longest = std::max({side(0), side(1), side(2)});
		const Vec3 normal = normalOf(t);
		const int steps = int(std::ceil(longest / spacing));
		if (steps <= 1) continue;
		if (kNeedle * length(normal) > longest * longest)
		{
			forEachGridPoint(p, {steps, steps}, [&](const Vec3& x) { add(f, x); });
			continue;
		}
		// From its shortest side on. Where needles lie side by side, cells are shared.
		while (side(0) > std::min(side(1), side(2))) std::rotate(p.begin(), p.begin() + 1, p.end());
		forEachGridPoint(p, {std::max(1, int(std::ceil(side(0) / spacing))), steps},
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
