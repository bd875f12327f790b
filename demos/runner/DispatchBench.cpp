// SPDX-License-Identifier: Zlib
// Dispatch times of our shape and of btGImpactMeshShape, on the same meshes and poses in one run.
#include "demos/runner/DispatchBench.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "demos/peers/BulletPeers.h"
#include "demos/peers/PeerMesh.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
// Bullet's constants are absolute; tableware in metres is scaled to centimetres, as in the scenes.
constexpr double kWorldScale = 100;

struct DispatchRows
{
	std::vector<double> microseconds, points;
};

struct BothStates
{
	DispatchRows moving, atRest;  // as recorded; without velocities
};

// Whole passes; a row keeps its least time.
DispatchRows measure(Peer& peer, const PoseSample& sample, int repeat)
{
	DispatchRows rows;
	for (int pass = 0; pass < repeat; ++pass)
	{
		const std::vector<PeerAnswer> answers = peer.pass(sample);
		for (std::size_t i = 0; i < answers.size(); ++i)
			if (pass == 0)
			{
				rows.microseconds.push_back(answers[i].microseconds);
				rows.points.push_back(double(answers[i].contacts.size()));
			}
			else
				rows.microseconds[i] = std::min(rows.microseconds[i], answers[i].microseconds);
	}
	return rows;
}

std::vector<double> select(const std::vector<double>& values, const std::vector<bool>& chosen)
{
	std::vector<double> result;
	for (std::size_t i = 0; i < values.size(); ++i)
		if (chosen[i]) result.push_back(values[i]);
	return result;
}

nlohmann::ordered_json compare(const std::vector<bool>& chosen, const std::vector<ReplayRow>& rows,
							   const BothStates& ours, const BothStates& peer)
{
	std::vector<double> queries;
	for (const ReplayRow& row : rows) queries.push_back(row.queryMicroseconds);
	const std::vector<double> query = select(queries, chosen), dispatch = select(ours.moving.microseconds, chosen),
							  gimpact = select(peer.moving.microseconds, chosen),
							  still = select(ours.atRest.microseconds, chosen),
							  stillGimpact = select(peer.atRest.microseconds, chosen);
	if (query.empty()) return {{"rows", 0}};
	std::vector<double> ratios;
	for (std::size_t i = 0; i < dispatch.size(); ++i) ratios.push_back(dispatch[i] / gimpact[i]);
	return {{"rows", query.size()},
			{"query_us", spread(query)},
			{"clod_dispatch_us", spread(dispatch)},
			{"gimpact_dispatch_us", spread(gimpact)},
			{"clod_dispatch_at_rest_us", spread(still)},
			{"gimpact_dispatch_at_rest_us", spread(stillGimpact)},
			{"clod_points", spread(select(ours.moving.points, chosen))},
			{"gimpact_points", spread(select(peer.moving.points, chosen))},
			{"ratio_of_medians", quantile(dispatch, 0.5) / quantile(gimpact, 0.5)},
			{"ratio_of_medians_at_rest", quantile(still, 0.5) / quantile(stillGimpact, 0.5)},
			{"row_ratio", spread(ratios)}};
}
}  // namespace

nlohmann::ordered_json comparePeer(const HierarchyPointer& a, const HierarchyPointer& b,
								   const std::vector<PoseRow>& poses, const std::vector<ReplayRow>& rows,
								   const ReplayOptions& options)
{
	const double tolerance = options.tolerance.inMeshUnit(smallerRadius(*a, *b));
	PoseSample sample;
	sample.dt = options.dt;
	sample.tolerance = tolerance;
	for (std::size_t i = 0; i < poses.size(); ++i) sample.rows.push_back(recordedRow(poses, i, {options.dt}));
	const PairFrame frame = pairFrame(*a, *b, kWorldScale, tolerance);
	const PeerPointer clod = clodDispatch({}, a, b, {"", options.metric, kOff, options.budget, options.camera}, frame);
	const PeerPointer other = gimpact({}, inputSurface(*a), inputSurface(*b), frame);
	const PoseSample still = sample.atRest();
	const BothStates ours = {measure(*clod, sample, options.repeat), measure(*clod, still, options.repeat)};
	const BothStates peer = {measure(*other, sample, options.repeat), measure(*other, still, options.repeat)};
	std::vector<bool> all(rows.size(), true), moving;
	for (const ReplayRow& row : rows) moving.push_back(row.contact(tolerance) && row.motion() == Motion::moving);
	return {{"peer", "btGImpactMeshShape"},
			{"world_scale", kWorldScale},
			{"gimpact_margin", tolerance / 2},
			{"all_rows", compare(all, rows, ours, peer)},
			{"moving_contact_rows", compare(moving, rows, ours, peer)}};
}

void printPeer(const nlohmann::ordered_json& peer)
{
	fmt::print(
		"\nwhole dispatches of Bullet, {} against itself on the same meshes, median us: bodies moving as recorded, and "
		"the same poses at rest\n{:<22}{:>8}{:>12}{:>12}{:>10}{:>12}{:>12}{:>10}{:>12}\n",
		peer["peer"].get<std::string>(), "rows", "count", "clod", "peer", "ratio", "clod rest", "peer rest", "ratio",
		"query alone");
	for (const char* name : {"all_rows", "moving_contact_rows"})
	{
		const auto& figures = peer[name];
		if (figures["rows"] == 0) continue;
		const auto median = [&](const char* key) { return figures[key]["median"].get<double>(); };
		fmt::print("{:<22}{:>8}{:>12.1f}{:>12.1f}{:>10.2f}{:>12.1f}{:>12.1f}{:>10.2f}{:>12.1f}\n", name,
				   figures["rows"].get<std::size_t>(), median("clod_dispatch_us"), median("gimpact_dispatch_us"),
				   figures["ratio_of_medians"].get<double>(), median("clod_dispatch_at_rest_us"),
				   median("gimpact_dispatch_at_rest_us"), figures["ratio_of_medians_at_rest"].get<double>(),
				   median("query_us"));
	}
}
}  // namespace clod::demo
