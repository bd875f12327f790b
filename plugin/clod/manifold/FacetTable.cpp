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
	for (std::uint32_t i = 0; i < m_facets->size(); ++i) m_slots[slotOf((*m_facets)[i])] = i;
}

// Where it is, or would be.
std::size_t FacetTable::slotOf(const Facet& facet) const
{
	const std::uint64_t features = std::uint64_t(facet.featureA) << 32 | facet.featureB;
	const std::uint64_t rest = std::uint64_t(facet.kind) << 32 | facet.levelA << 16 | facet.levelB;
	std::size_t at = std::size_t(((features ^ rest * 0xD6E8FEB86659FD93u) * 0x9E3779B97F4A7C15u) >> 32);
	for (;; ++at)
	{
		at &= m_slots.size() - 1;
		if (m_slots[at] == kNone) return at;
		const Facet& other = (*m_facets)[m_slots[at]];
		if (other.featureA == facet.featureA && other.featureB == facet.featureB && other.kind == facet.kind &&
			other.levelA == facet.levelA && other.levelB == facet.levelB)
			return at;
	}
}

Facet* FacetTable::find(const Facet& facet)
{
	const std::uint32_t at = m_slots[slotOf(facet)];
	return at == kNone ? nullptr : &(*m_facets)[at];
}

void FacetTable::add(const Facet& facet)
{
	m_slots[slotOf(facet)] = std::uint32_t(m_facets->size());
	m_facets->push_back(facet);
	if (2 * m_facets->size() > m_slots.size()) tabulate(2 * m_slots.size());
}
}  // namespace clod
