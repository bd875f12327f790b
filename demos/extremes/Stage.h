// SPDX-License-Identifier: Zlib
// A scene of the matrix: put together body by body, run with what a setting collides as, and looked at. Metres, gravity
// down -y at 9.81 unless a row says otherwise; undamped, no rolling friction, never asleep, the solver as the plugin
// recommends it, for everybody.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "demos/extremes/Row.h"
#include "demos/extremes/Solids.h"
#include "demos/runner/Penetration.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
// A body is nowhere any more.
struct NotFinite : std::runtime_error
{
	using std::runtime_error::runtime_error;
};
// The row is not for this collider.
struct NotApplicable : std::runtime_error
{
	using std::runtime_error::runtime_error;
};

BodyDefinition fixedAt(const Pose& pose);
BodyDefinition movingAt(double mass, const Pose& pose, const Vec3& velocity = {}, const Vec3& turning = {});
// Down a slope along +x that leans by an angle; y stays the surface's normal.
Vec3 slopeGravity(double angle, double size = kGravity);
ContactMetric metricOf(Collider collider);

class Stage
{
public:
	Stage(Workshop& workshop, const Setting& setting);
	// A scene of `clod-bench run`, its models at a share of their triangles. Convex are those named.
	Stage(Workshop& workshop, const Setting& setting, const std::string& scene, double resolution,
		  const std::vector<std::string>& convex);
	SceneDefinition& scene() { return m_scene; }
	void setGravity(const Vec3& gravity);
	// Of both bodies that touch, so that Bullet's product is this.
	void setFriction(double friction);
	std::size_t add(const Solid& solid, const BodyDefinition& body);

	// The world begins with the first step or look.
	void steps(int count);
	void seconds(double time) { steps(int(std::lround(time * m_setting.rate))); }
	// `look` after every step (or every so many); ends early where it says false.
	void watch(double seconds, const std::function<bool()>& look, int every = 1);
	void setMetric(const ContactMetric& metric);
	const SceneState& state();
	const Vec3& place(std::size_t body) { return state().bodies[body].pose.position; }
	Transform pose(std::size_t body) { return toTransform(state().bodies[body].pose); }
	const Vec3& velocity(std::size_t body) { return state().bodies[body].velocity; }
	const Vec3& turning(std::size_t body) { return state().bodies[body].turning; }
	double energy() { return state().energy(); }
	const Hierarchy& hierarchy(std::size_t body) const;
	// Of the full meshes, whatever collides.
	double deepest(std::size_t a, std::size_t b);
	// How far apart two bodies are meant to rest: the skin of ours, margins of Bullet's.
	double restGap(std::size_t a, std::size_t b) const;
	double margin = 0;  // of every body that has one

private:
	Scene& running();
	SceneShape shapeOf(const Solid& solid, bool isStatic) const;
	Workshop& m_workshop;
	Setting m_setting;
	SceneDefinition m_scene;
	std::vector<Solid> m_solids;   // one a model
	std::vector<bool> m_isStatic;  // the same; of bodies added
	std::vector<std::shared_ptr<const SignedDistance>> m_surfaces;
	std::map<std::pair<std::size_t, std::size_t>, PenetrationMeter> m_meters;
	SceneSettings m_settings;
	std::unique_ptr<Scene> m_running;
	std::optional<SceneState> m_state;  // of the last step
};
}  // namespace clod::demo
