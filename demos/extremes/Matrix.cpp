// SPDX-License-Identifier: Zlib
#include "demos/extremes/Matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "cli/Failure.h"
#include "cli/Suggestion.h"
#include "demos/extremes/Stage.h"

namespace clod::demo
{
namespace
{
constexpr double kClearlyBetter = 0.9;  // Bullet's error over ours
constexpr double kNoticeable = 0.01;    // of the bound: differences below tell nothing

// Readings of one run into its cells, one a quantity.
void runCell(const Row& row, Workshop& workshop, std::vector<Cell>& cells)
{
	std::vector<Reading> readings;
	std::string note;
	try
	{
		readings = row.run(workshop, cells.front().setting);
	}
	catch (const NotApplicable& reason)
	{
		for (Cell& cell : cells) cell.note = reason.what();
		return;
	}
	catch (const NotFinite& reason)
	{
		note = reason.what();
		readings.assign(cells.size(), {std::nan(""), 0, std::numeric_limits<double>::infinity()});
	}
	for (std::size_t i = 0; i < cells.size(); ++i)
	{
		cells[i].reading = readings.at(i);
		cells[i].note = note;
		if (!std::isfinite(cells[i].reading.error)) cells[i].reading.error = std::numeric_limits<double>::infinity();
		cells[i].verdict = Verdict::outside;  // until judged
	}
}

const Limit* limitOf(const Row& row, const Cell& cell)
{
	for (const Limit& limit : row.limits)
		if (limit.covers(cell.setting) &&
			(limit.quantity.empty() || limit.quantity == row.quantities[cell.quantity].name))
			return &limit;
	return nullptr;
}

// `group` are the cells of one quantity of one case and rate, one a collider.
void judgeGroup(const Row& row, Cell* group)
{
	const auto of = [&](Collider collider) -> Cell& { return group[std::size_t(collider)]; };
	const Bound& bound = row.quantities[group->quantity].bound;
	const Cell& mesh = of(Collider::mesh);
	double besideMesh = 0;
	if (bound.timesMesh > 0 && mesh.verdict != Verdict::notApplicable)
		besideMesh = bound.timesMesh * mesh.reading.error + bound.beyondMesh;
	for (const Collider collider : kEveryCollider)
	{
		Cell& cell = of(collider);
		if (cell.verdict == Verdict::notApplicable) continue;
		const double error = cell.reading.error;
		cell.bound = isOurs(collider) ? std::max(bound.most, besideMesh) : bound.most;
		const bool isFinite = std::isfinite(error);
		cell.verdict = isFinite && error <= bound.most ? Verdict::holds : Verdict::outside;
		if (!isOurs(collider)) continue;
		if (cell.verdict == Verdict::outside && isFinite && error <= besideMesh) cell.verdict = Verdict::asBullet;
		if (cell.verdict == Verdict::outside)
			if (const Limit* limit = limitOf(row, cell))
			{
				cell.verdict = Verdict::limit;
				cell.note = limit->beyond;
			}
		for (const Collider bullets : {Collider::primitive, Collider::mesh})
		{
			const Cell& other = of(bullets);
			if (other.verdict == Verdict::notApplicable || !std::isfinite(other.reading.error)) continue;
			if (other.reading.error < kClearlyBetter * error && error - other.reading.error > kNoticeable * bound.most)
				cell.better += (cell.better.empty() ? "" : ", ") + std::string(name(bullets));
		}
	}
}
}  // namespace

const char* name(Verdict verdict)
{
	constexpr const char* kNames[] = {"not applicable", "holds", "as Bullet", "limit", "outside"};
	return kNames[std::size_t(verdict)];
}

Verdict worse(Verdict a, Verdict b)
{
	return std::max(a, b);
}

double Cell::shareOfBound() const
{
	if (bound > 0) return std::isfinite(bound) ? reading.error / bound : 0;
	return reading.error > 0 ? std::numeric_limits<double>::infinity() : 0;
}

int Matrix::count(Verdict verdict) const
{
	return int(std::count_if(cells.begin(), cells.end(),
							 [&](const Cell& cell)
							 { return isOurs(cell.setting.collider) && cell.verdict == verdict; }));
}

std::vector<const Cell*> Matrix::cellsOf(std::size_t row, Collider collider) const
{
	std::vector<const Cell*> found;
	for (const Cell& cell : cells)
		if (cell.row == row && cell.setting.collider == collider) found.push_back(&cell);
	return found;
}

std::vector<std::string> Matrix::needlessLimits() const
{
	std::vector<std::string> needless;
	if (isQuick) return needless;
	for (std::size_t row = 0; row < rows.size(); ++row)
		for (const Limit& limit : rows[row].limits)
		{
			const auto isMet = [&](const Cell& cell)
			{ return cell.row == row && cell.verdict == Verdict::limit && cell.note == limit.beyond; };
			if (std::none_of(cells.begin(), cells.end(), isMet)) needless.push_back(rows[row].id + ": " + limit.beyond);
		}
	return needless;
}

std::vector<Row> chosenRows(std::vector<Row> rows, const MatrixOptions& options)
{
	std::vector<std::string> ids;
	std::vector<Row> chosen;
	for (Row& row : rows)
	{
		ids.push_back(row.id);
		if (options.only.empty() ? options.isQuick && row.isSlow : options.only != row.id) continue;
		if (options.isQuick)
		{
			if (!row.cases.empty()) row.cases.resize(1);
			row.rates.resize(1);
		}
		for (Quantity& quantity : row.quantities)
			for (double* part : {&quantity.bound.most, &quantity.bound.timesMesh, &quantity.bound.beyondMesh})
				*part *= options.shareOfBounds;
		chosen.push_back(std::move(row));
	}
	if (chosen.empty())
		throw cli::Failure(cli::ExitCode::usage,
						   fmt::format("no row is called '{}'{}", options.only, cli::didYouMean(options.only, ids)));
	return chosen;
}

Matrix runMatrix(std::vector<Row> rows, Workshop& workshop, bool isQuick,
				 const std::function<void(const std::string& id, double fraction)>& progress)
{
	using Clock = std::chrono::steady_clock;
	Matrix matrix;
	matrix.rows = std::move(rows);
	matrix.isQuick = isQuick;
	for (std::size_t r = 0; r < matrix.rows.size(); ++r)
	{
		const Row& row = matrix.rows[r];
		progress(row.id, double(r) / double(matrix.rows.size()));
		const auto start = Clock::now();
		const std::vector<Case> cases = row.cases.empty() ? std::vector<Case>{{0, ""}} : row.cases;
		for (const Case& one : cases)
			for (const double rate : row.rates)
			{
				const std::size_t first = matrix.cells.size(), count = row.quantities.size();
				matrix.cells.resize(first + count * kColliders);
				for (const Collider collider : kEveryCollider)
				{
					std::vector<Cell> run(count);
					for (std::size_t q = 0; q < count; ++q)
					{
						run[q].row = r;
						run[q].quantity = q;
						run[q].caseLabel = one.label;
						run[q].setting = {collider, rate, one.parameter, isQuick};
					}
					runCell(row, workshop, run);
					for (std::size_t q = 0; q < count; ++q)
						matrix.cells[first + q * kColliders + std::size_t(collider)] = run[q];
				}
			}
		matrix.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
	}
	judge(matrix);
	return matrix;
}

void demandBounds(const Matrix& matrix)
{
	const int outside = matrix.count(Verdict::outside);
	if (outside == 0) return;
	throw cli::Failure(
		cli::ExitCode::verificationFailed,
		fmt::format("{} number{} outside of the bound, and no known limit", outside, outside == 1 ? " is" : "s are"));
}

void judge(Matrix& matrix)
{
	for (std::size_t i = 0; i < matrix.cells.size(); i += kColliders)
		judgeGroup(matrix.rows[matrix.cells[i].row], &matrix.cells[i]);
}
}  // namespace clod::demo
