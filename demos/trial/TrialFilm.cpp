// SPDX-License-Identifier: Zlib
#include "demos/trial/TrialFilm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/Failure.h"
#include "demos/render/Overlay.h"
#include "demos/render/Renderer.h"
#include "demos/runner/Film.h"
#include "demos/runner/InputSurface.h"
#include "demos/runner/Replay.h"

namespace clod::demo
{
namespace
{
constexpr double kWorstRadii = 2.0;  // what those pictures show, in the largest mesh's radii
constexpr double kAzimuth = 20, kElevation = 18;
constexpr double kFollow = 0.1;    // of the way to what it should see the camera goes a frame
constexpr double kRoom = 1.15;     // round what a picture shows: its words
constexpr double kFadeRadii = 12;  // of the ground, from the middle of the picture
constexpr std::size_t kMostMarkers = 200;
// Of larger meshes a level is drawn whose error, a share of the radius, is a fraction of a pixel.
constexpr std::uint32_t kManyTriangles = 50000;
constexpr double kUnseen = 0.002;
constexpr Color kBodyColors[] = {{0.80f, 0.68f, 0.45f, 1}, {0.50f, 0.66f, 0.78f, 1}, {0.62f, 0.73f, 0.53f, 1}};
constexpr Color kHullColor = {0.35f, 0.35f, 0.75f, 0.16f};
constexpr Color kContactColor = {0.85f, 0.1f, 0.1f, 1};

ModelMesh drawnSurface(const Hierarchy& hierarchy)
{
	std::uint32_t level = 0;
	if (hierarchy.asset().triangleCount > kManyTriangles)
		for (std::uint32_t next = 1; next <= hierarchy.coarsestClodLevel(); ++next)
			if (double(hierarchy.levels()[next].maxDeviation) <= kUnseen * double(hierarchy.asset().radius)) level = next;
	return levelSurface(hierarchy, level);
}

class TrialPainter
{
public:
	TrialPainter(const Trial& trial, const FilmRules& rules) : m_trial(trial)
	{
		auto renderer = Renderer::create(rules.width, rules.width * 3 / 4, rules.supersampling);
		if (!renderer) throw cli::Failure(cli::ExitCode::failure, renderer.error());
		m_renderer = std::move(renderer.value());
		for (const HierarchyPointer& model : trial.models) m_meshes.push_back(upload(drawnSurface(*model)));
		m_hulls.resize(trial.contenders.size());
		for (std::size_t i = 0; i < trial.contenders.size(); ++i)
			for (const std::vector<ModelMesh>& hulls : trial.contenders[i].drawn)
			{
				m_hulls[i].emplace_back();
				for (const ModelMesh& hull : hulls) m_hulls[i].back().push_back(upload(hull));
			}
	}

	Image paint(std::size_t contender, const TrialFrame& moment, const Camera& camera, const std::string& title) const
	{
		Frame frame;
		frame.camera = camera;
		frame.ground.spacing = m_trial.radius;
		frame.ground.fadeRadius = kFadeRadii * m_trial.radius;
		for (std::size_t body = 1; body < moment.state.bodies.size(); ++body)
		{
			const std::size_t model = m_trial.scene.info.bodies[body].model;
			const Transform place = toTransform(moment.state.bodies[body].pose);
			const Color color = kBodyColors[(body - 1) % std::size(kBodyColors)];
			frame.instances.push_back({m_meshes[model], place, color, false});
			if (m_hulls[contender].empty()) continue;
			for (const MeshId hull : m_hulls[contender][model])
				frame.instances.push_back({hull, place, kHullColor, true});
		}
		addContacts(frame, moment.state);
		Image image = m_renderer->render(frame);
		OverlayText text;
		text.title = title;
		text.lines = lines(moment);
		drawOverlay(image, text);
		return image;
	}

private:
	MeshId upload(const ModelMesh& mesh)
	{
		RenderMesh render;
		render.vertices = mesh.vertices;
		render.triangles = mesh.triangles;
		const Result<MeshId> id = m_renderer->addMesh(render);
		if (!id) throw cli::Failure(cli::ExitCode::failure, id.error());
		return id.value();
	}
	void addContacts(Frame& frame, const SceneState& state) const
	{
		for (const ScenePoint& point : state.points)
			if (point.impulse > 0 && frame.markers.size() < kMostMarkers)
				frame.markers.push_back({point.position, 0.03 * m_trial.radius, kContactColor});
	}
	std::vector<std::string> lines(const TrialFrame& moment) const
	{
		const auto percent = [](double share) { return fmt::format("{:.2f} %", 100 * share); };
		return {fmt::format("step {:.2f} ms", moment.stepMicroseconds / 1000),
				"overlap " + percent(moment.deepest / m_trial.smallest),
				std::isnan(moment.offSurface) ? std::string("no contact") : "points off by " + percent(moment.offSurface)};
	}

