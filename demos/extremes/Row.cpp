// SPDX-License-Identifier: Zlib
#include "demos/extremes/Row.h"

#include <algorithm>
#include <cmath>

namespace clod::demo
{
const char* name(Collider collider)
{
	constexpr const char* kNames[kColliders] = {"primitive", "mesh", "exact", "0.5 %", "3.5 %"};
	return kNames[std::size_t(collider)];
}

Reading relativeTo(double expected, double value)
{
	return {value, expected, std::fabs(value / expected - 1)};
}

Reading differenceFrom(double expected, double value)
{
	return {value, expected, std::fabs(value - expected)};
}

Reading amount(double value)
{
	return {value, 0, value};
}

std::vector<Row> allRows()
{
	std::vector<Row> rows = engineRows();
	for (const auto& more : {levelRows(), analyticRows(), roundRows(), contactRows(), jointRows()})
		rows.insert(rows.end(), more.begin(), more.end());
	// E, A, C, J as they come; numbers within.
	const std::string letters = "EACJ";
	const auto place = [&](const Row& row)
	{ return std::make_pair(letters.find(row.id[0]), std::stoi(row.id.substr(1))); };
	std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return place(a) < place(b); });
	return rows;
}
}  // namespace clod::demo
