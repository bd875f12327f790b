// SPDX-License-Identifier: Zlib
// What others derive from immutable data, kept beside it: each kind is made once, when first asked for, whatever the
// threads, and shared by all who ask later. The owner does not know the kinds.
#pragma once
#include <atomic>
#include <memory>
#include <mutex>

namespace clod
{
class DerivedData
{
public:
	DerivedData() = default;
	~DerivedData()
	{
		for (const Entry* entry = m_first.load(std::memory_order_relaxed); entry != nullptr;)
			entry = std::unique_ptr<const Entry>(entry)->next;
	}
	DerivedData(const DerivedData&) = delete;
	DerivedData& operator=(const DerivedData&) = delete;

	template <class T, class Source>
	const T& get(const Source& source) const
	{
		if (const Entry* known = find(keyOf<T>())) return *static_cast<const T*>(known->value.get());
		const std::lock_guard<std::mutex> lock(m_making);
		if (const Entry* known = find(keyOf<T>())) return *static_cast<const T*>(known->value.get());
		auto value = std::make_shared<const T>(source);
		const T& made = *value;
		m_first.store(new Entry{keyOf<T>(), std::move(value), m_first.load(std::memory_order_relaxed)},
					  std::memory_order_release);
		return made;
	}

private:
	struct Entry
	{
		const void* key;
		std::shared_ptr<const void> value;
		const Entry* next;
	};
	// The address of a function of its own tells a kind from all others.
	template <class T>
	static const void* keyOf()
	{
		static const char key = 0;
		return &key;
	}
	const Entry* find(const void* key) const
	{
		const Entry* entry = m_first.load(std::memory_order_acquire);
		while (entry != nullptr && entry->key != key) entry = entry->next;
		return entry;
	}
	mutable std::atomic<const Entry*> m_first{nullptr};
	mutable std::mutex m_making;
};
}  // namespace clod
