// SPDX-License-Identifier: Zlib
#include "demos/extremes/Stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/Failure.h"
#include "clod/manifold/ContactPoints.h"
#include "demos/runner/SceneModels.h"
#include "demos/runner/Selection.h"

namespace clod::demo
{
namespace
{
constexpr double kGimpactMargin = 0.0025;  // of the radius; GImpact's contacts need one
constexpr double kCoarse = 0.035;

SceneShape meshShape(SceneShape::Kind kind, const ModelMesh& mesh, double margin)
{
	SceneShape shape;
	shape.kind = kind;
	shape.meshes = {mesh};
	shape.margin = margin;
	return shape;
}
}  // namespace

BodyDefinition fixedAt(const Pose& pose)
{
	BodyDefinition body;
	body.start = pose;
	return body;
}

BodyDefinition movingAt(double mass, const Pose& pose, const Vec3& velocity, const Vec3& turning)
{
	BodyDefinition body;
	body.mass = mass;
	body.start = pose;
	body.velocity = velocity;
	body.turning = turning;
	return body;
}

Vec3 slopeGravity(double angle, double size)
{
	return {size * std::sin(angle), -size * std::cos(angle), 0};
}

ContactMetric metricOf(Collider collider)
{
	if (collider == Collider::standard) return ContactMetric::errorShare(kDefaultMaxError);
	return collider == Collider::coarse ? ContactMetric::deviationShare(kCoarse) : ContactMetric::exactly();
}

Stage::Stage(Workshop& workshop, const Setting& setting) : m_workshop(workshop), m_setting(setting)
{
	m_scene = mechanism("extremes", "", 0);
	m_scene.info.worldScale = 1;
	m_scene.info.dt = setting.dt();
	m_scene.inPlace = [](std::size_t, const Vec3&) { return true; };
}

Stage::Stage(Workshop& workshop, const Setting& setting, const std::string& scene, double resolution,
			 const std::vector<std::string>& convex)
	: m_workshop(workshop), m_setting(setting)
{
	if (setting.collider == Collider::primitive) throw NotApplicable("no primitive of it");
	if (const SceneDefinition* const known = findDefinition(scene)) m_scene = *known;
	for (std::size_t i = 0; i < m_scene.info.models.size(); ++i)
	{
		const std::string& model = m_scene.info.models[i].name;
		m_solids.push_back(partSolid(model, trianglesOf(model, resolution), 1,
									 std::find(convex.begin(), convex.end(), model) != convex.end()));
		m_settings.models.push_back(workshop.hierarchy(m_solids.back()));
		bool isStatic = true;
		for (std::size_t body = 0; body < m_scene.bodies.size(); ++body)
			if (m_scene.info.bodies[body].model == i && m_scene.bodies[body].mass > 0) isStatic = false;
		m_settings.shapes.push_back(shapeOf(m_solids.back(), isStatic));
	}
}

void Stage::setGravity(const Vec3& gravity)
{
	m_scene.gravity = [gravity](double) { return gravity; };
}

void Stage::setFriction(double friction)
{
	m_scene.world.friction = std::sqrt(friction);
}

SceneShape Stage::shapeOf(const Solid& solid, bool isStatic) const
{
	using Kind = SceneShape::Kind;
	if (isOurs(m_setting.collider)) return {};
	if (m_setting.collider == Collider::primitive)
	{
		if (solid.primitive) return *solid.primitive;
		// A solid that only stands there may be triangles.
		if (isStatic) return meshShape(Kind::bvh, solid.mesh, margin);
		throw NotApplicable("no primitive of it");
	}
	if (solid.isConvex) return meshShape(Kind::hulls, solid.mesh, margin);
	return meshShape(isStatic ? Kind::bvh : Kind::gimpact, solid.mesh, margin);
}

std::size_t Stage::add(const Solid& solid, const BodyDefinition& body)
{
	// What stands still collides as another shape than what moves.
	const bool isStatic = body.mass == 0;
	std::size_t model = 0;
	while (model < m_solids.size() && (m_solids[model].name != solid.name || m_isStatic[model] != isStatic)) ++model;
	if (model == m_solids.size())
	{
		m_solids.push_back(solid);
		m_isStatic.push_back(isStatic);
		m_settings.models.push_back(m_workshop.hierarchy(solid));
		m_settings.shapes.push_back(shapeOf(solid, isStatic));
		SceneShape& shape = m_settings.shapes.back();
		if (shape.kind == SceneShape::Kind::gimpact && margin == 0)
			shape.margin = kGimpactMargin * double(m_settings.models.back()->asset().radius);
		m_scene.info.models.push_back({solid.name, ""});
	}
	const std::size_t index = m_scene.bodies.size();
	m_scene.info.bodies.push_back({std::to_string(index), model, false});
	m_scene.bodies.push_back(body);
	return index;
}

Scene& Stage::running()
{
	if (m_running) return *m_running;
	m_scene.world.margin = margin;
	m_settings.metric = metricOf(m_setting.collider);
	m_settings.dt = m_setting.dt();
	m_settings.printsWarnings = false;
	if (isOurs(m_setting.collider)) m_settings.shapes.clear();
	m_running = makeScene(m_scene, m_settings);
	return *m_running;
}

void Stage::steps(int count)
{
	for (int i = 0; i < count; ++i) running().step();
	m_state.reset();
}

void Stage::watch(double seconds, const std::function<bool()>& look, int every)
{
	const int count = int(std::lround(seconds * m_setting.rate));
	for (int i = 0; i < count; i += every)
	{
		steps(std::min(every, count - i));
		if (!look()) return;
	}
}

void Stage::setMetric(const ContactMetric& metric)
{
	running().setMetric(metric);
}

const SceneState& Stage::state()
{
	if (m_state) return *m_state;
	m_state = running().state();
	for (std::size_t i = 0; i < m_state->bodies.size(); ++i)
		if (const BodyState& body = m_state->bodies[i];
			!isFinite(body.pose.position) || !isFinite(body.velocity) || !isFinite(body.turning))
			throw NotFinite(fmt::format("body {} stopped being finite in step {}", i, m_state->step));
	return *m_state;
}

const Hierarchy& Stage::hierarchy(std::size_t body) const
{
	return *m_settings.models[m_scene.info.bodies[body].model];
}

double Stage::deepest(std::size_t a, std::size_t b)
{
	m_surfaces.resize(m_solids.size());
	const auto surface = [&](std::size_t body)
	{
		const std::size_t model = m_scene.info.bodies[body].model;
		if (!m_surfaces[model]) m_surfaces[model] = std::make_shared<SignedDistance>(m_solids[model].mesh);
		return m_surfaces[model];
	};
	const auto meter = m_meters.try_emplace({a, b}, surface(a), surface(b)).first;
	return meter->second.depth(inverse(pose(a)) * pose(b));
}

double Stage::restGap(std::size_t a, std::size_t b) const
{
	const double scale = std::min(double(hierarchy(a).asset().radius), double(hierarchy(b).asset().radius));
	if (isOurs(m_setting.collider)) return kSkinShare * scale + 2 * margin;
	double gap = 0;
	for (const std::size_t body : {a, b}) gap += m_settings.shapes[m_scene.info.bodies[body].model].margin;
	return gap;
}
}  // namespace clod::demo
