// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: see DeviationGuard.h.
#include "builder/patches/DeviationGuard.h"

#include <algorithm>

namespace clod::builder
{
DeviationGuard::DeviationGuard(const Mesh& input, double radius) : m_input(input)
{
	m_held.samples.resize(input.triangles.size());
	const double spacing = 0.02 * radius;
	std::vector<Box> boxes;
	std::vector<char> sampled(input.vertices.size(), 0);
	for (std::uint32_t f = 0; f < input.triangles.size(); ++f)
	{
		const auto& t = input.triangles[f];
		const TrianglePoints p = {input.vertices[t[0]], input.vertices[t[1]], input.vertices[t[2]]};
		boxes.push_back(boxOf(p));
		const auto add = [&](const Vec3& x)
		{
			m_held.samples[f].push_back(std::uint32_t(m_samples.size()));
			m_samples.push_back(x);
		};
		for (std::size_t k = 0; k < 3; ++k)
			if (!sampled[t[k]])
			{
				sampled[t[k]] = 1;
				add(p[k]);
			}
		const double longest =
			std::sqrt(std::max({lengthSquared(p[1] - p[0]), lengthSquared(p[2] - p[1]), lengthSquared(p[0] - p[2])}));
		const int steps = int(std::ceil(longest / spacing));
		for (int i = 0; i <= steps && steps > 1; ++i)
			for (int j = 0; i + j <= steps; ++j)
				if (i != steps && j != steps && i + j != 0)
					add(p[0] + (double(i) / steps) * (p[1] - p[0]) + (double(j) / steps) * (p[2] - p[0]));
	}
	m_tree.build(boxes);
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
