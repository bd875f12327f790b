// SPDX-License-Identifier: Zlib
// Queries over a sequence of poses, without dynamics: one query a row, caches warm from the pair's row before.
#pragma once
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clod/distance/SignedGap.h"
#include "clod/query/ContactMetric.h"
#include "clod/schedule/BudgetControl.h"
#include "cli/Length.h"
#include "demos/runner/Motion.h"
#include "demos/scenes/CameraPath.h"
#include "demos/scenes/Poses.h"

namespace clod::demo
{
// The bodies that a row's bodyA and bodyB count; several may be the same hierarchy.
using Bodies = std::vector<const Hierarchy*>;
struct ReplayOptions  // lengths: shares are of a pair's smaller radius
{
	ContactMetric metric;
	std::optional<CameraPath> camera;  // of view metrics; the meshes' unit
	Budget budget;                     // of every query, kept as a world keeps it over its steps
	cli::Length tolerance;
	std::optional<cli::Length> gapError;  // GapSettings::gapError
	bool distance = false, paper = false;
	bool contactsOnly = false;  // no gap is asked for
	int repeat = 1;             // whole passes, all caches dropped before each; a row keeps its least time
	bool fresh = false;         // caches dropped before every row as well
	double dt = 1.0 / 240;
};

// What a pair is asked at a pose it moves through; `motion` in the body frame of A.
GapSettings settingsOf(const ReplayOptions& options, const Hierarchy& a, const Hierarchy& b, const PoseRow& poses,
					const RelativeMotion& motion);
// Empty when all pairs of the bodies can be asked, otherwise one sentence naming the field and its value.
std::string optionsError(const ReplayOptions& options, const Bodies& bodies);

struct ReplayRow
{
	std::int64_t step = 0;
	std::uint32_t bodyA = 0, bodyB = 1;
	double queryMicroseconds = 0;  // up to the contact list
	double gapMicroseconds = 0;    // contact list, signed gap and its certificate
	std::size_t contacts = 0;
	std::size_t churn = 0;  // node pairs that came into the contact list or left it since the pair's last row
	double minDistance = 0, errorBound = 0;
	bool deep = false;
	double excess = 0;  // under a budget: by which factor the metric was missed; 0: it was met
	QueryStats stats;
	std::uint32_t finestA = kNone, finestB = kNone;  // levels of each body's contacts; kNone: there are none
	double speed = 0;  // of B's fastest point seen from A, in smaller radii a second; 0 in the first row
	// Hull distances and culling boxes compared.
	std::uint64_t tests() const { return std::uint64_t(stats.hullTests) + stats.boxTests; }
	Motion motion() const { return classify(speed); }
	bool contact(double tolerance) const { return minDistance <= tolerance; }
};

// Runs all passes. Throws cli::Failure (4) should a pass answer differently from the first: a query is a pure function.
std::vector<ReplayRow> replay(const Bodies& bodies, const std::vector<PoseRow>& poses, const ReplayOptions& options,
							  const std::function<void(double)>& progress);

// Answers one pose of a pair after another: a query up to the contact list, which is timed as such, then one with the
// signed gap. Each has its own caches.
class MeasuredQuery
{
public:
	MeasuredQuery(const Hierarchy& a, const Hierarchy& b, const ReplayOptions& options)
		: m_a(a), m_b(b), m_fresh(options.fresh), m_paper(options.paper), m_contactsOnly(options.contactsOnly)
	{
	}
	ReplayRow at(const PoseRow& poses, const GapSettings& settings);

private:
	double timedContacts(const Transform& aFromB, const ContactSettings& settings);
	double timedGap(const Transform& aFromB, const GapSettings& settings);

	const Hierarchy &m_a, &m_b;
	bool m_fresh, m_paper, m_contactsOnly;
	PairCache m_contactCache;
	GapCache m_gapCache;
	BudgetControl m_control;
	GapResult m_contacts, m_gap;
	std::vector<std::pair<std::uint32_t, std::uint32_t>> m_previous, m_current;  // node pairs of the contact list
};

// A MeasuredQuery for every pair that turns up, and the pairs' speeds.
class PairQueries
{
public:
	PairQueries(Bodies bodies, const ReplayOptions& options);
	ReplayRow at(const PoseRow& poses);

private:
	struct Pair
	{
		MeasuredQuery query;
		std::optional<PoseRow> previous;
	};
	Bodies m_bodies;
	ReplayOptions m_options;
	std::map<std::pair<std::uint32_t, std::uint32_t>, Pair> m_pairs;
};

// Speed of B's fastest point seen from A between two poses, in smaller radii a second.
double relativeSpeed(const Hierarchy& a, const Hierarchy& b, const PoseRow& from, const PoseRow& to, double seconds);
// Seconds between the rows of one pair.
struct RowClock
{
	double dt = 1.0 / 240;
	// Of more than two bodies a pair may have been away in between: time goes by the rows' steps. Rows of two follow
	// each other whatever their steps are called.
	bool mayPause = false;
};
double secondsBetween(const PoseRow& from, const PoseRow& to, const RowClock& clock);
// Before each of successive rows of one pair; 0 in the first.
std::vector<double> relativeSpeeds(const Hierarchy& a, const Hierarchy& b, const std::vector<PoseRow>& poses,
								   const RowClock& clock);

// Velocity of A's material relative to B's that carries the one pose into the other, in A's body frame; its time step
// is `seconds`.
RelativeMotion relativeMotion(const Hierarchy& a, const Hierarchy& b, const PoseRow& from, const PoseRow& to,
							  double seconds);

// One row for all pairs of a step: sums of times, counts and contacts; the least gap, and what certifies it; the speed
// of the fastest pair within the tolerance (where none is, of the fastest).
ReplayRow sumOfPairs(const std::vector<ReplayRow>& pairs, double tolerance);
// sumOfPairs of every run of rows with one step.
std::vector<ReplayRow> sumsByStep(const std::vector<ReplayRow>& rows, double tolerance);

// What a pair is doing in each of successive rows.
enum class Regime
{
	apart,    // nothing within the tolerance
	impact,   // the first kImpactRows rows after that
	sliding,  // touching and not at rest
	resting
};
inline constexpr Regime kRegimes[] = {Regime::apart, Regime::impact, Regime::sliding, Regime::resting};
inline constexpr int kImpactRows = 12;  // 50 ms at 240 Hz
const char* name(Regime regime);
std::vector<Regime> regimesOf(const std::vector<ReplayRow>& rows, double tolerance);

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
