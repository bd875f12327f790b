// SPDX-License-Identifier: GPL-3.0-or-later
// Global new and delete of a program whose allocations a test counts or lets fail. For its one file that defines, before it
// includes this, `void* allocate(std::size_t)` (null: out of memory) and `void release(void*)`.
#pragma once
#include <cstddef>
#include <new>

// Inlined in part, GCC takes malloc or free for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size)
{
	if (void* p = allocate(size)) return p;
	throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept
{
	release(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept
{
	release(p);
}
