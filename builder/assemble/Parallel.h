// SPDX-License-Identifier: GPL-3.0-or-later
// A loop over fixed chunks on several threads. Each index is handled exactly once and writes only its own slots, so the
// result never depends on the number of threads.
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

// Calls body(i) for 0 <= i < count; the first exception is thrown again in the caller.
template <class Body>
void parallelFor(std::size_t count, unsigned threads, const Body& body)
{
	const std::size_t threadsAsked = threadCount(threads);
	// Few indices are long ones: a coarse patch answers for a large part of the input.
	const std::size_t chunk = std::clamp<std::size_t>(count / (16 * threadsAsked), 1, 64);
	std::atomic<std::size_t> next{0};
	std::mutex mutex;
	std::exception_ptr failure;
	const auto work = [&]
	{
		try
		{
			for (std::size_t begin = next.fetch_add(chunk); begin < count; begin = next.fetch_add(chunk))
				for (std::size_t i = begin; i < std::min(begin + chunk, count); ++i) body(i);
		}
		catch (...)
		{
			const std::lock_guard<std::mutex> lock(mutex);
			if (!failure) failure = std::current_exception();
			next = count;
		}
	};
	std::vector<std::thread> team;
	const std::size_t helpers = std::min(threadsAsked, (count + chunk - 1) / chunk);
	for (std::size_t i = 1; i < helpers; ++i) team.emplace_back(work);
	work();
	for (std::thread& thread : team) thread.join();
	if (failure) std::rethrow_exception(failure);
}
}  // namespace clod::builder
