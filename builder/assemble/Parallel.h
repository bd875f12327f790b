// SPDX-License-Identifier: GPL-3.0-or-later
// A loop over fixed chunks on several threads. Each index is handled exactly once and writes only its own slots, so the
// result never depends on the number of threads, which may grow while a loop runs.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace clod::builder
{
inline unsigned threadCount(unsigned requested)
{
	return requested > 0 ? requested : std::max(1u, std::thread::hardware_concurrency());
}

// How many threads loops may use. Another thread raises it when it ends: loops that run take its place in.
class ThreadLimit
{
public:
	ThreadLimit(unsigned requested) : m_count(threadCount(requested)) {}
	void raise(unsigned threads) { m_count = threads; }
	unsigned count() const { return m_count; }

private:
	std::atomic<unsigned> m_count;
};

// Calls body(i) for 0 <= i < count; the first exception is thrown again in the caller.
template <class Body>
void parallelFor(std::size_t count, const ThreadLimit& threads, const Body& body)
{
	// Few indices are long ones: a coarse patch answers for a large part of the input.
	const std::size_t chunk = std::clamp<std::size_t>(count / (32 * threads.count()), 1, 64);
	std::atomic<std::size_t> next{0};
	std::mutex mutex;
	std::exception_ptr failure;
	const auto work = [&](const auto& recruit)
	{
		try
		{
			for (std::size_t begin = next.fetch_add(chunk); begin < count; begin = next.fetch_add(chunk))
			{
				recruit();
				for (std::size_t i = begin; i < std::min(begin + chunk, count); ++i) body(i);
			}
		}
		catch (...)
		{
			const std::lock_guard<std::mutex> lock(mutex);
			if (!failure) failure = std::current_exception();
			next = count;
		}
	};
	std::vector<std::thread> team;
	work(
		[&]
		{
			while (team.size() + 1 < threads.count() && next < count) team.emplace_back([&] { work([] {}); });
		});
	for (std::thread& thread : team) thread.join();
	if (failure) std::rethrow_exception(failure);
}
}  // namespace clod::builder
