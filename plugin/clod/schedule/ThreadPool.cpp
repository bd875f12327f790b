// SPDX-License-Identifier: Zlib
#include "clod/schedule/ThreadPool.h"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

namespace clod
{
ThreadPool::ThreadPool(unsigned threads)
{
	threads = std::min(threads, kMostThreads);
	m_workers.reserve(threads);
	try
	{
		for (unsigned i = 1; i < threads; ++i) m_workers.emplace_back([this] { serve(); });
	}
	// There are no more: those that there are do all of it.
	catch (const std::system_error&)
	{
	}
	catch (const std::bad_alloc&)
	{
	}
}

ThreadPool::~ThreadPool()
{
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_isOver = true;
	}
	m_begun.notify_all();
	for (std::thread& worker : m_workers) worker.join();
}

void ThreadPool::run(std::uint32_t count, const std::function<void(std::uint32_t)>& work)
{
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_work = &work;
		m_count = count;
		m_next = 0;
		m_busy = unsigned(m_workers.size());
		++m_round;
	}
	m_begun.notify_all();
	takeAll();
	std::unique_lock<std::mutex> lock(m_mutex);
	m_done.wait(lock, [this] { return m_busy == 0; });
	if (std::exception_ptr failure = std::exchange(m_failure, nullptr)) std::rethrow_exception(failure);
}

void ThreadPool::serve()
{
	for (std::uint64_t round = 0;;)
	{
		{
			std::unique_lock<std::mutex> lock(m_mutex);
			m_begun.wait(lock, [&] { return m_isOver || m_round != round; });
			if (m_isOver) return;
			round = m_round;
		}
		takeAll();
		const std::lock_guard<std::mutex> lock(m_mutex);
		if (--m_busy == 0) m_done.notify_one();
	}
}

void ThreadPool::takeAll()
{
	try
	{
		for (std::uint32_t i = 0; (i = m_next.fetch_add(1, std::memory_order_relaxed)) < m_count;) (*m_work)(i);
	}
	catch (...)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		if (!m_failure) m_failure = std::current_exception();
	}
}
}  // namespace clod
