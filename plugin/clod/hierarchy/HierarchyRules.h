// SPDX-License-Identifier: Zlib
// The rules of a sound hierarchy, in the order in which they may be evaluated: each group relies on the ones before it.
// Every function returns the first broken rule and element, or an empty string.
#pragma once
#include <string>

#include "clod/hierarchy/Hierarchy.h"

namespace clod::rules
{
// HierarchyValidation.cpp: indices and structure. Nothing is dereferenced before its index is proved.
std::string asset(const Hierarchy& h);
std::string levels(const Hierarchy& h);
std::string ranges(const Hierarchy& h);
std::string children(const Hierarchy& h);
// HierarchyNumbers.cpp: floats, geometry, monotone bounds.
std::string hulls(const Hierarchy& h);
std::string nodeNumbers(const Hierarchy& h);
std::string monotone(const Hierarchy& h);
std::string faces(const Hierarchy& h);
std::string levelMaxima(const Hierarchy& h);
std::string cullBoxes(const Hierarchy& h);
std::string grid(const Hierarchy& h);

inline bool isUnit(const Vec3& v, double tolerance)
{
	return std::fabs(lengthSquared(v) - 1) <= tolerance;
}
inline std::string element(const char* kind, std::size_t index)
{
	return kind + (" " + std::to_string(index)) + ": ";
}
}  // namespace clod::rules
