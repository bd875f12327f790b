// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/FileFrame.h"

#include <stdexcept>

namespace clod::builder
{
namespace
{
struct Unit
{
	const char* name;
	double numerator, denominator;  // of a metre; both are exact doubles
};
constexpr Unit kUnits[] = {{"um", 1, 1e6}, {"mm", 1, 1000},     {"cm", 1, 100},
						   {"m", 1, 1},    {"in", 254, 10'000}, {"ft", 3048, 10'000}};

std::vector<std::string> namesOfUnits()
{
	std::vector<std::string> names;
	for (const Unit& unit : kUnits) names.push_back(unit.name);
	return names;
}

const Unit& unitNamed(const std::string& name)
{
	for (const Unit& unit : kUnits)
		if (name == unit.name) return unit;
	throw std::invalid_argument("no unit " + name);
}

Vec3 withYUp(const Vec3& v, char up)
{
	if (up == 'z') return {v.x, v.z, -v.y};
	if (up == 'x') return {-v.y, v.x, v.z};
	return v;
}
}  // namespace

const std::vector<std::string>& unitNames()
{
	static const std::vector<std::string> names = namesOfUnits();
	return names;
}

const std::vector<std::string>& upNames()
{
	static const std::vector<std::string> names = {"x", "y", "z"};
	return names;
}

void convert(const FileFrame& frame, Soup& soup)
{
	const Unit unit = frame.unit.empty() ? Unit{"", 1, 1} : unitNamed(frame.unit);
	for (Vec3& v : soup.vertices)
	{
		v = withYUp(v, frame.up.front());
		for (int i = 0; i < 3; ++i) v[i] = frame.scale * (v[i] * unit.numerator / unit.denominator);
	}
}
}  // namespace clod::builder
