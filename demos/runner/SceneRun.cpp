// SPDX-License-Identifier: Zlib
// The loop of clod-bench run, its rows and its summary.
#include "demos/runner/SceneRun.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "cli/Failure.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
// The last rows, over which "comes to rest" is judged.
constexpr std::size_t kEndRows = 24;
constexpr double kNoise = 0.01;

void requireFinite(const SceneState& state)
{
	for (const BodyState& body : state.bodies)
	{
		double sum = 0;
		for (int i = 0; i < 3; ++i) sum += body.pose.position[i];
		for (const double component : body.pose.quaternion) sum += component;
		if (!std::isfinite(sum) || !isFinite(body.velocity) || !isFinite(body.turning))
			throw cli::Failure(cli::ExitCode::failure,
							   fmt::format("step {}: a pose or velocity is not finite", state.step));
	}
}

// The largest of all bodies.
double fastest(const SceneState& state, Vec3 BodyState::*velocity)
{
	double speed = 0;
	for (const BodyState& body : state.bodies) speed = std::max(speed, length(body.*velocity));
	return speed;
}

double share(const std::vector<SceneRow>& rows, bool (*holds)(const SceneRow&, double), double tolerance)
{
	const auto count = std::count_if(rows.begin(), rows.end(), [&](const SceneRow& r) { return holds(r, tolerance); });
	return double(count) / double(rows.size());
}

std::vector<double> column(const std::vector<SceneRow>& rows, double (*value)(const SceneRow&))
{
	std::vector<double> values;
	std::transform(rows.begin(), rows.end(), std::back_inserter(values), value);
	return values;
}

nlohmann::ordered_json warningsOf(const std::vector<SceneRow>& rows)
{
	std::set<std::string> seen;
	nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
	for (const SceneRow& row : rows)
		for (const std::string& warning : row.state.warnings)
			if (seen.insert(warning).second) warnings.push_back({{"step", row.state.step}, {"warning", warning}});
	return warnings;
}

nlohmann::ordered_json endOf(const std::vector<SceneRow>& rows)
{
	const std::vector<SceneRow> last(rows.end() - std::min(rows.size(), kEndRows), rows.end());
	const double speed = quantile(column(last, [](const SceneRow& r) { return r.query.speed; }), 1);
	const double linear =
		quantile(column(last, [](const SceneRow& r) { return fastest(r.state, &BodyState::velocity); }), 1);
	return {{"rows", last.size()},
			{"largest_speed_radii_per_s", speed},
			{"largest_speed_m_per_s", linear},
			{"at_rest", classify(speed) == Motion::rest}};
}

// Contacts, levels, front, tests and time of a row: those of the step's own dispatch.
void takeFromDispatch(ReplayRow& row, const SceneState& state)
{
	std::vector<ReplayRow> pairs;
	for (const PairAnswer& answer : state.answers)
	{
		pairs.emplace_back();
		pairs.back().contacts = answer.result.contacts.size();
		pairs.back().excess = answer.result.excess;
		pairs.back().stats = answer.result.stats;
	}
	const ReplayRow sum = sumOfPairs(pairs, 0);
	row.contacts = sum.contacts;
	row.excess = sum.excess;
	row.stats = sum.stats;
	row.queryMicroseconds = state.queryMicroseconds;
}
}  // namespace

Bodies SceneRunOptions::bodies() const
{
	return bodiesOf(info, scene.models);
}

ReplayOptions SceneRunOptions::queries() const
{
	ReplayOptions options;
	options.metric = scene.metric;
	options.camera = scene.camera;
	options.tolerance.value = info.tolerance;
	options.paper = paper;
	options.fresh = fresh;
	options.dt = scene.dt;
	return options;
}

