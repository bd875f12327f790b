// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/check/Subject.h"

#include <algorithm>
#include <atomic>
#include <thread>

namespace clod::check
{
void Tally::add(std::uint64_t element, double excess, const std::string& what)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	++m_invariant.checked;
	if (!(excess > 0) && excess == excess) return;
	++m_invariant.violations;
	m_invariant.worst = std::max(m_invariant.worst, excess);
	if (element >= m_firstElement) return;
	m_firstElement = element;
	m_invariant.firstViolation = what;
}

void Tally::hold(std::uint64_t count)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_invariant.checked += count;
}

void Tally::undecided()
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	++m_invariant.checked;
	++m_invariant.undecided;
}

Subject::Subject(const Hierarchy& hierarchy, const Options& settings)
	: h(hierarchy),
	  options(settings),
	  radius(double(hierarchy.asset().radius)),
	  slack(1e-9 * radius),
	  parents(hierarchy.nodes().size),
	  primaryParent(hierarchy.nodes().size, kNone),
	  ownerOfFace(hierarchy.faces().size, kNone)
{
	for (std::uint32_t i = 0; i < h.nodes().size; ++i)
	{
		const Node& n = h.node(i);
		for (std::uint32_t k = 0; k < n.childCount; ++k)
		{
			const std::uint32_t child = h.children(n)[k];
			parents[child].push_back(i);
			if (k < n.primaryChildCount) primaryParent[child] = i;
		}
		for (std::uint32_t f = 0; f < n.faceCount; ++f) ownerOfFace[n.firstFace + f] = i;
	}
}

Triangle Subject::triangle(std::uint32_t face) const
{
	const Face& f = h.faces()[face];
	const HullView hull = h.hull(h.node(ownerOfFace[face]));
	return {hull.vertex(f.vertex[0]), hull.vertex(f.vertex[1]), hull.vertex(f.vertex[2])};
}

std::vector<Triangle> Subject::levelTriangles(const Level& level) const
{
	std::vector<Triangle> triangles;
	for (std::uint32_t f = 0; f < level.faceCount; ++f) triangles.push_back(triangle(level.firstFace + f));
	return triangles;
}

Vec3 Subject::sweep(const Node& n) const
{
	return double(n.thickness) * Vec3{double(n.inward[0]), double(n.inward[1]), double(n.inward[2])};
}

std::vector<Vec3> Subject::thickHull(std::uint32_t node) const
{
	const Node& n = h.node(node);
	const HullView hull = h.hull(n);
	std::vector<Vec3> points;
	for (std::uint32_t v = 0; v < hull.count; ++v) points.push_back(hull.vertex(v));
	if (n.thickness > 0)
		for (std::uint32_t v = 0; v < hull.count; ++v) points.push_back(points[v] + sweep(n));
	return points;
}

void Subject::forEach(const std::string& name, std::size_t count, const std::function<void(std::size_t)>& work) const
{
	constexpr std::size_t kChunk = 16;
	std::atomic<std::size_t> next{0};
	std::mutex progressMutex;
	const auto run = [&]
	{
		for (std::size_t begin = next.fetch_add(kChunk); begin < count; begin = next.fetch_add(kChunk))
		{
			for (std::size_t i = begin; i < std::min(count, begin + kChunk); ++i) work(i);
			const std::lock_guard<std::mutex> lock(progressMutex);
			if (options.progress) options.progress(name, double(std::min<std::size_t>(next, count)) / double(count));
		}
	};
	const unsigned wanted = options.threads == 0 ? std::max(1u, std::thread::hardware_concurrency()) : options.threads;
	std::vector<std::thread> others;
	for (unsigned t = 1; t < wanted; ++t) others.emplace_back(run);
	run();
	for (std::thread& thread : others) thread.join();
}
}  // namespace clod::check
