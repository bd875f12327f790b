// SPDX-License-Identifier: Zlib
// The validity map: colours that colour-blind readers tell apart, and in each cell the error as a share of its bound.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "demos/extremes/MatrixReport.h"
#include "demos/trial/Html.h"

namespace clod::demo
{
namespace
{
constexpr double kLine = 17, kCell = 52, kName = 150, kMargin = 16, kWords = 350, kShows = 90;
constexpr double kLetter = 6.6;  // the widest that letters are in the mean, of the usual size

// Okabe & Ito.
std::string colorOf(Verdict verdict)
{
	constexpr const char* kColors[] = {"#eeeeee", "#7fcfb5", "#56b4e9", "#e69f00", "#d55e00"};
	return kColors[std::size_t(verdict)];
}

// The worst of several cells.
struct Summary
{
	Verdict verdict = Verdict::notApplicable;
	double share = 0;
	bool isBeaten = false;  // by Bullet
	void add(const Cell& cell)
	{
		if (cell.verdict == Verdict::notApplicable) return;
		isBeaten = isBeaten || !cell.better.empty();
		if (cell.verdict < verdict) return;
		share = cell.verdict > verdict ? cell.shareOfBound() : std::max(share, cell.shareOfBound());
		verdict = cell.verdict;
	}
	std::string text() const
	{
		if (verdict == Verdict::notApplicable) return "";
		return number() + (isBeaten ? " *" : "");
	}
	std::string number() const
	{
		if (!std::isfinite(share) || share >= 1e4) return "\u226b 1";
		return share < 0.005 ? "0" : share < 10 ? fmt::format("{:.2f}", share) : fmt::format("{:.0f}", share);
	}
};

class Picture
{
public:
	void text(double x, double y, const std::string& words, const char* style = "")
	{
		m_body += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, style, escaped(words));
		grow(x + (*style ? 0 : kLetter * double(words.size())), y);
	}
	void cell(double x, double y, const Summary& summary, const std::string& tip)
	{
		cell(x, y, summary.verdict, summary.text(), tip);
	}
	void cell(double x, double y, Verdict verdict, const std::string& words, const std::string& tip)
	{
		m_body += fmt::format(
			"<g><title>{}</title><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>"
			"<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text></g>\n",
			escaped(tip), x, y, kCell - 2, kLine - 2, colorOf(verdict), x + kCell / 2 - 1, y + kLine - 5, words);
		grow(x + kCell, y + kLine);
	}
	void grow(double x, double y)
	{
		m_width = std::max(m_width, x);
		m_height = std::max(m_height, y);
	}
	std::string whole() const
	{
		return fmt::format(
			"<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
			"{1:.0f}\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"11\">\n<rect width=\"100%\" "
			"height=\"100%\" fill=\"white\"/>\n{2}</svg>\n",
			m_width + kMargin, m_height + kMargin, m_body);
	}

private:
	std::string m_body;
	double m_width = 0, m_height = 0;
};

constexpr const char* kBold = "font-weight=\"bold\" font-size=\"13\"";
constexpr const char* kMiddle = "text-anchor=\"middle\"";
constexpr const char* kEnd = "text-anchor=\"end\"";

struct Column
{
	std::string label;
	std::function<bool(const Cell&)> isOf;
};
std::vector<Column> columnsOf(const Row& row)
{
	std::vector<Column> columns;
	if (row.axis == "step")
	{
		std::vector<double> rates = row.rates;
		std::sort(rates.begin(), rates.end());
		for (const double rate : rates)
			columns.push_back(
				{fmt::format("1/{:g} s", rate), [rate](const Cell& cell) { return cell.setting.rate == rate; }});
		return columns;
	}
	for (const Case& one : row.cases)
		columns.push_back({one.label, [one](const Cell& cell) { return cell.caseLabel == one.label; }});
	return columns;
}

std::string headOf(const Row& row)
{
	return fmt::format("{}: {}", row.id, row.shows);
}

// One axis: a block of colliders for each rate, a column for each place. Returns the height below it.
double drawAxis(Picture& picture, const Matrix& matrix, std::size_t index, double x, double y)
{
	const Row& row = matrix.rows[index];
	picture.text(x, y + 12, row.axis, kBold);
	picture.text(x + kShows, y + 12, headOf(row));
	y += kLine + 2;
	const std::vector<Column> columns = columnsOf(row);
	for (std::size_t c = 0; c < columns.size(); ++c)
		picture.text(x + kName + (double(c) + 0.5) * kCell, y + 12, columns[c].label, kMiddle);
	y += kLine;
	const bool isOfSteps = row.axis == "step";
	for (const double rate : isOfSteps ? std::vector<double>{0} : row.rates)
	{
		for (const Collider collider : kEveryCollider)
		{
			std::string label = name(collider);
			if (!isOfSteps) label += fmt::format(", 1/{:g} s", rate);
			picture.text(x + kName - 8, y + 12, label, kEnd);
			for (std::size_t c = 0; c < columns.size(); ++c)
			{
				Summary summary;
				for (const Cell* cell : matrix.cellsOf(index, collider))
					if (columns[c].isOf(*cell) && (isOfSteps || cell->setting.rate == rate)) summary.add(*cell);
				picture.cell(x + kName + double(c) * kCell, y, summary,
							 fmt::format("{} {}, {}: {}", row.id, label, columns[c].label, name(summary.verdict)));
			}
			y += kLine;
		}
		y += 4;
	}
	return y + 12;
}

// Every row in one line: the worst of its cases, rates and quantities.
void drawRows(Picture& picture, const Matrix& matrix, double x, double y)
{
	picture.text(x, y + 12, "All rows, the worst of their cases and steps", kBold);
	y += kLine + 2;
	for (std::size_t c = 0; c < kColliders; ++c)
		picture.text(x + kWords + (double(c) + 0.5) * kCell, y + 12, name(kEveryCollider[c]), kMiddle);
	y += kLine;
	for (std::size_t row = 0; row < matrix.rows.size(); ++row)
	{
		picture.text(x, y + 12, fmt::format("{}  {}", matrix.rows[row].id, matrix.rows[row].shows));
		for (std::size_t c = 0; c < kColliders; ++c)
		{
			Summary summary;
			for (const Cell* cell : matrix.cellsOf(row, kEveryCollider[c])) summary.add(*cell);
			picture.cell(x + kWords + double(c) * kCell, y, summary,
						 fmt::format("{} {}: {}", matrix.rows[row].id, name(kEveryCollider[c]), name(summary.verdict)));
		}
		y += kLine;
	}
}

double drawLegend(Picture& picture, double x, double y)
{
	picture.text(x, y + 14, "Where contacts hold", "font-weight=\"bold\" font-size=\"16\"");
	picture.text(
		x + 190, y + 14,
		"In a cell: its worst error as a share of its bound; *: somewhere one of Bullet's shapes does better.");
	y += kLine + 3;
	picture.text(
		x, y + 14,
		"primitive, mesh: Bullet's own solid, Bullet's best shape of the same mesh; exact, 0.5 %, 3.5 %: ours.");
	y += 24;
	const std::vector<std::pair<Verdict, std::string>> entries = {
		{Verdict::holds, "within its bound"},
		{Verdict::asBullet, "beyond it, no worse than allowed beside Bullet's mesh"},
		{Verdict::limit, "a known limit"},
		{Verdict::outside, "outside"},
		{Verdict::notApplicable, "not applicable"}};
	for (const auto& [verdict, words] : entries)
	{
		picture.cell(x, y, verdict, "", words);
		picture.text(x + kCell + 4, y + 12, words);
		x += kCell + 24 + kLetter * double(words.size());
	}
	return y + kLine + 12;
}
}  // namespace

std::string validityMap(const Matrix& matrix)
{
	Picture picture;
	const double top = drawLegend(picture, kMargin, kMargin);
	double y = top, right = kMargin;
	for (std::size_t row = 0; row < matrix.rows.size(); ++row)
	{
		if (matrix.rows[row].axis.empty()) continue;
		y = drawAxis(picture, matrix, row, kMargin, y);
		right = std::max({right, kMargin + kName + double(columnsOf(matrix.rows[row]).size()) * kCell,
						  kMargin + kShows + kLetter * double(headOf(matrix.rows[row]).size())});
	}
	drawRows(picture, matrix, right + 2 * kMargin, top);
	return picture.whole();
}
}  // namespace clod::demo
