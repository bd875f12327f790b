// SPDX-License-Identifier: GPL-3.0-or-later
// The repair is Kuhn's augmenting path for bipartite matchings.
#include "builder/assemble/Graph.h"

#include <algorithm>

namespace clod::builder
{
namespace
{
class Linker
{
public:
	Linker(const std::vector<Overlap>& overlaps, std::uint32_t fineCount, std::uint32_t coarseCount)
		: m_primaryCount(coarseCount, 0)
	{
		m_links.children.resize(coarseCount);
		m_links.primaryParent.assign(fineCount, kNone);
		std::vector<double> best(fineCount, -1);
		for (const Overlap& o : overlaps)
		{
			m_links.children[o.coarse].push_back(o.fine);
			if (o.area > best[o.fine])
			{
				best[o.fine] = o.area;
				m_links.primaryParent[o.fine] = o.coarse;
			}
		}
		for (std::uint32_t parent : m_links.primaryParent)
			if (parent != kNone) ++m_primaryCount[parent];
	}

	bool needsChild(std::uint32_t coarse) const { return m_primaryCount[coarse] == 0; }
	bool isSpare(std::uint32_t fine) const { return m_primaryCount[m_links.primaryParent[fine]] > 1; }

	// Takes a child from a patch that has several, or from one that can itself take another.
	bool augment(std::uint32_t coarse, std::vector<bool>& visited)
	{
		visited[coarse] = true;
		for (std::uint32_t fine : m_links.children[coarse])
			if (m_links.primaryParent[fine] != coarse && isSpare(fine)) return take(coarse, fine), true;
		for (std::uint32_t fine : m_links.children[coarse])
		{
			const std::uint32_t other = m_links.primaryParent[fine];
			if (other == coarse || visited[other] || !augment(other, visited)) continue;
			return take(coarse, fine), true;
		}
		return false;
	}

	void adopt(std::uint32_t coarse, std::uint32_t fine)
	{
		m_links.children[coarse].push_back(fine);
		take(coarse, fine);
	}

	LevelLinks finish()
	{
		for (auto& list : m_links.children)
		{
			std::sort(list.begin(), list.end());
			list.erase(std::unique(list.begin(), list.end()), list.end());
		}
		return std::move(m_links);
	}

private:
	void take(std::uint32_t coarse, std::uint32_t fine)
	{
		--m_primaryCount[m_links.primaryParent[fine]];
		++m_primaryCount[coarse];
		m_links.primaryParent[fine] = coarse;
	}

	LevelLinks m_links;
	std::vector<std::uint32_t> m_primaryCount;
};
}  // namespace

LevelLinks linkLevels(const std::vector<Overlap>& overlaps, std::uint32_t fineCount, std::uint32_t coarseCount,
					  const std::function<double(std::uint32_t, std::uint32_t)>& distance)
{
	Linker linker(overlaps, fineCount, coarseCount);
	for (std::uint32_t coarse = 0; coarse < coarseCount; ++coarse)
	{
		std::vector<bool> visited(coarseCount, false);
		if (!linker.needsChild(coarse) || linker.augment(coarse, visited)) continue;
		std::uint32_t nearest = kNone;
		double least = std::numeric_limits<double>::infinity();
		for (std::uint32_t fine = 0; fine < fineCount; ++fine)
			if (linker.isSpare(fine) && distance(coarse, fine) < least) least = distance(coarse, fine), nearest = fine;
		if (nearest != kNone) linker.adopt(coarse, nearest);
	}
	return linker.finish();
}
}  // namespace clod::builder
