// SPDX-License-Identifier: GPL-3.0-or-later
// The graph of nodes, the levels, and numbers that must agree or rise towards the root.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/check/Rounding.h"
#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
// Every node but the last has one primary parent, of a coarser level; every node but those of level 0 has children, the
// primary ones in ascending order, then the shared ones.
Invariant tree(const Subject& s)
{
	Tally tally("tree");
	std::vector<int> primaryParents(s.h.nodes().size, 0);
	for (const Node& n : s.h.nodes())
		for (std::uint32_t k = 0; k < n.primaryChildCount; ++k) ++primaryParents[s.h.children(n)[k]];
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		const Node& n = s.h.node(i);
		const bool parented = primaryParents[i] == (i == s.h.root() ? 0 : 1);
		const bool hasChildren = n.level == 0 ? n.childCount == 0 : n.primaryChildCount > 0;
		bool descending = true;
		for (const std::uint32_t child : s.h.children(n)) descending = descending && s.h.node(child).level < n.level;
		const Span<std::uint32_t> children = s.h.children(n);
		const std::uint32_t* const shared = children.begin() + n.primaryChildCount;
		const bool ordered = std::is_sorted(children.begin(), shared) && std::is_sorted(shared, children.end());
		tally.add(i, parented && hasChildren && descending && ordered ? 0 : 1,
				  fmt::format("node {} has {} primary parents, {} children, {}", i, primaryParents[i], n.childCount,
							  ordered ? "in order" : "out of order"));
	}
	return tally.result();
}

Invariant halving(const Subject& s)
{
	Tally tally("levels-halve");
	for (std::size_t k = 1; k < s.h.levels().size; ++k)
	{
		const std::uint32_t here = s.h.levels()[k].nodeCount, below = s.h.levels()[k - 1].nodeCount;
		// ceil: completion pairs patches, the odd one goes up alone.
		tally.add(k, double(here) - double((below + 1) / 2),
				  fmt::format("level {} has {} patches, the level below {}", k, here, below));
	}
	return tally.result();
}

Invariant flags(const Subject& s)
{
	Tally tally("completion-flags");
	bool contactBelow = true;
	for (std::size_t k = 0; k < s.h.levels().size; ++k)
	{
		const Level& level = s.h.levels()[k];
		const bool contact = (level.flags & kClodNode) != 0;
		bool agree = contact == (level.faceCount > 0) && (contactBelow || !contact);
		for (std::uint32_t i = 0; i < level.nodeCount; ++i)
			agree = agree && s.isContact(level.firstNode + i) == contact;
		tally.add(k, agree ? 0 : 1, fmt::format("level {} mixes contact and completion", k));
		contactBelow = contact;
	}
	return tally.result();
}

double below(float parent, float child)
{
	return double(child) - double(parent);
}

Invariant monotone(const Subject& s)
{
	Tally tally("monotone");
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		const Node& n = s.h.node(i);
		for (const std::uint32_t c : s.h.children(n))
		{
			const Node& m = s.h.node(c);
			double excess =
				std::max({below(n.cover, m.cover), below(n.reach, m.reach), below(n.protrude, m.protrude),
						  below(n.surf, m.surf), below(n.deviation, m.deviation), below(m.contactArea, n.contactArea)});
			if (n.featureVolume < m.featureVolume) excess = std::max(excess, 1.0);
			if (m.resolution > 0) excess = std::max(excess, below(m.resolution, n.resolution));
			tally.add(i, excess, fmt::format("node {} and its child {}: a bound falls towards the root", i, c));
		}
	}
	return tally.result();
}

Invariant derived(const Subject& s)
{
	Tally tally("derived-numbers");
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		const Node& n = s.h.node(i);
		bool sound = n.deviation == std::max({n.cover, n.protrude, n.surf}) && n.contactArea > 0 && n.reach >= n.cover;
		if (n.resolution > 0)
		{
			// f = s / r^2, or the largest of the children where monotony raised it.
			const double own = double(n.deviation) / (double(n.resolution) * double(n.resolution));
			sound = sound && double(n.featureVolume) >= own * (1 - 1e-5);
		}
		tally.add(i, sound ? 0 : 1, fmt::format("node {}: deviation, area, reach or feature volume disagree", i));
	}
	return tally.result();
}

// eps_0 is eight roundings of storage; no contact level was built with less.
Invariant tolerances(const Subject& s)
{
	Tally tally("tolerances");
	const float stored = s.h.asset().storageTolerance;
	const double least = 8 * std::ldexp(s.radius, -24);
	tally.add(0, isNextAbove(stored, least, 0) ? 0 : 1,
			  fmt::format("storage tolerance {:.9g} is {:.9g}", double(stored), least));
	for (std::size_t k = 0; k <= s.h.coarsestClodLevel(); ++k)
	{
		const Level& level = s.h.levels()[k];
		tally.add(k + 1, least * (1 - 1e-6) - double(level.patchTolerance),
				  fmt::format("level {}: patch tolerance {:.9g} is below the storage tolerance", k,
							  double(level.patchTolerance)));
	}
	return tally.result();
}

// Pieces of the input surface that hang together.
Invariant components(const Subject& s)
{
	Tally tally("components");
	const std::uint32_t count = s.h.levels()[0].faceCount;
	std::vector<bool> seen(count, false);
	std::uint32_t found = 0;
	for (std::uint32_t first = 0; first < count; ++first)
	{
		if (seen[first]) continue;
		++found;
		std::vector<std::uint32_t> open = {first};
		seen[first] = true;
		while (!open.empty())
		{
			const std::uint32_t f = open.back();
			open.pop_back();
			for (const std::uint32_t other : s.h.faces()[f].neighbour)
				if (!seen[other]) seen[other] = true, open.push_back(other);
		}
	}
	tally.add(0, found == s.h.asset().componentCount ? 0 : 1,
			  fmt::format("{} components are said to be {}", found, s.h.asset().componentCount));
	return tally.result();
}

Invariant maxima(const Subject& s)
{
	Tally tally("level-maxima");
	for (std::size_t k = 0; k < s.h.levels().size; ++k)
	{
		const Level& level = s.h.levels()[k];
		Level found = {};
		for (std::uint32_t i = 0; i < level.nodeCount; ++i)
		{
			const Node& n = s.h.node(level.firstNode + i);
			found.maxHausdorff = std::max(found.maxHausdorff, n.hausdorff);
			found.maxDeviation = std::max(found.maxDeviation, n.deviation);
			found.maxCover = std::max(found.maxCover, n.cover);
			found.maxProtrude = std::max(found.maxProtrude, n.protrude);
			found.maxSurf = std::max(found.maxSurf, n.surf);
		}
		const bool agree = found.maxHausdorff == level.maxHausdorff && found.maxDeviation == level.maxDeviation &&
						   found.maxCover == level.maxCover && found.maxProtrude == level.maxProtrude &&
						   found.maxSurf == level.maxSurf;
		tally.add(k, agree ? 0 : 1, fmt::format("level {}: a maximum is not that of its nodes", k));
	}
	return tally.result();
}
}  // namespace

Invariants checkGraph(const Subject& s)
{
	return {tree(s), halving(s), flags(s), monotone(s), derived(s), tolerances(s), components(s), maxima(s)};
}
}  // namespace clod::check
