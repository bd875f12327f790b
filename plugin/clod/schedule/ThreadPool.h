// SPDX-License-Identifier: Zlib
// Threads that are kept from step to step: Bullet's own need a build of Bullet that Debian, for one, does not ship.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "clod/Export.h"

namespace clod
{
class CLOD_API ThreadPool
{
public:
	static constexpr unsigned kMostThreads = 1024;
	// The calling thread included; at least 1, at most these. Fewer, where the machine gives no more.
	explicit ThreadPool(unsigned threads);
	~ThreadPool();
	ThreadPool(const ThreadPool&) = delete;
	ThreadPool& operator=(const ThreadPool&) = delete;

	unsigned threads() const { return unsigned(m_workers.size()) + 1; }
	// work(i) for all i < count, in any order, and back when all are done. The first exception is thrown on. By one
	// thread at a time.
	void run(std::uint32_t count, const std::function<void(std::uint32_t)>& work);

private:
	void serve();
	void takeAll();

	std::vector<std::thread> m_workers;
	std::mutex m_mutex;  // of all below but m_next
	std::condition_variable m_begun, m_done;
	std::uint64_t m_round = 0;
	unsigned m_busy = 0;
	bool m_isOver = false;
	std::uint32_t m_count = 0;
	const std::function<void(std::uint32_t)>* m_work = nullptr;
	std::exception_ptr m_failure;
	std::atomic<std::uint32_t> m_next{0};
};
}  // namespace clod
