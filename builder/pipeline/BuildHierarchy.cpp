// SPDX-License-Identifier: GPL-3.0-or-later
// Simplification is one long chain of collapses and runs on one thread; meanwhile the levels it has left behind are
// assigned and certified on the others. What comes out does not depend on how they interleave: a level is handed over
// when it is final, and the assembler sees levels in their order.
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "builder/assemble/Assembler.h"
#include "builder/assemble/Parallel.h"

namespace clod::builder
{
namespace
{
// From the simplifying thread to the assembling one.
class LodQueue
{
public:
	void push(Lod&& lod)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_lods.push_back(std::move(lod));
		m_changed.notify_one();
	}
	// After the last level, or instead of it.
	void close(std::exception_ptr failure)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_isClosed = true;
		m_failure = failure;
		m_changed.notify_one();
	}
	// Empty after the last one; throws what ended the simplification. left: levels still waiting, when all are known.
	std::optional<Lod> pop(std::optional<std::size_t>& left)
	{
		std::unique_lock<std::mutex> lock(m_mutex);
		m_changed.wait(lock, [this] { return m_isClosed || !m_lods.empty(); });
		if (m_failure) std::rethrow_exception(m_failure);
		if (m_isClosed) left = m_lods.size();
		if (m_lods.empty()) return {};
		std::optional<Lod> first(std::move(m_lods.front()));
		m_lods.pop_front();
		return first;
	}

private:
	std::mutex m_mutex;
	std::condition_variable m_changed;
	std::deque<Lod> m_lods;
	bool m_isClosed = false;
	std::exception_ptr m_failure;
};

// Tells of the simplification while it lasts, then of the assembly; a cancellation reaches both.
class SharedProgress
{
public:
	explicit SharedProgress(const Progress& progress) : m_progress(progress) {}
	bool ofSimplification(const char* phase, double fraction)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		return tell(phase, fraction);
	}
	bool ofAssembly(const char* phase, double fraction)
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		return m_isSimplified ? tell(phase, fraction) : !m_isCancelled;
	}
	void simplified()
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_isSimplified = true;
	}
	void cancel()
	{
		const std::lock_guard<std::mutex> lock(m_mutex);
		m_isCancelled = true;
	}

private:
	bool tell(const char* phase, double fraction)
	{
		if (!m_isCancelled && m_progress && !m_progress(phase, fraction)) m_isCancelled = true;
		return !m_isCancelled;
	}
	const Progress& m_progress;
	std::mutex m_mutex;
	bool m_isSimplified = false, m_isCancelled = false;
};

HierarchyContent sideBySide(const Mesh& input, const BuildConfig& config, const Progress& progress, unsigned threads)
{
	SharedProgress shared(progress);
	LodQueue queue;
	ThreadLimit team(threads - 1);
	std::thread simplification(
		[&]
		{
			std::exception_ptr failure;
			try
			{
				buildLods(
					input, config,
					[&](const char* phase, double fraction) { return shared.ofSimplification(phase, fraction); },
					[&](Lod&& lod) { queue.push(std::move(lod)); });
			}
			catch (...)
			{
				failure = std::current_exception();
			}
			shared.simplified();
			queue.close(failure);
			team.raise(threads);
		});
	try
	{
		const Progress ofAssembly = [&](const char* phase, double fraction)
		{ return shared.ofAssembly(phase, fraction); };
		Assembler assembler(input, config, ofAssembly, team);
		std::size_t done = 0;
		std::optional<std::size_t> left;
		for (std::optional<Lod> lod = queue.pop(left); lod; lod = queue.pop(left))
		{
			if (!ofAssembly("certify", left ? double(done) / double(done + *left) : 0)) throw Cancelled{};
			assembler.add(std::move(*lod));
			++done;
		}
		simplification.join();
		return assembler.finish();
	}
	catch (...)
	{
		shared.cancel();
		if (simplification.joinable()) simplification.join();
		throw;
	}
}
}  // namespace

HierarchyContent buildHierarchy(const Mesh& input, const BuildConfig& config, const Progress& progress)
{
	const unsigned threads = threadCount(config.threads);
	if (threads > 1) return sideBySide(input, config, progress, threads);
	return assembleHierarchy(buildLods(input, config, progress), config, progress);
}
}  // namespace clod::builder
