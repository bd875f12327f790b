// SPDX-License-Identifier: Zlib
// A scene: bodies of detailed concave meshes in a Bullet world, stepped at a fixed rate. Compiled once per Bullet
// precision.
//
// Bullet's constants are absolute (0.02 breaking threshold, 0.04 split-impulse threshold), so a scene multiplies every
// length by its worldScale before Bullet sees it. Poses, tolerances and speeds of this interface are in the meshes'
// unit.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clod/distance/SignedGap.h"
#include "clod/query/ContactMetric.h"
#include "demos/models/Models.h"
#include "demos/scenes/CameraPath.h"
#include "demos/scenes/Poses.h"
#include "demos/scenes/Stopwatch.h"

namespace clod::demo
{
struct SceneModel
{
	std::string name;  // of a benchmark model, or what reports call the file
	std::string file;  // a mesh or .clod file; empty: the benchmark model
	double scale = 1;  // all its lengths times this
	bool repair = false;  // of a mesh file, before it is built
};

struct SceneBody
{
	std::string name;
	std::size_t model = 0;       // index in SceneInfo::models; bodies may share one
	bool isSeenThrough = false;  // in pictures
};

// What a picture looks at: a ball round a point of the world or, with a body, of that body's mesh.
struct SceneView
{
	Vec3 center;
	double radius = 1;
	double azimuth = 20, elevation = 28;  // degrees
	int body = -1;
	std::string caption;
};

// What a scene's outcome is told by, a value a step. A swing is expected to shrink: its turning points are compared.
struct OutcomeName
{
	std::string name, unit;
	bool isSwing = false;
};

// What a scene is about, known before anything is built.
struct SceneInfo
{
	std::string name, summary;
	std::vector<SceneModel> models;
	std::vector<SceneBody> bodies;
	double tolerance = 0;    // contacts are reported up to this gap
	double thinnerWall = 0;  // the thinnest of all bodies' walls
	double dt = 0;
	int steps = 0;
	double worldScale = 1;
	SceneView overview, closeUp;
	bool hasGround = true;  // pictures show one at height 0
	std::vector<OutcomeName> outcome;
	// Scenes of two bodies follow their pair at every step, larger ones the pairs whose boxes come within the
	// tolerance.
	bool isPair() const { return bodies.size() == 2; }
};

// One named constant of a scene, as its report prints it.
struct SceneConstant
{
	std::string name;
	double value;
	std::string unit;
};

// What a model collides as: ours, or what users of Bullet have instead. Mass, inertia and frame are the same.
struct SceneShape
{
	enum class Kind
	{
		clod,
		hulls,    // of each mesh's vertices; several are a compound
		gimpact,  // the triangles of the first mesh
		bvh,      // the same, of a body that never moves
		// Bullet's own solids, centred at the mesh's centre of mass.
		box,
		sphere,
		cylinder,  // about y
		capsule    // about y; half of its straight part is y
	};
	Kind kind = Kind::clod;
	std::vector<ModelMesh> meshes;  // of hulls, gimpact and bvh
	double margin = 0;              // of those three; the meshes' unit
	Vec3 halfExtents = {};          // of Bullet's solids; a sphere's radius is x
};

struct SceneSettings
{
	std::vector<std::shared_ptr<const Hierarchy>> models;  // one for each of SceneInfo::models
	std::vector<SceneShape> shapes;                        // the same; empty: all are ours
	ContactMetric metric;                                  // of every pair of bodies
	std::optional<CameraPath> camera;                      // of view metrics; the meshes' unit
	Budget budget;                                         // of the queries of a step
	double dt = 0;
	int passes = 1, parts = 1;   // of btClodDynamicsWorld at most; with 1 the world is Bullet's own
	bool atImpacts = false;      // steps are divided at times of impact (btClodDynamicsWorld::Stepping)
	unsigned threads = 1;        // of btClodDispatcher: the same bits for any number
	TimedBy timedBy = TimedBy::clock;  // the times of a state; by the thread only where one thread makes the contacts
	bool printsWarnings = true;  // of the plugin, as they come; SceneState has them anyway
};

struct BodyPair
{
	std::uint32_t a, b;  // a < b, but for PairAnswer
};

// The query's answer to a pair of bodies, in the order of its A and B.
struct PairAnswer
{
	BodyPair bodies;
	GapResult result;
};

// A point of Bullet's persistent manifolds, in the world, in the meshes' unit.
struct ScenePoint
{
	BodyPair bodies;
	Vec3 position;  // on the second body
	Vec3 normal;    // from the second body to the first
	double distance = 0;
	double impulse = 0;  // of the last step, N s
};

struct BodyState
{
	Pose pose;
	Vec3 velocity, turning;  // m/s of its centre of mass, rad/s
};

struct SceneState
{
	std::int64_t step = 0;
	double time = 0;
	Vec3 gravity;  // direction and size now, m/s^2
	std::vector<BodyState> bodies;
	std::vector<BodyPair> pairs;      // followed now, see SceneInfo::isPair
	double stepMicroseconds = 0;      // the whole of stepSimulation
	int passes = 1, parts = 1, pairsAskedAgain = 0;  // see SceneSettings::passes
	double dispatchMicroseconds = 0;  // its collision dispatch
	double contactError = 0;          // certified, of the coarsest contact of any pair; the meshes' unit
	double excess = 0;                // under a budget: by which factor the worst contact misses its metric
	std::uint64_t tests = 0;          // hull distances and culling boxes of its queries,
	std::uint64_t coarsestTests = 0;  // and under a budget those that their coarsest answers take
	std::uint32_t finestLevel = 0, coarsestLevel = 0;  // of the pairs that touch
	int manifolds = 0;
	double kinetic = 0, potential = 0;  // J, of all bodies that move freely; the latter is 0 at the world's origin
	std::vector<double> outcome;        // see SceneInfo::outcome
	double energy() const { return kinetic + potential; }
	bool inPlace = true;  // every body is still where the scene means it to be
	std::vector<ScenePoint> points;
	// Under a budget what the step's own dispatch answered, for the poses that the step began with, and in what time.
	// Tests are those of this step: none for a pair whose last answer still held.
	std::vector<PairAnswer> answers;
	double queryMicroseconds = 0;
	std::vector<std::string> warnings;  // of the plugin in this step
};

struct StepTimes
{
	double step = 0, dispatch = 0;  // microseconds
};

class Scene
{
public:
	virtual ~Scene() = default;
	virtual void step() = 0;
	// Bodies to where, and as fast as, another run of the same scene had them after its step: the next step's contacts
	// are then judged there. Those on a course keep to it.
	virtual void place(const SceneState& state) = 0;
	// Of every pair, from the next step on.
	virtual void setMetric(const ContactMetric& metric) = 0;
	virtual SceneState state() const = 0;
	virtual StepTimes lastTimes() const = 0;  // as in state()
	virtual std::vector<SceneConstant> constants() const = 0;
};

const std::vector<SceneInfo>& scenes();
// Null for an unknown name.
const SceneInfo* findScene(const std::string& name);
std::unique_ptr<Scene> makeScene(const std::string& name, const SceneSettings& settings);
struct SceneDefinition;
std::unique_ptr<Scene> makeScene(const SceneDefinition& definition, const SceneSettings& settings);
}  // namespace clod::demo
