// SPDX-License-Identifier: Zlib
// A user's own meshes tried: what `clod-bench try` learns of them until its report is written. Lengths are the meshes'
// unit, whatever that is; times are seconds of the simulation, costs microseconds.
#pragma once
#include <string>
#include <vector>

#include "demos/peers/Tradeoff.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/scenes/SceneDefinition.h"
#include "demos/trial/Recommendation.h"

namespace clod::demo
{
// One of the meshes as it was given, and what became of it.
struct TrialMesh
{
	std::string file, name;
	HierarchyPointer hierarchy;
	double scale = 1;         // it was multiplied by this to be of the others' size
	double buildSeconds = 0;  // NaN: found in the cache, or a .clod file
	std::vector<std::string> mended;  // what the builder did to it, in sentences; empty: taken as it is
};

// One way of colliding that the trial's scene is run with.
struct Contender
{
	std::string name, setting;                  // "GImpact", "full meshes"
	std::string color;                          // in plots, #rrggbb
	std::vector<SceneShape> shapes;             // one a model of the scene; none: ours
	std::vector<std::vector<ModelMesh>> drawn;  // hulls to draw over the meshes, one list a model
};

// What was seen at one frame of the film.
struct TrialFrame
{
	SceneState state;
	double stepMicroseconds = 0;  // median over the steps since the last frame
	double deepest = 0;           // of any vertex of a full mesh in another body
	// How far the worst contact point is off the full meshes' surfaces, as a share of the smaller radius of the two
	// that touch, as certified limits are; NaN without contacts.
	double offSurface = 0;
};

struct TrialRun
{
	std::vector<TrialFrame> frames;
	std::string ending;  // why it did not run to the end; empty: it did
	double stepMedian = 0, stepP95 = 0;
	double deepest = 0, offSurfaceMedian = 0, offSurfaceP95 = 0;  // the latter over the frames with contacts
	double endSpeed = 0;    // of the fastest body's centre over the last tenth of a second, radii a second
	int gone = 0;           // bodies that are not where the scene means them to be, at the end
	std::size_t worst = 0;  // frame, see worstFrame()
};

struct Trial
{
	std::vector<TrialMesh> meshes;
	SceneDefinition scene;
	std::vector<HierarchyPointer> models;  // of the scene
	std::vector<ModelMesh> surfaces;       // the same, full
	double radius = 0, smallest = 0;       // of the largest and the smallest mesh
	double tolerance = 0;
	std::vector<Contender> contenders;  // ours first
	std::vector<TrialRun> runs;         // one a contender
	std::vector<std::string> notes;     // what of the meshes was left out or made coarser
	std::vector<LeftOut> leftOut;       // who else would have taken part, and what to do about it
	std::string pair;                   // whose contacts trade-off and recommendations are of
	Tradeoff tradeoff;
	std::vector<LimitRow> limits;
	Recommendation accuracy, cost;
	std::size_t poses = 0;  // that the limits were measured on
	double seconds = 0;     // that all of it took
	std::string command;
};
}  // namespace clod::demo
