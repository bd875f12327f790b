// SPDX-License-Identifier: Zlib
// Answers against the truth.
#include "demos/peers/Accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kNoNormal = 90;  // degrees: says nothing about the direction

// Points in cubes as wide as the search radius: neighbours are in 27 of them.
class PointGrid
{
public:
	PointGrid(const std::vector<PeerContact>& contacts, double radius) : m_contacts(contacts), m_radius(radius)
	{
		for (std::uint32_t i = 0; i < contacts.size(); ++i) m_cells[key(cellOf(contacts[i].point))].push_back(i);
	}
	// Calls visit(contact, distance) for every contact within the radius until it returns true; did one?
	template <class Visit>
	bool any(const Vec3& point, const Visit& visit) const
	{
		const Cell center = cellOf(point);
		Cell cell;
		for (cell[0] = center[0] - 1; cell[0] <= center[0] + 1; ++cell[0])
			for (cell[1] = center[1] - 1; cell[1] <= center[1] + 1; ++cell[1])
				for (cell[2] = center[2] - 1; cell[2] <= center[2] + 1; ++cell[2])
					if (anyInCell(cell, point, visit)) return true;
		return false;
	}

private:
	using Cell = std::array<std::int64_t, 3>;
	Cell cellOf(const Vec3& p) const
	{
		return {std::int64_t(std::floor(p.x / m_radius)), std::int64_t(std::floor(p.y / m_radius)),
				std::int64_t(std::floor(p.z / m_radius))};
	}
	// 21 bits a coordinate; cells that share a key only cost time, distances decide.
	static std::uint64_t key(const Cell& cell)
	{
		std::uint64_t result = 0;
		for (const std::int64_t c : cell) result = result << 21 | (std::uint64_t(c) & 0x1FFFFF);
		return result;
	}
	template <class Visit>
	bool anyInCell(const Cell& cell, const Vec3& point, const Visit& visit) const
	{
		const auto found = m_cells.find(key(cell));
		if (found == m_cells.end()) return false;
		for (const std::uint32_t i : found->second)
		{
			const double distance = length(m_contacts[i].point - point);
			if (distance <= m_radius && visit(m_contacts[i], distance)) return true;
		}
		return false;
	}

	const std::vector<PeerContact>& m_contacts;
	double m_radius;
	std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> m_cells;
};

double degreesOf(double cosine)
{
	return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / 3.14159265358979323846;
}

bool hasNormal(const PeerContact& contact)
{
	return lengthSquared(contact.normal) > 0.5;
}

// The smallest angle to an exact normal at the same place, else to the nearest one near it.
double normalError(const PeerContact& contact, const PointGrid& samePlace, const PointGrid& nearIt)
{
	if (!hasNormal(contact)) return kNoNormal;
	double cosine = -2, nearest = std::numeric_limits<double>::infinity();
	const auto closest = [&](const PeerContact& truth, double)
	{
		if (hasNormal(truth)) cosine = std::max(cosine, dot(contact.normal, truth.normal));
		return false;
	};
	samePlace.any(contact.point, closest);
	if (cosine >= -1.5) return degreesOf(cosine);
	const auto nearer = [&](const PeerContact& truth, double distance)
	{
		if (hasNormal(truth) && distance < nearest) nearest = distance, cosine = dot(contact.normal, truth.normal);
		return false;
	};
	nearIt.any(contact.point, nearer);
	return cosine >= -1.5 ? degreesOf(cosine) : kNoNormal;
}

double normalError(const std::vector<PeerContact>& reported, const PointGrid& samePlace, const PointGrid& nearIt)
{
	std::vector<double> angles;
	for (const PeerContact& contact : reported) angles.push_back(normalError(contact, samePlace, nearIt));
	return quantile(angles, 0.5);
}

double coveredShare(const ExactRow& exact, const PointGrid& reported, const AccuracyRules& rules)
{
	std::size_t wanted = 0, covered = 0;
	for (const PeerContact& truth : exact.contacts)
	{
		if (truth.distance > rules.tolerance / 2 || !hasNormal(truth)) continue;
		++wanted;
		const auto agrees = [&](const PeerContact& contact, double)
		{ return dot(contact.normal, truth.normal) >= rules.cosine; };
		if (reported.any(truth.point, agrees)) ++covered;
	}
	return wanted ? double(covered) / double(wanted) : kNaN;
}

double foundedShare(const std::vector<PeerContact>& reported, const PointGrid& exact, const AccuracyRules& rules)
{
	std::size_t founded = 0;
	for (const PeerContact& contact : reported)
	{
		const double bound = std::isnan(contact.bound) ? rules.tolerance : contact.bound;
		const double limit = contact.distance + bound + rules.rounding;
		const auto explains = [&](const PeerContact& truth, double) { return truth.distance <= limit; };
		if (exact.any(contact.point, explains)) ++founded;
	}
	return reported.empty() ? kNaN : double(founded) / double(reported.size());
}

std::vector<double> column(const std::vector<RowAccuracy>& rows, double RowAccuracy::*member)
{
	std::vector<double> values;
	for (const RowAccuracy& row : rows)
		if (!std::isnan(row.*member)) values.push_back(row.*member);
	return values;
}

double mean(const std::vector<double>& values)
{
	double sum = 0;
	for (const double value : values) sum += value;
	return values.empty() ? kNaN : sum / double(values.size());
}
}  // namespace

RowAccuracy compare(const ExactRow& exact, const PeerAnswer& answer, const AccuracyRules& rules)
{
	std::vector<PeerContact> reported;
	std::copy_if(answer.contacts.begin(), answer.contacts.end(), std::back_inserter(reported),
				 [&](const PeerContact& contact) { return contact.distance <= rules.tolerance; });
	const PointGrid exactGrid(exact.contacts, rules.near), reportedGrid(reported, rules.near),
		samePlace(exact.contacts, rules.place);
	RowAccuracy row;
	row.contacts = reported.size();
	row.missed = answer.gap > rules.tolerance;
	// Who reports nothing says that the gap exceeds the tolerance; a gap reported beyond it counts as it is.
	const double claimed = std::isinf(answer.gap) ? std::max(rules.tolerance, exact.gap) : answer.gap;
	row.gapError = std::isnan(claimed) ? std::numeric_limits<double>::infinity() : std::abs(claimed - exact.gap);
	row.normalError = normalError(reported, samePlace, exactGrid);
	row.covered = coveredShare(exact, reportedGrid, rules);
	row.founded = foundedShare(reported, exactGrid, rules);
	return row;
}

Accuracy summarize(const std::vector<RowAccuracy>& rows)
{
	const std::vector<double> gap = column(rows, &RowAccuracy::gapError),
							  normal = column(rows, &RowAccuracy::normalError),
							  covered = column(rows, &RowAccuracy::covered);
	std::vector<double> contacts;
	std::size_t missed = 0;
	for (const RowAccuracy& row : rows)
	{
		contacts.push_back(double(row.contacts));
		missed += row.missed ? 1 : 0;
	}
	Accuracy result;
	result.gapMedian = quantile(gap, 0.5);
	result.gapP95 = quantile(gap, 0.95);
	result.gapMax = quantile(gap, 1);
	result.normalMedian = quantile(normal, 0.5);
	result.normalP95 = quantile(normal, 0.95);
	result.coveredMean = mean(covered);
	result.coveredLow = quantile(covered, 0.05);
	result.foundedMean = mean(column(rows, &RowAccuracy::founded));
	result.contactsMedian = quantile(contacts, 0.5);
	result.missedShare = rows.empty() ? kNaN : double(missed) / double(rows.size());
	return result;
}
}  // namespace clod::demo
