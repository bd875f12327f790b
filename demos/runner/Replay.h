// SPDX-License-Identifier: Zlib
// Queries over a sequence of poses, without dynamics: one query a row, caches warm from the row before.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/runner/Motion.h"
#include "demos/scenes/Poses.h"

namespace clod::demo
{
struct ReplayOptions
{
	Settings settings;
	int repeat = 1;      // whole passes, all caches dropped before each; a row keeps its least time
	bool fresh = false;  // caches dropped before every row as well
	double dt = 1.0 / 240;
};

struct ReplayRow
{
	std::int64_t step = 0;
	double queryMicroseconds = 0;  // up to the contact list
	double gapMicroseconds = 0;    // contact list, signed gap and its certificate
	std::size_t contacts = 0;
	double minDistance = 0, errorBound = 0;
	bool deep = false;
	QueryStats stats;
	double speed = 0;  // of B's fastest point seen from A, in smaller radii a second; 0 in the first row
	// Hull distances and culling boxes compared.
	std::uint64_t tests() const { return std::uint64_t(stats.hullTests) + stats.boxTests; }
	Motion motion() const { return classify(speed); }
	bool contact(double tolerance) const { return minDistance <= tolerance; }
};

// Runs all passes. Throws cli::Failure (4) should a pass answer differently from the first: a query is a pure function.
std::vector<ReplayRow> replay(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses,
							  const ReplayOptions& options, const std::function<void(double)>& progress);

// Answers one pose after another: a query up to the contact list, which is timed as such, then one with the signed gap.
// Each has its own caches.
class MeasuredQuery
{
public:
	MeasuredQuery(const Hierarchy& a, const Hierarchy& b, const Settings& settings, bool fresh)
		: m_a(a), m_b(b), m_settings(settings), m_fresh(fresh)
	{
	}
	ReplayRow at(const PoseRow& poses);

private:
	double timed(const Transform& aFromB, const Settings& settings, PairCache& cache, QueryResult& result) const;

	const Hierarchy &m_a, &m_b;
	Settings m_settings;
	bool m_fresh;
	PairCache m_contactCache, m_gapCache;
	QueryResult m_contacts, m_gap;
};

// Speed of B's fastest point seen from A before each row, in smaller radii a second.
std::vector<double> relativeSpeeds(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses,
								   double dt);

std::string formatReplay(const std::vector<ReplayRow>& rows);
// Times, fronts, tests and contacts over all rows, and over the moving rows that are in contact.
nlohmann::ordered_json summarize(const std::vector<ReplayRow>& rows, double tolerance);
// The shortest decimals that read back to the same bits; "inf" for infinity.
std::string number(double value);

inline double smallerRadius(const Hierarchy& a, const Hierarchy& b)
{
	return a.asset().radius < b.asset().radius ? a.asset().radius : b.asset().radius;
}
inline Vec3 meshFromBody(const Hierarchy& h)
{
	const double(&c)[3] = h.asset().meshFromBody;
	return {c[0], c[1], c[2]};
}
}  // namespace clod::demo
