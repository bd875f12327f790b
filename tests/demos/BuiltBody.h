// SPDX-License-Identifier: GPL-3.0-or-later
// A benchmark model at any resolution, through the whole builder, once a process.
#pragma once
#include <map>
#include <string>
#include <utility>

#include "tests/fixtures/Recipes.h"
#include "tests/query/Bodies.h"
#include "tests/support/HierarchyContents.h"

namespace clod::test
{
inline const Body& builtBody(const std::string& model, std::size_t triangles)
{
	static std::map<std::pair<std::string, std::size_t>, Body> bodies;
	const auto key = std::make_pair(model, triangles);
	const auto known = bodies.find(key);
	if (known != bodies.end()) return known->second;
	return bodies.emplace(key, bodyOf(model, loaded(built(modelMesh(model, triangles))))).first->second;
}
}  // namespace clod::test
