// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes from JSON files: what is read, what is refused and how it is named, and that bodies keep to their joints.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "demos/scenes/SceneFile.h"
#include "tests/demos/RunnerCommand.h"

namespace clod::test
{
namespace
{
using namespace demo;

const std::string kWhole = R"({"$schema": "x", "name": "n", "summary": "s", "gravity": [0, -1, 0],
 "material": {"friction": 0.7, "rolling_friction": 0, "spinning_friction": 0, "restitution": 0}, "linear_damping": 0.1, "angular_damping": 0.2, "solver_iterations": 5, "steps": 7,
 "step_seconds": 0.01, "tolerance": 0.001, "world_scale": 3,
 "models": [{"name": "cup", "scale": 2, "repair": true}, {"name": "torus"}],
 "bodies": [{"model": "cup"},
  {"name": "t", "model": "torus", "mass": 2, "position": [1, 2, 3], "rotation": [0, 0, 0, 2], "velocity": [4, 5, 6],
   "angular_velocity": [7, 8, 9], "transparent": true,
   "material": {"friction": 0.2, "rolling_friction": 0.3, "spinning_friction": 0.4, "restitution": 0.5},
   "joints": [{"kind": "slider", "point": [1, 1, 1], "axis": [1, 0, 0]}]}]})";

std::string errorOf(const std::string& text)
{
	const Result<SceneDefinition> scene = parseScene(text, "f.json");
	return scene ? std::string("none") : scene.error();
}

// The whole scene with one piece replaced.
std::string errorWith(const std::string& from, const std::string& to)
{
	std::string text = kWhole;
	const std::size_t at = text.find(from);
	EXPECT_NE(at, std::string::npos) << from;
	return errorOf(text.replace(at, from.size(), to));
}

TEST(SceneFile, ReadsWhatIsThere)
{
	const Result<SceneDefinition> read = parseScene(kWhole, "f.json");
	ASSERT_TRUE(read) << read.error();
	const SceneDefinition& scene = read.value();
	EXPECT_EQ(scene.info.name, "n");
	EXPECT_EQ(scene.gravity(1), (Vec3{0, -1, 0}));
	EXPECT_EQ(scene.world.friction, 0.7);
	EXPECT_EQ(scene.world.linearDamping, 0.1);
	EXPECT_EQ(scene.world.angularDamping, 0.2);
	EXPECT_EQ(scene.world.solverIterations, 5);
	EXPECT_EQ(scene.info.steps, 7);
	EXPECT_EQ(scene.info.dt, 0.01);
	EXPECT_EQ(scene.info.tolerance, 0.001);
	EXPECT_EQ(scene.info.worldScale, 3);
	ASSERT_EQ(scene.info.models.size(), 2u);
	EXPECT_EQ(scene.info.models[0].scale, 2);
	EXPECT_TRUE(scene.info.models[0].repair);
	EXPECT_FALSE(scene.info.models[1].repair);
	ASSERT_EQ(scene.bodies.size(), 2u);
	EXPECT_EQ(scene.bodies[0].mass, 0);
	EXPECT_EQ(scene.info.bodies[0].name, "cup-1");
	const BodyDefinition& body = scene.bodies[1];
	EXPECT_EQ(scene.info.bodies[1].name, "t");
	EXPECT_EQ(scene.info.bodies[1].model, 1u);
	EXPECT_TRUE(scene.info.bodies[1].isSeenThrough);
	EXPECT_EQ(body.mass, 2);
	EXPECT_EQ(body.start.position, (Vec3{1, 2, 3}));
	EXPECT_EQ(body.start.quaternion[3], 1);
	EXPECT_EQ(body.velocity, (Vec3{4, 5, 6}));
	EXPECT_EQ(body.turning, (Vec3{7, 8, 9}));
	ASSERT_TRUE(body.material);
	EXPECT_EQ(body.material->friction, 0.2);
	EXPECT_EQ(body.material->rollingFriction, 0.3);
	EXPECT_EQ(body.material->spinningFriction, 0.4);
	EXPECT_EQ(body.material->restitution, 0.5);
	ASSERT_EQ(body.joints.size(), 1u);
	EXPECT_EQ(body.joints[0].kind, BodyJoint::Kind::slider);
	EXPECT_EQ(body.joints[0].point, (Vec3{1, 1, 1}));
	EXPECT_EQ(body.joints[0].axis, (Vec3{1, 0, 0}));
}

