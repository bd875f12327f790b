// SPDX-License-Identifier: Zlib
#include "demos/trial/TrialRuns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "demos/runner/SceneRun.h"
#include "demos/runner/Selection.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr double kEndSeconds = 0.1;
// Of the smaller radius: bodies of ours rest 0.05 % of it apart, and what is a millimetre off a radius of one metre
// touches.
constexpr double kTouching = 1e-3;

bool isFinite(const SceneState& state)
{
	return std::all_of(state.bodies.begin(), state.bodies.end(),
					   [](const BodyState& b)
					   { return clod::isFinite(b.pose.position) && clod::isFinite(b.velocity); });
}

// What no contender's own code says of it.
class Judge
{
public:
	Judge(const Trial& trial, const Solids& solids) : m_trial(trial), m_solids(solids) {}

	double deepest(const SceneState& state)
	{
		double deepest = 0;
		for (const PoseRow& poses : posesOf(state))
		{
			const auto meter = m_meters.try_emplace({poses.bodyA, poses.bodyB}, solid(poses.bodyA), solid(poses.bodyB));
			deepest = std::max(deepest, meter.first->second.depth(relativePose(poses, {}, {})));
		}
		return deepest;
	}
	// The contact points of bodies that touch are said to lie on the two surfaces, where those were before the step.
	// Points of bodies still apart are for what the step may bring together: their place on the second body is where
	// that will be met. A share: see TrialFrame.
	double offSurface(const SceneState& before, const std::vector<ScenePoint>& points) const
	{
		double farthest = std::nan("");
		for (const ScenePoint& point : points)
		{
			const double smaller = std::min(radius(point.bodies.a), radius(point.bodies.b));
			if (point.distance > kTouching * smaller) continue;
			const Vec3 onA = point.position + point.distance * point.normal;
			const double off =
				std::max(distance(before, point.bodies.a, onA), distance(before, point.bodies.b, point.position));
			farthest = std::fmax(farthest, off / smaller);
		}
		return farthest;
	}

private:
	double radius(std::uint32_t body) const
	{
		return double(m_trial.models[m_trial.scene.info.bodies[body].model]->asset().radius);
	}
	std::shared_ptr<const SignedDistance> solid(std::uint32_t body) const
	{
		return m_solids[m_trial.scene.info.bodies[body].model];
	}
	double distance(const SceneState& state, std::uint32_t body, const Vec3& point) const
	{
		return std::fabs((*solid(body))(inverse(toTransform(state.bodies[body].pose)) * point));
	}
	const Trial& m_trial;
	const Solids& m_solids;
	std::map<std::pair<std::uint32_t, std::uint32_t>, PenetrationMeter> m_meters;
};

SceneSettings settingsOf(const Trial& trial, const Contender& contender, double dt)
{
	SceneSettings settings;
	settings.models = trial.models;
	settings.shapes = contender.shapes;
	settings.metric = ContactMetric::errorShare(kDefaultMaxError);
	settings.dt = dt;
	settings.printsWarnings = false;
	settings.timedBy = TimedBy::thread;
	return settings;
}

// How many bodies are not where the scene means them to be.
int goneIn(const Trial& trial, const SceneState& state)
{
	int gone = 0;
	for (std::size_t i = 0; i < state.bodies.size(); ++i)
	{
		const Vec3 center = toTransform(state.bodies[i].pose) * meshFromBody(*trial.models[trial.scene.info.bodies[i].model]);
		if (trial.scene.bodies[i].mass > 0 && !trial.scene.inPlace(i, center)) ++gone;
	}
	return gone;
}

void summarize(TrialRun& run, const Trial& trial, const std::vector<double>& steps)
{
	run.stepMedian = quantile(steps, 0.5);
	run.stepP95 = quantile(steps, 0.95);
	std::vector<double> off;
	for (const TrialFrame& frame : run.frames)
	{
		run.deepest = std::max(run.deepest, frame.deepest);
		if (!std::isnan(frame.offSurface)) off.push_back(frame.offSurface);
	}
	run.worst = worstFrame(run.frames);
	run.offSurfaceMedian = quantile(off, 0.5);
	run.offSurfaceP95 = quantile(off, 0.95);
	if (run.frames.empty()) return;
	const double end = run.frames.back().state.time;
	for (const TrialFrame& frame : run.frames)
		if (frame.state.time >= end - kEndSeconds)
			for (const BodyState& body : frame.state.bodies)
				run.endSpeed = std::max(run.endSpeed, length(body.velocity) / trial.radius);
	run.gone = goneIn(trial, run.frames.back().state);
}
}  // namespace

std::size_t worstFrame(const std::vector<TrialFrame>& frames)
{
	const auto off = [](const TrialFrame& frame) { return std::fmax(frame.offSurface, 0.0); };  // NaN without contacts
	const auto isMilder = [&](const TrialFrame& l, const TrialFrame& r)
	{ return l.deepest != r.deepest ? l.deepest < r.deepest : l.deepest <= 0 && off(l) < off(r); };
	return std::size_t(std::max_element(frames.begin(), frames.end(), isMilder) - frames.begin());
}

TrialRun runContender(const Trial& trial, const Contender& contender, const Solids& solids, const TrialRules& rules,
					  const std::function<void(double)>& progress)
{
	TrialRun run;
	Judge judge(trial, solids);
	const std::unique_ptr<Scene> scene = makeScene(trial.scene, settingsOf(trial, contender, rules.dt));
	std::vector<double> steps, sinceFrame;
	SceneState before = scene->state();
	const auto canMove = [](const BodyDefinition& body) { return body.mass > 0; };
	const auto movable = std::count_if(trial.scene.bodies.begin(), trial.scene.bodies.end(), canMove);
	const Stopwatch watch(TimedBy::thread);  // a busy machine stops nobody
	for (int step = 1; step <= rules.steps; ++step)
	{
		scene->step();
		SceneState state = scene->state();
		if (!isFinite(state))
		{
			run.ending = fmt::format("a body's place stopped being a number at {:.2f} s", state.time);
			break;
		}
		steps.push_back(state.stepMicroseconds);
		sinceFrame.push_back(state.stepMicroseconds);
		if (step % rules.every == 0)
		{
			TrialFrame frame;
			frame.stepMicroseconds = quantile(std::move(sinceFrame), 0.5);
			sinceFrame.clear();
			frame.deepest = judge.deepest(state);
			frame.offSurface = judge.offSurface(before, state.points);
			frame.state = state;
			run.frames.push_back(std::move(frame));
			progress(double(step) / rules.steps);
			if (goneIn(trial, state) == movable)  // steps without bodies would take no time
			{
				run.ending = fmt::format("stopped at {:.2f} s: all bodies fell through or flew off", state.time);
				break;
			}
		}
		before = std::move(state);
		const double seconds = watch.microseconds() / 1e6;
		if (seconds > rules.mostSeconds)
		{
			run.ending = fmt::format("stopped at {:.2f} s of {:.2f}: it had taken {:.0f} s", step * rules.dt,
									 rules.steps * rules.dt, seconds);
			break;
		}
	}
	summarize(run, trial, steps);
	return run;
}
}  // namespace clod::demo
