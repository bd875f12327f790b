// SPDX-License-Identifier: Zlib
// A value or one sentence saying why there is none. No exceptions cross the plugin's interface.
#pragma once
#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace clod
{
struct Error
{
	std::string message;  // one sentence naming the first offending element and its value
};

template <class T>
class [[nodiscard]] Result
{
public:
	Result(T value) : m_value(std::move(value)) {}
	Result(Error error) : m_error(std::move(error)) {}
	explicit operator bool() const { return m_value.has_value(); }
	T& value() { assert(m_value); return *m_value; }
	const T& value() const { assert(m_value); return *m_value; }
	T* operator->() { return &value(); }
	T& operator*() { return value(); }
	const std::string& error() const { return m_error.message; }

private:
	std::optional<T> m_value;
	Error m_error;
};
}  // namespace clod