TEST(SceneFile, RefusalsNameTheElement)
{
	EXPECT_EQ(errorOf("{").find("f.json: no JSON: parse error at line 1, column 2: "), 0u) << errorOf("{");
	EXPECT_EQ(errorOf("[]"), "f.json: the scene: has to be an object");
	EXPECT_EQ(errorOf("{\"bodies\": []}"), "f.json: the scene: 'models' is missing");
	EXPECT_EQ(errorWith("\"velocity\"", "\"velocitty\""),
			  "f.json: bodies[1]: unknown member 'velocitty'; did you mean velocity?");
	EXPECT_EQ(errorWith("\"model\": \"torus\"", "\"model\": \"toros\""),
			  "f.json: bodies[1].model: no model is called 'toros'; did you mean torus?");
	EXPECT_EQ(errorWith("\"mass\": 2", "\"mass\": -2"),
			  "f.json: bodies[1].mass: has to be a number from 0 to 1e+07");
	EXPECT_EQ(errorWith("\"mass\": 2", "\"mass\": 0"), "f.json: bodies[1].velocity: a body without mass does not move");
	EXPECT_EQ(errorWith("[1, 2, 3]", "[1, 2]"), "f.json: bodies[1].position: has to be 3 numbers");
	EXPECT_EQ(errorOf(R"({"models": [{"name": "cup"}], "bodies": [{"model": "cup"}, {"model": "cup"}]})"),
			  "f.json: bodies: none has a mass: nothing would move");
	EXPECT_NE(errorWith("[4, 5, 6]", "[4, null, 6]").find("bodies[1].velocity[1]"), std::string::npos);
	EXPECT_EQ(errorWith("[0, 0, 0, 2]", "[0, 0, 0, 0]"), "f.json: bodies[1].rotation: is no rotation: all zero");
	EXPECT_EQ(errorWith("\"slider\"", "\"slyder\""),
			  "f.json: bodies[1].joints[0].kind: 'slyder' is no joint; did you mean slider?");
	EXPECT_EQ(errorWith("\"axis\": [1, 0, 0]", "\"axis\": [0, 0, 0]"),
			  "f.json: bodies[1].joints[0].axis: has no length");
	EXPECT_EQ(errorWith("\"scale\": 2", "\"scale\": 0"),
			  "f.json: models[0].scale: has to be a number from 1e-12 to 1e+12");
	EXPECT_EQ(errorWith("{\"name\": \"torus\"}", "{\"name\": \"cup\"}"),
			  "f.json: models[1]: another model is called 'cup' too");
	EXPECT_EQ(errorWith("{\"name\": \"torus\"}", "{\"name\": \"thing\"}"),
			  "f.json: models[1]: 'thing' has no file and is no benchmark model");
	EXPECT_EQ(errorWith("{\"name\": \"torus\"}", "{\"name\": \"torus\", \"file\": \"none.obj\"}"),
			  "f.json: models[1].file: none.obj: no such file");
	EXPECT_EQ(errorWith("\"steps\": 7", "\"steps\": 7.5"), "f.json: steps: has to be a whole number");
	EXPECT_EQ(errorWith("\"solver_iterations\": 5", "\"solver_iterations\": 1e5"),
			  "f.json: solver_iterations: has to be a number from 1 to 10000");
	EXPECT_EQ(errorWith("\"repair\": true", "\"repair\": 1"), "f.json: models[0].repair: has to be true or false");
}

TEST(SceneFile, AxesOfAnyLengthAreDirections)
{
	const auto axisOf = [](const std::string& joint)
	{
		const std::string text = R"({"models": [{"name": "cup"}], "bodies": [{"model": "cup"}, {"model": "cup", "mass": 1,
			"joints": [{"kind": "slider", "point": [0, 0, 0])" + joint + "}]}]}";
		return parseScene(text, "f.json").value().bodies[1].joints[0].axis;
	};
	EXPECT_EQ(axisOf(""), (Vec3{0, 1, 0}));
	for (const char* size : {"1e-320", "1e-160", "1e-30", "1", "3e38"})
	{
		const Vec3 axis = axisOf(fmt::format(R"(, "axis": [0, -{0}, {0}])", size));
		EXPECT_LT(length(axis - Vec3{0, -std::sqrt(0.5), std::sqrt(0.5)}), 1e-15) << size;
	}
}

