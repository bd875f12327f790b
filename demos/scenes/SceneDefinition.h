// SPDX-License-Identifier: Zlib
// A scene as data: what lies where, what moves it, and the constants of its world. Knows no Bullet; RigidScene runs it.
//
// Lengths and speeds are in the meshes' unit (metres for our models), before worldScale is applied.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "demos/scenes/Scene.h"

namespace clod::demo
{
// What surfaces are made of. Bullet multiplies those of the two that meet.
struct Material
{
	double friction = 0.3;
	double rollingFriction = 0.0003, spinningFriction = 0.0003;  // lever arms
	double restitution = 0;
};

inline constexpr double kWarmstartingOfPiles = 0.98;  // see WorldSettings

// Of the world, and of every body in it that has no material of its own.
struct WorldConstants : Material
{
	double margin = 0;
	double linearDamping = 0, angularDamping = 0.5;
	int solverIterations = 40;  // at most
	std::optional<double> warmstartingFactor;  // else that of WorldSettings
};

// Holds a body to the world, or to an earlier body, where both are at the start. What it joins may touch.
struct BodyJoint
{
	enum class Kind
	{
		fixed,
		ball,    // turns about the point
		hinge,   // turns about the axis through the point
		slider,  // moves along the axis
	};
	Kind kind = Kind::fixed;
	Vec3 point, axis{0, 1, 0};                // of the world
	std::optional<std::size_t> partner = {};  // the other body; none: the world
};

struct BodyDefinition
{
	double mass = 0;  // kg; 0: moved by nothing
	Pose start;
	std::function<Pose(double time)> course;  // where set, the body follows it whatever it touches
	// At the start: m/s of its centre of mass, rad/s.
	Vec3 velocity = {}, turning = {};
	// An ideal bearing: along and about which axes of the world it is free.
	Vec3 moves{1, 1, 1}, turns{1, 1, 1};
	std::optional<Material> material = {};
	std::vector<BodyJoint> joints = {};
};

struct SceneDefinition
{
	SceneInfo info;
	WorldConstants world;
	std::vector<BodyDefinition> bodies;        // one for each of info.bodies
	std::function<Vec3(double time)> gravity;  // m/s^2
	std::function<bool(std::size_t body, const Vec3& center)>
		inPlace;                           // is a body's centre of mass where it should be?
	std::vector<SceneConstant> constants;  // of this scene alone
	// Where set, the values of info.outcome.
	std::function<std::vector<double>(const SceneState& state)> outcome;
	// Where set, called once before anything moves: courses that depend on the models' exact shape are found here.
	std::function<void(SceneDefinition&, const std::vector<std::shared_ptr<const Hierarchy>>& models)> prepare;
};

// Straight down.
Vec3 steadyGravity(double time);
// 0 up to t = 0, 1 from t = 1 on, smooth between.
double smoothStep(double t);
// Turned about an axis of unit length, as a pose at a place; the second turn after the first.
Pose turnedAbout(const Vec3& axis, double angle, const Vec3& place = {});
Pose turnedTwice(const Pose& first, const Pose& second);
// About y, as a pose at a place.
Pose turnedAboutY(const Vec3& place, double angle);
// Nothing brakes but friction between surfaces.
WorldConstants undamped(const WorldConstants& world);
// What scenes of mechanisms have in common: 1/240 s, undamped, metres, no ground in pictures.
SceneDefinition mechanism(const std::string& name, const std::string& summary, double friction);
inline constexpr double kGravity = 9.81;
inline constexpr double kPi = 3.14159265358979323846;

// All, in the order `clod-bench list` shows them.
const std::vector<SceneDefinition>& sceneDefinitions();
// Null for an unknown name.
const SceneDefinition* findDefinition(const std::string& name);

SceneDefinition spoonCup();
SceneDefinition torusSpiral();
SceneDefinition numbersBowl();
SceneDefinition spoonsNested();
SceneDefinition boltNut();
SceneDefinition mixedNeeds();
SceneDefinition contactArea();
SceneDefinition pendulum();
SceneDefinition wedges();
SceneDefinition chain();
SceneDefinition rack();
SceneDefinition doublePendulum();
SceneDefinition piston();
SceneDefinition arch();
SceneDefinition arch101();
SceneDefinition boltGravity();
SceneDefinition nestedCups();
SceneDefinition pileStacks();
SceneDefinition pileHeap();
// So many digits: as in pile-stacks, as in pile-heap, or each by itself on the floor.
enum class Arrangement
{
	stacks,
	heap,
	field
};
SceneDefinition digits(Arrangement arrangement, int count);
SceneDefinition press();
// A convex body, `half` high from its middle down, over the model `landscape`; m/s.
SceneDefinition slideOnLandscape(const SceneModel& body, double half, double speed);
SceneDefinition spinningPlate();
SceneDefinition ringOnPeg();
SceneDefinition rockingTorus();
// Of radii of about 25 mm.
SceneDefinition drop(const std::vector<SceneModel>& models);
// The scene of `clod-bench try`: of any unit, for bodies of these radii. Each falls, all slide as gravity tilts. The
// solver's clock is that of bodies of 0.1 m.
SceneDefinition trial(const std::vector<SceneModel>& models, double largest, double smallest);
}  // namespace clod::demo