	const Trial& m_trial;
	std::unique_ptr<Renderer> m_renderer;
	std::vector<MeshId> m_meshes;
	std::vector<std::vector<std::vector<MeshId>>> m_hulls;  // of a contender's models
};

Vec3 middle(const Trial& trial, const SceneState& state)
{
	Vec3 sum;
	for (std::size_t body = 1; body < state.bodies.size(); ++body)
		sum += toTransform(state.bodies[body].pose) * meshFromBody(*trial.models[trial.scene.info.bodies[body].model]);
	return (1 / double(state.bodies.size() - 1)) * sum;
}

// Radius round a place of all bodies that move.
double extent(const Trial& trial, const SceneState& state, const Vec3& from)
{
	double radius = 0;
	for (std::size_t body = 1; body < state.bodies.size(); ++body)
	{
		const Hierarchy& model = *trial.models[trial.scene.info.bodies[body].model];
		const Vec3 center = toTransform(state.bodies[body].pose) * meshFromBody(model);
		radius = std::max(radius, length(center - from) + double(model.asset().radius));
	}
	return radius;
}

// Where a stopped run stays.
const TrialFrame& frameAt(const TrialRun& run, std::size_t index)
{
	return run.frames[std::min(index, run.frames.size() - 1)];
}

void write(const std::string& path, const Image& image, const std::string& title)
{
	const Result<std::size_t> written = writePng(path, image, {{"Title", title}});
	if (!written) throw cli::Failure(cli::ExitCode::failure, written.error());
}
}  // namespace

TrialPictures paintTrial(const Trial& trial, const std::string& directory, const FilmRules& rules,
						 const std::function<void(double)>& progress)
{
	TrialPictures pictures;
	const TrialPainter painter(trial, rules);
	std::size_t count = 0;
	for (const TrialRun& run : trial.runs) count = std::max(count, run.frames.size());
	FrameFolder folder(directory, "clod-bench try", count, rules.framesPerSecond);
	Vec3 target = middle(trial, trial.runs[0].frames[0].state);
	double view = extent(trial, trial.runs[0].frames[0].state, target);
	for (std::size_t i = 0; i < count; ++i)
	{
		const SceneState& ours = frameAt(trial.runs[0], i).state;
		target += kFollow * (middle(trial, ours) - target);
		view += kFollow * (extent(trial, ours, target) - view);
		const Camera camera = orbitCamera(target, kRoom * view, kAzimuth, kElevation);
		std::vector<CaptionedImage> panels;
		for (std::size_t k = 0; k < trial.runs.size(); ++k)
		{
			if (trial.runs[k].frames.empty()) continue;
			const bool isOver = i >= trial.runs[k].frames.size();
			panels.push_back({painter.paint(k, frameAt(trial.runs[k], i), camera, trial.contenders[k].name),
							  isOver ? trial.runs[k].ending : trial.contenders[k].setting});
		}
		const double time = frameAt(trial.runs[0], i).state.time;
		folder.add(contactSheet(panels, panels.size() == 3 ? 3 : 2, 0, ""), fmt::format("{:.2f} s", time));
		progress(double(i + 1) / double(count));
	}
	pictures.files = folder.finish();
	for (const std::string& file : pictures.files)
		if (file.size() > 4 && file.substr(file.size() - 4) == ".mp4") pictures.film = file;
	for (std::size_t k = 0; k < trial.runs.size(); ++k)
	{
		pictures.worst.emplace_back();
		const TrialRun& run = trial.runs[k];
		if (run.frames.empty()) continue;
		const TrialFrame& frame = run.frames[run.worst];
		const Camera camera = orbitCamera(middle(trial, frame.state), kWorstRadii * trial.radius, kAzimuth, kElevation);
		pictures.worst.back() = fmt::format("{}/worst-{}.png", directory, k);
		write(pictures.worst.back(), painter.paint(k, frame, camera, trial.contenders[k].name),
			  trial.contenders[k].name);
	}
	return pictures;
}
}  // namespace clod::demo
