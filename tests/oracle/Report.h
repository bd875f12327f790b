// SPDX-License-Identifier: GPL-3.0-or-later
// Results of families as rows: for people, csv and json.
#pragma once
#include <nlohmann/json.hpp>

#include "tests/oracle/Trial.h"

namespace clod::oracle
{
const char* kindName(Kind kind);
// One row a family and kind of motion; distributions are median, 95, 99, 99.9 % and worst. Shares of the smaller radius
// (depths) and of the motion (changes); faults and the best half space in 1,000 motions.
nlohmann::ordered_json rowsOf(FamilyResult& result, const std::string& setting);
std::string csvOf(const nlohmann::ordered_json& rows);
std::string tableHead();
std::string tableLine(FamilyResult& result);
// One trial in full, to be looked at.
std::string described(const Trial& trial);
}  // namespace clod::oracle
