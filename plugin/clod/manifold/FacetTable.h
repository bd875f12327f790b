// SPDX-License-Identifier: Zlib
// Facets by their feature, so that each comes once: an open hash table over a list of them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clod/manifold/Facet.h"

namespace clod
{
class FacetTable
{
public:
	// Of these, which stay their owner's; so many in all are expected.
	void start(std::vector<Facet>& facets, std::size_t expected);
	// Null if there is none.
	Facet* find(std::uint64_t feature);
	// Appends it. Precondition: there is none.
	void add(const Facet& facet);

private:
	std::size_t slotOf(std::uint64_t feature) const;
	void tabulate(std::size_t size);

	std::vector<Facet>* m_facets = nullptr;
	std::vector<std::uint32_t> m_slots;  // a power of two
};
}  // namespace clod
