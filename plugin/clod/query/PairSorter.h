// SPDX-License-Identifier: Zlib
// Puts contacts in the order of their nodes, whatever the walk that found them. Buffers only.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "clod/query/Query.h"

namespace clod
{
class PairSorter
{
public:
	void sort(std::vector<Contact>& contacts)
	{
		if (std::is_sorted(contacts.begin(), contacts.end(), before)) return;
		m_order.clear();
		for (std::uint32_t i = 0; i < contacts.size(); ++i)
			m_order.push_back({std::uint64_t(contacts[i].nodeA) << 32 | contacts[i].nodeB, i});
		std::sort(m_order.begin(), m_order.end());
		m_unsorted.assign(contacts.begin(), contacts.end());
		for (std::size_t i = 0; i < contacts.size(); ++i) contacts[i] = m_unsorted[m_order[i].contact];
	}

private:
	struct Ordered
	{
		std::uint64_t nodes;  // both of a contact
		std::uint32_t contact;
		bool operator<(const Ordered& other) const { return nodes < other.nodes; }
	};
	static bool before(const Contact& l, const Contact& r)
	{
		return l.nodeA != r.nodeA ? l.nodeA < r.nodeA : l.nodeB < r.nodeB;
	}
	std::vector<Ordered> m_order;
	std::vector<Contact> m_unsorted;
};
}  // namespace clod
