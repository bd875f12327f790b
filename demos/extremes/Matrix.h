// SPDX-License-Identifier: Zlib
// Runs the rows and judges every number: ours by the row's bound, Bullet's by the part of it that does not speak of
// Bullet.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "demos/extremes/Row.h"

namespace clod::demo
{
enum class Verdict
{
	notApplicable,
	holds,
	asBullet,  // beyond what was asked for, but no worse than allowed beside Bullet's best shape of the same mesh
	limit,     // outside, and the row says what happens
	outside
};
const char* name(Verdict verdict);
// The worse of two.
Verdict worse(Verdict a, Verdict b);

// One number of one run.
struct Cell
{
	std::size_t row = 0, quantity = 0;  // of the rows
	std::string caseLabel;
	Setting setting;
	Reading reading;
	double bound = 0;
	Verdict verdict = Verdict::notApplicable;
	std::string better;  // who of Bullet's does better than this one of ours; empty: none
	std::string note;    // the limit, or why there is no number
	// 1 is just within; 0 where there is no bound.
	double shareOfBound() const;
};

struct Matrix
{
	std::vector<Row> rows;
	std::vector<Cell> cells;           // by row, case, rate, quantity, collider
	std::vector<double> seconds;       // that each row took
	bool isQuick = false;              // only part of each row was run
	int count(Verdict verdict) const;  // of our cells
	std::vector<const Cell*> cellsOf(std::size_t row, Collider collider) const;
	// Limits whose cells all hold, as "E5: ...": they should go. Of whole runs only.
	std::vector<std::string> needlessLimits() const;
};

struct MatrixOptions
{
	bool isQuick = false;
	std::string only;          // the id of a row; empty: all
	double shareOfBounds = 1;  // below 1: shows what has little room
};

// Those that the options leave; throws cli::Failure (2) where that is none, with the nearest id.
std::vector<Row> chosenRows(std::vector<Row> rows, const MatrixOptions& options);
Matrix runMatrix(std::vector<Row> rows, Workshop& workshop, bool isQuick,
				 const std::function<void(const std::string& id, double fraction)>& progress);
// Bounds and verdicts of cells that have their readings.
void judge(Matrix& matrix);
// Throws cli::Failure (4) where a number of ours is outside.
void demandBounds(const Matrix& matrix);
}  // namespace clod::demo
