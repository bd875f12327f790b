// SPDX-License-Identifier: Zlib
// Includes the file CLOD_KERNEL into the namespaces `plain` and `wide`, for any machine and for one with AVX2, and says
// as kWide whether this machine may use the latter (InstructionSets.h). Included once a unit; no include guard.
namespace plain
{
#include CLOD_KERNEL
}  // namespace plain

#if CLOD_HAS_WIDE
CLOD_WIDE_BEGIN
#define CLOD_WIDE
namespace wide
{
#include CLOD_KERNEL
}  // namespace wide
#undef CLOD_WIDE
CLOD_WIDE_END
const bool kWide = hasWideInstructions();
#else
namespace wide = plain;
constexpr bool kWide = false;
#endif
#undef CLOD_KERNEL