TEST(SceneFile, AMemberThatIsWrittenTwiceIsRefused)
{
	EXPECT_EQ(errorWith("\"mass\": 2", "\"mass\": 2, \"mass\": 3"), "f.json: bodies[1].mass: is written twice");
	EXPECT_EQ(errorWith("\"kind\"", "\"kind\": \"ball\", \"kind\""),
			  "f.json: bodies[1].joints[0].kind: is written twice");
	EXPECT_EQ(errorWith("\"summary\"", "\"steps\": 9, \"summary\""), "f.json: steps: is written twice");
}

// Every member that the schema has is in the scene above, which is read.
void expectMembers(const json& schema, const json& root, const json& value, const std::string& place)
{
	if (schema.contains("$ref"))
	{
		const std::string name = schema["$ref"].get<std::string>().substr(std::string("#/$defs/").size());
		return expectMembers(root["$defs"][name], root, value, place);
	}
	if (schema.contains("items") && schema["items"].contains("$ref"))
	{
		json merged = json::object();
		for (const json& item : value) merged.update(item);
		return expectMembers(schema["items"], root, merged, place + "[]");
	}
	if (!schema.contains("properties")) return;
	for (const auto& [name, property] : schema["properties"].items())
	{
		const bool isFile = name == "file";  // that has to be there
		EXPECT_TRUE(isFile || value.contains(name)) << place << "." << name;
		if (value.contains(name)) expectMembers(property, root, value[name], place + "." + name);
	}
	for (const auto& [name, unused] : value.items())
		EXPECT_TRUE(schema["properties"].contains(name)) << place << "." << name << " is not in the schema";
}

TEST(SceneFile, TheSchemaHasWhatIsRead)
{
	const json schema = json::parse(readText(CLOD_SOURCE_FOLDER "/demos/scenes/scene.schema.json"));
	expectMembers(schema, schema, json::parse(kWhole), "scene");
}

TEST(SceneFile, TheSchemaHasTheLimitsOfWhatIsRead)
{
	const json schema = json::parse(readText(CLOD_SOURCE_FOLDER "/demos/scenes/scene.schema.json"));
	for (const auto& [at, in] :
		 {std::pair("/steps", ""), {"/solver_iterations", ""}, {"/step_seconds", ""}, {"/tolerance", ""},
		  {"/world_scale", ""}, {"/linear_damping", ""}, {"/angular_damping", ""}, {"/models/0/scale", "/$defs/model"},
		  {"/bodies/1/mass", "/$defs/body"}, {"/material/friction", "/$defs/material"},
		  {"/material/restitution", "/$defs/material"}})
	{
		const std::string place = at, name = place.substr(place.rfind('/'));
		const json& limits = schema.at(json::json_pointer(in + ("/properties" + name)));
		const auto errorAt = [&](const json& value)
		{
			json scene = json::parse(kWhole);
			scene[json::json_pointer(place)] = value;
			return errorOf(scene.dump());
		};
		ASSERT_TRUE(limits.contains("minimum")) << place;
		const bool mayRest = name != "/mass";  // of a body that moves
		EXPECT_EQ(errorAt(limits["minimum"]) == "none", mayRest) << place;
		const double low = limits["minimum"], below = low > 0 && limits["type"] == "number" ? low / 2 : low - 1;
		EXPECT_NE(errorAt(limits["type"] == "integer" ? json(int(below)) : json(below)), "none") << place;
		if (!limits.contains("maximum")) continue;
		EXPECT_EQ(errorAt(limits["maximum"]), "none") << place;
		EXPECT_NE(errorAt(2 * limits["maximum"].get<double>()), "none") << place;
	}
}

