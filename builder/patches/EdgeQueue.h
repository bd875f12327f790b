// SPDX-License-Identifier: GPL-3.0-or-later
// Edges that wait for a collapse, the one of highest resolution first (paper, sec. 4.2.1), and what became of the
// others.
#pragma once
#include <cstdint>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clod::builder
{
class EdgeQueue
{
public:
	using Edge = std::pair<std::uint32_t, std::uint32_t>;
	// Replaces an older entry of the same edge.
	void push(std::uint32_t u, std::uint32_t w, double priority)
	{
		const Edge edge = ordered(u, w);
		State& state = m_states[key(edge)];
		state.isWaiting = true;
		m_heap.push({priority, edge.first, edge.second, ++state.version});
	}
	// The next edge, false when none waits.
	bool pop(Edge& edge)
	{
		while (!m_heap.empty())
		{
			const auto [priority, u, w, version] = m_heap.top();
			m_heap.pop();
			State& state = m_states[key({u, w})];
			if (!state.isWaiting || state.version != version) continue;
			state.isWaiting = false;
			edge = {u, w};
			return true;
		}
		return false;
	}
	bool isWaiting(std::uint32_t u, std::uint32_t w) { return m_states[key(ordered(u, w))].isWaiting; }
	// How often the edge was put back after a change nearby.
	std::uint32_t& retries(std::uint32_t u, std::uint32_t w) { return m_states[key(ordered(u, w))].retries; }
	void clear()
	{
		m_heap = {};
		m_states.clear();
	}

private:
	struct State
	{
		std::uint32_t version = 0;
		std::uint32_t retries = 0;
		bool isWaiting = false;
	};
	static Edge ordered(std::uint32_t u, std::uint32_t w) { return u < w ? Edge{u, w} : Edge{w, u}; }
	static std::uint64_t key(const Edge& e) { return (std::uint64_t(e.first) << 32) | e.second; }
	std::priority_queue<std::tuple<double, std::uint32_t, std::uint32_t, std::uint32_t>> m_heap;
	std::unordered_map<std::uint64_t, State> m_states;
};
}  // namespace clod::builder
