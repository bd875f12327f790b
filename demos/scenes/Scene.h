// SPDX-License-Identifier: Zlib
// A scene: two bodies of detailed concave meshes in a Bullet world, stepped at a fixed rate. Compiled once per Bullet
// precision.
//
// Bullet's constants are absolute (0.02 breaking threshold, 0.04 split-impulse threshold), so a scene multiplies every
// length by its worldScale before Bullet sees it. Poses, tolerances and speeds of this interface are in the meshes'
// unit.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/scenes/Poses.h"

namespace clod::demo
{
// What a scene is about, known before anything is built.
struct SceneInfo
{
	std::string name, summary;
	std::string modelA, modelB;  // names of benchmark models
	double tolerance = 0;        // contacts are reported up to this gap; metres
	double thinnerWall = 0;      // the thinner of both bodies' walls; metres
	double dt = 0;
	int steps = 0;
	double worldScale = 1;
	// What pictures look at: a ball in the world, and one in the frame of mesh B for the close-up.
	Vec3 overview;
	double overviewRadius = 1;
	Vec3 closeUp;
	double closeUpRadius = 1;
};

// One named constant of a scene, as its report prints it.
struct SceneConstant
{
	std::string name;
	double value;
	std::string unit;
};

struct SceneSettings
{
	std::shared_ptr<const Hierarchy> a, b;
	Settings query;  // metric and paper mode; the tolerance comes from the scene
	double dt = 0;
};

// A point of Bullet's persistent manifolds, in the world, in the meshes' unit.
struct ScenePoint
{
	Vec3 position;  // on body B
	Vec3 normal;    // from B to A
	double distance = 0;
	double impulse = 0;  // of the last step, N s
};

struct SceneState
{
	PoseRow poses;
	double time = 0;
	Vec3 gravity;                     // direction and size now, m/s^2
	Vec3 velocity, turning;           // of body B: m/s of its centre of mass, rad/s
	double stepMicroseconds = 0;      // the whole of stepSimulation
	double dispatchMicroseconds = 0;  // its collision dispatch
	int manifolds = 0;
	bool inPlace = true;  // body B is still where the scene means it to be
	std::vector<ScenePoint> points;
	std::vector<std::string> warnings;  // of the plugin in this step
};

class Scene
{
public:
	virtual ~Scene() = default;
	virtual void step() = 0;
	virtual SceneState state() const = 0;
	virtual std::vector<SceneConstant> constants() const = 0;
};

const std::vector<SceneInfo>& scenes();
// Null for an unknown name.
const SceneInfo* findScene(const std::string& name);
std::unique_ptr<Scene> makeScene(const std::string& name, const SceneSettings& settings);
}  // namespace clod::demo
