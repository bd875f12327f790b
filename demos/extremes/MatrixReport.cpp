// SPDX-License-Identifier: Zlib
#include "demos/extremes/MatrixReport.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <set>

#include "cli/Csv.h"

namespace clod::demo
{
namespace
{
std::string number(double value)
{
	return std::isnan(value) ? "nan" : std::isinf(value) ? (value > 0 ? "inf" : "-inf") : fmt::format("{:.6g}", value);
}

// JSON knows no infinity.
nlohmann::ordered_json finite(double value)
{
	return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string placeOf(const Cell& cell)
{
	return fmt::format("{}{}1/{:g} s", cell.caseLabel, cell.caseLabel.empty() ? "" : ", ", cell.setting.rate);
}

std::string markOf(Verdict verdict)
{
	constexpr const char* kMarks[] = {"", "", "~", "L", "!"};
	return kMarks[std::size_t(verdict)];
}

nlohmann::ordered_json describe(const Cell& cell, const Quantity& quantity)
{
	return {{"quantity", quantity.name},
			{"case", cell.caseLabel},
			{"rate", cell.setting.rate},
			{"collider", name(cell.setting.collider)},
			{"value", finite(cell.reading.value)},
			{"expected", finite(cell.reading.expected)},
			{"error", finite(cell.reading.error)},
			{"bound", finite(cell.bound)},
			{"verdict", name(cell.verdict)},
			{"better", cell.better},
			{"note", cell.note}};
}

std::string sentence(const Matrix& matrix, const Cell& cell)
{
	const Row& row = matrix.rows[cell.row];
	const Quantity& quantity = row.quantities[cell.quantity];
	return fmt::format("{} {} ({}, {}): {} {:.3g} {}, bound {:.3g}{}{}", row.id, row.shows, placeOf(cell),
					   name(cell.setting.collider), quantity.name, cell.reading.error, quantity.unit, cell.bound,
					   cell.note.empty() ? "" : "; ", cell.note);
}

// The cell that is worst for a collider in one quantity of a row, or null.
const Cell* worstOf(const Matrix& matrix, std::size_t row, std::size_t quantity, Collider collider)
{
	const Cell* worst = nullptr;
	for (const Cell* cell : matrix.cellsOf(row, collider))
	{
		if (cell->quantity != quantity || cell->verdict == Verdict::notApplicable) continue;
		if (!worst || cell->verdict > worst->verdict ||
			(cell->verdict == worst->verdict && cell->shareOfBound() > worst->shareOfBound()))
			worst = cell;
	}
	return worst;
}
}  // namespace

std::string formatCsv(const Matrix& matrix)
{
	std::string text = "row,quantity,unit,case,rate,collider,value,expected,error,bound,verdict,better,note\n";
	for (const Cell& cell : matrix.cells)
	{
		const Row& row = matrix.rows[cell.row];
		const Quantity& quantity = row.quantities[cell.quantity];
		text += fmt::format("{},{},{},{},{:g},{},", row.id, quantity.name, quantity.unit, cell.caseLabel,
							cell.setting.rate, name(cell.setting.collider));
		const bool isMeasured = cell.verdict != Verdict::notApplicable;
		for (const double value : {cell.reading.value, cell.reading.expected, cell.reading.error, cell.bound})
			text += (isMeasured ? number(value) : "") + ",";
		text += fmt::format("{},{},{}\n", name(cell.verdict), cli::quotedField(cell.better), cli::quotedField(cell.note));
	}
	return text;
}

void addToReport(nlohmann::ordered_json& report, const Matrix& matrix)
{
	auto& rows = report["rows"] = nlohmann::ordered_json::array();
	for (std::size_t r = 0; r < matrix.rows.size(); ++r)
	{
		const Row& row = matrix.rows[r];
		nlohmann::ordered_json described = {{"id", row.id},
											{"shows", row.shows},
											{"source", row.source},
											{"axis", row.axis},
											{"seconds", matrix.seconds[r]}};
		for (const Quantity& quantity : row.quantities)
			described["quantities"].push_back({{"name", quantity.name},
											   {"unit", quantity.unit},
											   {"most", finite(quantity.bound.most)},
											   {"times_mesh", quantity.bound.timesMesh},
											   {"beyond_mesh", quantity.bound.beyondMesh}});
		for (const Cell& cell : matrix.cells)
			if (cell.row == r) described["cells"].push_back(describe(cell, row.quantities[cell.quantity]));
		rows.push_back(std::move(described));
	}
	auto& limits = report["limits"] = nlohmann::ordered_json::array();
	for (const Row& row : matrix.rows)
		for (const Limit& limit : row.limits) limits.push_back({{"row", row.id}, {"beyond", limit.beyond}});
	report["needless_limits"] = matrix.needlessLimits();
	auto& outside = report["outside"] = nlohmann::ordered_json::array();
	for (const Cell& cell : matrix.cells)
		if (isOurs(cell.setting.collider) && cell.verdict == Verdict::outside)
			outside.push_back(sentence(matrix, cell));
	auto& tested = report["tested_elsewhere"] = nlohmann::ordered_json::array();
	for (const TestedElsewhere& row : testedElsewhere())
		tested.push_back({{"id", row.id}, {"shows", row.shows}, {"test", row.test}});
	for (const Verdict verdict : {Verdict::holds, Verdict::asBullet, Verdict::limit, Verdict::outside})
		report["counts"][name(verdict)] = matrix.count(verdict);
}

std::string printable(const Matrix& matrix)
{
	std::string text = fmt::format("{:<5}{:<24}{:>10}  ", "row", "quantity, worst of all", "bound");
	for (const Collider collider : kEveryCollider) text += fmt::format("{:>12}", name(collider));
	text += "  Bullet does better\n";
	for (std::size_t row = 0; row < matrix.rows.size(); ++row)
		for (std::size_t q = 0; q < matrix.rows[row].quantities.size(); ++q)
		{
			const Quantity& quantity = matrix.rows[row].quantities[q];
			text += fmt::format("{:<5}{:<24}{:>10.3g}{:<2}", matrix.rows[row].id, quantity.name.substr(0, 23),
								quantity.bound.most, quantity.bound.timesMesh > 0 ? "+" : "");
			std::set<std::string> better;
			for (const Collider collider : kEveryCollider)
			{
				const Cell* cell = worstOf(matrix, row, q, collider);
				text += fmt::format("{:>12}",
									cell ? fmt::format("{:.3g}{}", cell->reading.error, markOf(cell->verdict)) : "-");
				for (const Cell* one : matrix.cellsOf(row, collider))
					if (one->quantity == q && !one->better.empty()) better.insert(name(collider));
			}
			std::string who;
			for (const std::string& one : better) who += (who.empty() ? "than " : ", ") + one;
			text += "  " + who + "\n";
		}
	text += "+ or so many times the error of Bullet's best shape of the mesh, then ~   L a limit   ! outside\n";
	for (const Row& row : matrix.rows)
		for (const Limit& limit : row.limits) text += fmt::format("limit {}: {}\n", row.id, limit.beyond);
	for (const std::string& limit : matrix.needlessLimits()) text += "no longer met: " + limit + "\n";
	for (const Cell& cell : matrix.cells)
		if (isOurs(cell.setting.collider) && cell.verdict == Verdict::outside)
			text += "OUTSIDE " + sentence(matrix, cell) + "\n";
	text += fmt::format("{} numbers of ours hold, {} are as Bullet's, {} are limits, {} are outside\n",
						matrix.count(Verdict::holds), matrix.count(Verdict::asBullet), matrix.count(Verdict::limit),
						matrix.count(Verdict::outside));
	return text;
}
}  // namespace clod::demo
