// SPDX-License-Identifier: GPL-3.0-or-later
// From a hierarchy's arrays to the hierarchy and back, for tests that change some of them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"

namespace clod::test
{
// Encodes, loads and validates; throws std::runtime_error with the reason where that fails.
std::shared_ptr<const Hierarchy> loaded(const HierarchyContent& content);
HierarchyContent contentOf(const Hierarchy& hierarchy);
// Why a file of these bytes is refused; empty: it is not.
std::string refusal(std::vector<std::byte> bytes);
}  // namespace clod::test