std::vector<SceneRow> runScene(Scene& scene, const SceneRunOptions& options,
							   const std::function<void(double)>& progress)
{
	std::vector<SceneRow> rows;
	PairQueries queries(options.bodies(), options.queries());
	for (int step = 0; step < options.steps; ++step)
	{
		scene.step();
		SceneRow row{scene.state(), {}, std::nan(""), {}};
		requireFinite(row.state);
		for (const PoseRow& poses : posesOf(row.state)) row.pairs.push_back(queries.at(poses));
		row.query = sumOfPairs(row.pairs, options.info.tolerance);
		if (options.scene.budget.isLimited()) takeFromDispatch(row.query, row.state);
		rows.push_back(std::move(row));
		progress(double(step + 1) / options.steps);
	}
	return rows;
}

std::vector<PoseRow> posesOf(const SceneState& state)
{
	std::vector<PoseRow> poses;
	for (const BodyPair& pair : state.pairs)
		poses.push_back({state.step, state.bodies[pair.a].pose, state.bodies[pair.b].pose, pair.a, pair.b});
	return poses;
}

std::vector<PoseRow> simulatePoses(const SceneRunOptions& options, const std::function<void(double)>& progress)
{
	const std::unique_ptr<Scene> scene = makeScene(options.info.name, options.scene);
	std::vector<PoseRow> poses;
	for (int step = 0; step < options.steps; ++step)
	{
		scene->step();
		const std::vector<PoseRow> ofStep = posesOf(scene->state());
		poses.insert(poses.end(), ofStep.begin(), ofStep.end());
		progress(double(step + 1) / options.steps);
	}
	return poses;
}

std::vector<PoseRow> posesOf(const std::vector<SceneRow>& rows)
{
	std::vector<PoseRow> poses;
	for (const SceneRow& row : rows)
	{
		const std::vector<PoseRow> ofStep = posesOf(row.state);
		poses.insert(poses.end(), ofStep.begin(), ofStep.end());
	}
	return poses;
}

std::string trajectoryHash(const std::vector<SceneRow>& rows)
{
	std::vector<Pose> poses;
	for (const SceneRow& row : rows)
		for (const BodyState& body : row.state.bodies) poses.push_back(body.pose);
	return trajectoryHash(poses);
}

std::string formatSceneRows(const SceneInfo& info, const std::vector<SceneRow>& rows)
{
	// Of two bodies, a row has the poses too.
	std::string text =
		std::string(info.isPair() ? kPosesHeader : "step") +
		",time,gap,error_bound,contacts,points,manifolds,finest_level,coarsest_level,front,hull_tests,"
		"query_us,gap_us,dispatch_us,step_us,speed_m_per_s,turning_rad_per_s,speed_radii_per_s,motion,deep,pairs,"
		"pending,excess,dispatch_error_bound,touched_finest_level,still_apart,front_kept,front_came,front_gone,skipped_"
		"by_slack,depths_cut_short,energy_j,kinetic_j,deepest_m";
	for (const OutcomeName& name : info.outcome) text += "," + name.name;
	text += "\n";
	for (const SceneRow& row : rows)
	{
		const SceneState& s = row.state;
		const ReplayRow& q = row.query;
		text += info.isPair() ? formatPose(posesOf(s).front()) : std::to_string(s.step);
		text += fmt::format(
			",{},{},{},{},{},{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.6g},{:.6g},{:.5g},{},{},{},{},{},{}",
			number(s.time), number(q.minDistance), number(q.errorBound), q.contacts, s.points.size(), s.manifolds,
			q.stats.finestLevel, q.stats.coarsestLevel, q.stats.front, q.tests(), q.queryMicroseconds,
			q.gapMicroseconds, s.dispatchMicroseconds, s.stepMicroseconds, fastest(s, &BodyState::velocity),
			fastest(s, &BodyState::turning), q.speed, name(q.motion()), int(q.deep), s.pairs.size(), q.stats.pending,
			number(q.excess), number(s.contactError));
		text +=
			fmt::format(",{},{},{},{},{},{},{},{},{},{}", q.stats.touchedFinestLevel, q.stats.stillApart,
						q.stats.frontKept, q.stats.frontCame, q.stats.frontGone, q.stats.skippedBySlack,
						q.stats.depthsCutShort, number(s.energy()), number(s.kinetic), number(row.deepest));
		for (const double value : s.outcome) text += "," + number(value);
		text += "\n";
	}
	return text;
}

