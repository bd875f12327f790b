// SPDX-License-Identifier: GPL-3.0-or-later
// Stands in for Repair.cpp where the CMake option CLOD_BUILD_REPAIR is off: sound meshes build as ever, the rest is
// told.
#include <stdexcept>

#include "builder/repair/Repair.h"

namespace clod::builder
{
namespace
{
[[noreturn]] void refuse()
{
	throw std::runtime_error(
		"this clod-build was configured with -DCLOD_BUILD_REPAIR=OFF (as scripts/demo does, to build sooner): no "
		"--repair and no --wrap\n  Try: cmake --preset release -DCLOD_BUILD_REPAIR=ON && cmake --build --preset release");
}
}  // namespace

double Repaired::moved() const
{
	refuse();
}

Repaired repair(const Soup&, double, const Progress&)
{
	refuse();
}

Repaired wrapAround(const Soup&, double, std::size_t, const Progress&)
{
	refuse();
}
}  // namespace clod::builder
