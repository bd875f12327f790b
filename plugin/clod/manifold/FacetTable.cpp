// SPDX-License-Identifier: Zlib
#include "clod/manifold/FacetTable.h"

namespace clod
{
namespace
{
constexpr std::size_t kLeast = 64;
}  // namespace

void FacetTable::start(std::vector<Facet>& facets, std::size_t expected)
{
	m_facets = &facets;
	std::size_t size = kLeast;
	while (size < 4 * expected) size *= 2;
	tabulate(size);
}

void FacetTable::tabulate(std::size_t size)
{
	m_slots.assign(size, kNone);
	for (std::uint32_t i = 0; i < m_facets->size(); ++i) m_slots[slotOf((*m_facets)[i].feature)] = i;
}

// Where it is, or would be.
std::size_t FacetTable::slotOf(std::uint64_t feature) const
{
	for (std::size_t at = std::size_t(feature >> 32);; ++at)
	{
		at &= m_slots.size() - 1;
		if (m_slots[at] == kNone || (*m_facets)[m_slots[at]].feature == feature) return at;
	}
}

Facet* FacetTable::find(std::uint64_t feature)
{
	const std::uint32_t at = m_slots[slotOf(feature)];
	return at == kNone ? nullptr : &(*m_facets)[at];
}

void FacetTable::add(const Facet& facet)
{
	m_slots[slotOf(facet.feature)] = std::uint32_t(m_facets->size());
	m_facets->push_back(facet);
	if (2 * m_facets->size() > m_slots.size()) tabulate(2 * m_slots.size());
}
}  // namespace clod