// A ground that came first was taken for as large as it is: bodies were dots.
TEST(SceneFile, PicturesLookAtWhatMovesWhateverComesFirst)
{
	const auto load = [](const char* name)
	{ return Hierarchy::load(std::string(CLOD_SOURCE_FOLDER "/tests/fixtures/") + name).value(); };
	const std::vector<std::shared_ptr<const Hierarchy>> models = {load("cube.clod"), load("sphere-300.clod")};
	const auto overviewOf = [&](const char* bodies)
	{
		const std::string text =
			fmt::format(R"({{"models": [{{"name": "cup"}}, {{"name": "torus"}}], "bodies": [{}]}})", bodies);
		SceneDefinition scene = parseScene(text, "f.json").value();
		fitToModels(scene, models);
		return scene.info.overview.radius;
	};
	const double first = overviewOf(R"({"model": "cup"}, {"model": "torus", "mass": 1})"),
				 last = overviewOf(R"({"model": "torus", "mass": 1}, {"model": "cup"})");
	EXPECT_NEAR(first, last, 1e-12);
	EXPECT_LT(first, 6 * double(models[1]->asset().radius));
	ASSERT_GT(models[0]->asset().radius, 10 * models[1]->asset().radius);
}

class SceneFileRun : public RunnerCommand
{
};

TEST_F(SceneFileRun, TheExampleRunsAndTheCupKeepsToItsHinge)
{
	const std::string example = CLOD_SOURCE_FOLDER "/demos/scenes/example.json";
	const Outcome run = bench("run " + example + " --resolution 0.02 --steps 240 --quiet --json " + path("run.json") +
							  " --poses " + path("swing.csv") + cache());
	ASSERT_EQ(run.code, 0) << run.err;
	EXPECT_EQ(report("run.json")["scene"], "swing");
	const std::string poses = readText(path("swing.csv"));
	const auto x = column(poses, "bx"), y = column(poses, "by"), z = column(poses, "bz"),
			   body = column(poses, "body_b");
	double least = INFINITY, most = 0;
	for (std::size_t i = 0; i < x.size(); ++i)
	{
		if (body[i] != 1) continue;
		const double arm = std::hypot(x[i], y[i] - 0.17);
		least = std::min(least, arm);
		most = std::max(most, arm);
		EXPECT_NEAR(z[i], 0, 1e-3);
	}
	EXPECT_GT(most, 0) << "the cup is never near the ground";
	EXPECT_NEAR(least, 0.13, 1e-3);
	EXPECT_NEAR(most, 0.13, 1e-3);
	std::string far = readText(example);
	far.replace(far.find("[0.12, 0.12, 0]"), 15, "[1e9, 0.12, 0]");
	const Outcome away = bench("run " + file("far.json", far) + " --resolution 0.02 --steps 2 --quiet" + cache());
	EXPECT_EQ(away.code, 3);
	EXPECT_NE(away.err.find("bodies[1].position: "), std::string::npos) << away.err;
	const Outcome bad = bench("run " + file("bad.json", "{\"models\": 3, \"bodies\": []}"));
	EXPECT_EQ(bad.code, 3);
	EXPECT_NE(bad.err.find("models: has to be a list"), std::string::npos) << bad.err;
}

TEST_F(SceneFileRun, BodiesThatMeetNothingAreInTheTrajectory)
{
	std::set<std::string> hashes;
	for (const char* speed : {"1", "2"})
	{
		std::string bodies;
		for (int i = 0; i < 3; ++i)
			bodies += fmt::format(R"({}{{"model": "torus", "mass": 1, "position": [{}, 0, 0], "velocity": [0, 0, {}]}})",
								  i > 0 ? ", " : "", 5 * i, speed);
		const std::string scene =
			file("apart.json", R"({"models": [{"name": "torus"}], "bodies": [)" + bodies + "]}");
		const Outcome run = bench("run " + scene + " --resolution 0.02 --steps 2 --quiet --poses " + path("apart.csv") +
								  " --json " + path("ran.json") + cache());
		ASSERT_EQ(run.code, 0) << run.err;
		EXPECT_EQ(report("ran.json")["poses"]["rows"], 0);
		hashes.insert(report("ran.json")["trajectory_hash"].get<std::string>());
	}
	EXPECT_EQ(hashes.size(), 2u);
}
}  // namespace
}  // namespace clod::test
