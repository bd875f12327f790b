// SPDX-License-Identifier: GPL-3.0-or-later
// Proves again, on a loaded file, what Layout.h promises about a dual hierarchy. Shares nothing with the builder but
// the record definitions: own trees, own distances, hulls and inside tests by CGAL.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <clod/hierarchy/Hierarchy.h>

namespace clod::check
{
struct Invariant
{
	std::string name;
	std::uint64_t checked = 0;     // elements looked at
	std::uint64_t violations = 0;  // proved broken
	std::uint64_t undecided = 0;   // neither proved nor broken within the effort allowed
	double worst = 0;            // largest excess over the promise (a length where the promise is one); 0 when all hold
	std::string firstViolation;  // names the element of lowest index
};

// The mesh a hierarchy is said to come from, in its own frame; any polygons.
struct GivenMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::vector<std::uint32_t>> polygons;
};

struct Options
{
	unsigned threads = 0;              // 0 = all cores; the result is the same for every number
	const GivenMesh* given = nullptr;  // level 0 must equal it
	std::function<void(const std::string& invariant, double fraction)> progress;
};

// In a fixed order, cheap ones first. Later ones rely on the earlier: after a violation the remaining are left out.
std::vector<Invariant> checkHierarchy(const Hierarchy& hierarchy, const Options& options);
}  // namespace clod::check
