// SPDX-License-Identifier: Zlib
// Room that a pair keeps from step to step: hardly more than twice what it needs. What an impact took is given back,
// and what goes to and fro a little allocates nothing.
#pragma once
#include <vector>

namespace clod
{
inline constexpr std::size_t kLeastRoom = 512;  // bytes that are not worth giving back

template <class T>
void shrinkRoom(std::vector<T>& kept, std::size_t needed)
{
	if (needed == 0 || kept.capacity() > kLeastRoom / sizeof(T) + 2 * needed) kept.shrink_to_fit();
}
template <class T>
void keepCopy(const std::vector<T>& from, std::vector<T>& kept)
{
	kept.clear();
	shrinkRoom(kept, from.size());
	kept.assign(from.begin(), from.end());
}
}  // namespace clod