nlohmann::ordered_json summarizeEnergy(const SceneState& start, const std::vector<SceneRow>& rows)
{
	const auto energies = column(rows, [](const SceneRow& r) { return r.state.energy(); });
	return {{"unit", "J"},
			{"initial", start.energy()},
			{"initial_kinetic", start.kinetic},
			{"final", energies.back()},
			{"final_kinetic", rows.back().state.kinetic},
			{"least", quantile(energies, 0)},
			{"largest", quantile(energies, 1)}};
}

nlohmann::ordered_json summarizeOutcome(const SceneInfo& info, const SceneState& start,
										const std::vector<SceneRow>& rows)
{
	nlohmann::ordered_json outcome = nlohmann::ordered_json::object();
	for (std::size_t i = 0; i < info.outcome.size(); ++i)
	{
		std::vector<double> values = {start.outcome[i]};
		for (const SceneRow& row : rows) values.push_back(row.state.outcome[i]);
		nlohmann::ordered_json& told = outcome[info.outcome[i].name];
		told = {{"unit", info.outcome[i].unit},
				{"initial", values.front()},
				{"final", values.back()},
				{"least", quantile(values, 0)},
				{"largest", quantile(values, 1)}};
		if (!info.outcome[i].isSwing) continue;
		const std::vector<double> amplitudes = swingAmplitudes(values, kNoise);
		double growth = 0;
		for (std::size_t k = 1; k < amplitudes.size(); ++k) growth = std::max(growth, amplitudes[k] / amplitudes[k - 1]);
		told["swings"] = amplitudes.size();
		told["first_amplitude"] = amplitudes.empty() ? 0 : amplitudes.front();
		told["last_amplitude"] = amplitudes.empty() ? 0 : amplitudes.back();
		told["largest_growth"] = growth;
	}
	return outcome;
}

nlohmann::ordered_json summarizeScene(const std::vector<SceneRow>& rows, double tolerance)
{
	const auto touching = [](const SceneRow& r, double limit) { return r.query.contact(limit); };
	const auto moving = [](const SceneRow& r, double) { return r.query.motion() == Motion::moving; };
	const auto resting = [](const SceneRow& r, double) { return r.query.motion() == Motion::rest; };
	const auto misplaced = std::find_if(rows.begin(), rows.end(), [](const SceneRow& r) { return !r.state.inPlace; });
	std::vector<ReplayRow> queries;
	for (const SceneRow& row : rows) queries.push_back(row.query);
	nlohmann::ordered_json summary = {
		{"rows", rows.size()},
		{"share_within_tolerance", share(rows, touching, tolerance)},
		{"share_moving", share(rows, moving, tolerance)},
		{"share_at_rest", share(rows, resting, tolerance)},
		{"moving_speed_radii_per_s", kMovingSpeed},
		{"rest_speed_radii_per_s", kRestSpeed},
		{"stays_in_place", misplaced == rows.end()},
		{"end", endOf(rows)},
		{"points", spread(column(rows, [](const SceneRow& r) { return double(r.state.points.size()); }))},
		{"pairs", spread(column(rows, [](const SceneRow& r) { return double(r.pairs.size()); }))},
		{"passes", spread(column(rows, [](const SceneRow& r) { return double(r.state.passes); }))},
		{"parts", spread(column(rows, [](const SceneRow& r) { return double(r.state.parts); }))},
		{"pairs_asked_again", spread(column(rows, [](const SceneRow& r) { return double(r.state.pairsAskedAgain); }))},
		{"dispatch_us", spread(column(rows, [](const SceneRow& r) { return r.state.dispatchMicroseconds; }))},
		{"step_us", spread(column(rows, [](const SceneRow& r) { return r.state.stepMicroseconds; }))},
		{"queries", summarize(queries, tolerance)},
		{"warnings", warningsOf(rows)}};
	if (misplaced != rows.end()) summary["left_place_at_step"] = misplaced->state.step;
	return summary;
}
}  // namespace clod::demo
