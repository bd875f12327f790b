// SPDX-License-Identifier: Zlib
// Which frames of a run are painted, and from what.
#include "demos/runner/SceneFrames.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "cli/Failure.h"
#include "demos/runner/Film.h"

namespace clod::demo
{
namespace
{
// The threshold that an exact run is compared with: the paper's, as a share of the smaller radius.
constexpr double kComparedSize = 0.035;

// Answers at chosen moments of a run under one metric. Under a budget, which the pairs of a step share, those that the
// step's own dispatch gave.
class Answers
{
public:
	Answers(const FinishedRun& run, SceneSettings scene, std::string selection)
		: m_run(run), m_options(run.options), m_selection(std::move(selection))
	{
		m_options.scene = std::move(scene);
		m_options.fresh = false;
	}
	// Times of warm queries over all rows; without this call, the run's own.
	void measureAll()
	{
		if (isOfDispatch()) return;
		PairQueries queries(m_options.bodies(), m_options.queries());
		for (const SceneRow& row : m_run.rows)
		{
			std::vector<ReplayRow> pairs;
			for (const PoseRow& poses : posesOf(row.state)) pairs.push_back(queries.at(poses));
			m_rows.push_back(sumOfPairs(pairs, m_options.info.tolerance));
		}
	}
	FrameAnswer at(std::size_t row) const
	{
		const Bodies bodies = m_options.bodies();
		FrameAnswer answer{m_selection, {}, m_rows.empty() ? m_run.rows[row].query : m_rows[row]};
		if (isOfDispatch())
		{
			answer.pairs = m_run.rows[row].state.answers;
			return answer;
		}
		for (const PoseRow& poses : posesOf(m_run.rows[row].state))
		{
			const Hierarchy &a = *bodies[poses.bodyA], &b = *bodies[poses.bodyB];
			// Contacts as in the simulation, and as they are counted.
			PairCache cache;
			GapResult result;
			contacts(a, b, relativePose(poses, meshFromBody(a), meshFromBody(b)),
					 settingsOf(m_options.queries(), a, b, poses, motionBefore(row, poses)), cache, result);
			answer.pairs.push_back({{poses.bodyA, poses.bodyB}, std::move(result)});
		}
		return answer;
	}

private:
	bool isOfDispatch() const { return m_options.scene.budget.isLimited(); }
	// How the pair moved in the step before the row; at rest where it was not followed then.
	RelativeMotion motionBefore(std::size_t row, const PoseRow& poses) const
	{
		const Bodies bodies = m_options.bodies();
		if (row > 0)
			for (const PoseRow& before : posesOf(m_run.rows[row - 1].state))
				if (before.bodyA == poses.bodyA && before.bodyB == poses.bodyB)
					return relativeMotion(*bodies[poses.bodyA], *bodies[poses.bodyB], before, poses,
										  m_options.scene.dt);
		RelativeMotion still;
		still.timeStep = m_options.scene.dt;
		return still;
	}

	const FinishedRun& m_run;
	SceneRunOptions m_options;
	std::string m_selection;
	std::vector<ReplayRow> m_rows;
};

FrameMoment momentOf(const SceneState& state)
{
	FrameMoment moment{state.step, {}};
	for (const BodyState& body : state.bodies) moment.poses.push_back(body.pose);
	return moment;
}

std::vector<FrameContact> pointsOf(const SceneState& state)
{
	std::vector<FrameContact> contacts;
	// Others are what a body may come to within the step.
	for (const ScenePoint& point : state.points)
		if (point.impulse > 0) contacts.push_back({point.position, point.normal});
	return contacts;
}

}  // namespace

void addFrames(CLI::App& command, SceneFrameOptions& options)
{
	CLI::Option* frames = command.add_option("--frames", options.directory,
											 "Write PNG frames, a contact sheet and, with ffmpeg, a film into DIR");
	frames->type_name("DIR");
	command.add_option("--frame-every", options.every, "Steps between frames (default: 30 a second, and 150 at least)")
		->type_name("N")
		->check(CLI::Range(1, 1'000'000))
		->needs(frames);
	command
		.add_flag("--compare", options.compare, "Frames show exact beside the selection (beside 3.5 % in an exact run)")
		->needs(frames);
}

nlohmann::ordered_json paintScene(const SceneFrameOptions& options, FrameSubject subject, const FinishedRun& run,
								  const std::function<void(double)>& progress)
{
	const SceneSettings& own = run.options.scene;
	SceneSettings full = own, coarse = own;
	full.metric = ContactMetric::exactly();
	full.budget = Budget{};
	std::string coarseName = run.selection;
	if (own.metric.exact)
	{
		coarse.metric = ContactMetric::deviationShare(kComparedSize);
		coarse.budget = Budget{};
		coarseName = "paper's threshold 3.5 % of the radius";
	}
	Answers answers(run, own, run.selection), exact(run, full, "exact: full resolution"),
		other(run, coarse, coarseName);
	if (options.compare) exact.measureAll(), other.measureAll();

	const std::size_t every =
		std::size_t(options.every > 0 ? options.every : frameEvery(int(run.rows.size()), subject.dt));
	const std::size_t count = (run.rows.size() + every - 1) / every;
	const auto rowOf = [&](std::size_t frame) { return std::min((frame + 1) * every, run.rows.size()) - 1; };
	subject.largestError = 0;
	for (std::size_t i = 0; i < count; ++i)
		for (const Answers* of : {&answers, &exact, &other})
			if (of == &answers || options.compare)
				subject.largestError = std::max(subject.largestError, largestErrorShown(subject, of->at(rowOf(i))));
	FramePainter painter(subject);
	FrameFolder folder(options.directory, subject.title, count, 1 / (double(every) * subject.dt));
	// The frame that shows the most patches in contact.
	std::size_t most = 0, mostRow = 0;
	while (folder.frames() < count)
	{
		const std::size_t row = rowOf(folder.frames());
		const SceneState& state = run.rows[row].state;
		const FrameAnswer answer = answers.at(row);
		if (const std::size_t patches = patchesShown(subject, answer); patches > most) most = patches, mostRow = row;
		const Image image = options.compare ? painter.paintComparison(momentOf(state), exact.at(row), other.at(row))
											: painter.paint(momentOf(state), answer, pointsOf(state));
		folder.add(image, fmt::format("step {}", state.step));
		progress(double(folder.frames()) / double(count));
	}
	std::vector<std::string> files = folder.finish();
	if (most > 0)
	{
		files.push_back(options.directory + "/exploded.png");
		const std::string title = subject.title + ": patches in contact, pulled apart";
		const Result<std::size_t> written =
			writePng(files.back(), painter.paintExploded(momentOf(run.rows[mostRow].state), answers.at(mostRow)),
					 {{"Title", title}});
		if (!written) throw cli::Failure(cli::ExitCode::failure, written.error());
	}
	return {{"directory", options.directory}, {"frames", folder.frames()}, {"every", every}, {"files", files}};
}
}  // namespace clod::demo
