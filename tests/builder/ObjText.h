// SPDX-License-Identifier: GPL-3.0-or-later
// Small solids as OBJ text, to be spoilt by tests.
#pragma once
#include <sstream>
#include <string>
#include <utility>

#include "builder/Lod.h"

namespace clod::test
{
inline const std::string kVertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
inline const std::string kBottom = "f 1 4 3 2\n", kTop = "f 5 6 7 8\n";
inline const std::string kSides = "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
inline const std::string kCube = kVertices + kBottom + kTop + kSides;

// A tetrahedron on vertices first .. first + 3, moved and scaled.
inline std::string tetrahedron(double x, double size, int first, bool inverted = false)
{
	const auto v = [&](double a, double b, double c)
	{
		return "v " + std::to_string(x + size * a) + " " + std::to_string(size * b) + " " + std::to_string(size * c) +
			   "\n";
	};
	const auto f = [&](int a, int b, int c)
	{
		if (inverted) std::swap(b, c);
		return "f " + std::to_string(first + a) + " " + std::to_string(first + b) + " " + std::to_string(first + c) +
			   "\n";
	};
	return v(1, 1, 1) + v(-1, -1, 1) + v(-1, 1, -1) + v(1, -1, -1) + f(0, 2, 1) + f(0, 1, 3) + f(0, 3, 2) + f(1, 2, 3);
}

// Every digit of it.
inline std::string objText(const builder::Mesh& mesh)
{
	std::ostringstream text;
	text.precision(17);
	for (const Vec3& v : mesh.vertices) text << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
	for (const auto& t : mesh.triangles) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
	return text.str();
}

inline std::string replaced(std::string text, const std::string& what, const std::string& with)
{
	return text.replace(text.find(what), what.size(), with);
}
}  // namespace clod::test
