// SPDX-License-Identifier: Zlib
#include "demos/scenes/SceneFile.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "cli/Files.h"
#include "cli/MeshPath.h"
#include "cli/Suggestion.h"

namespace clod::demo
{
namespace
{
using nlohmann::json;

constexpr std::size_t kMostBytes = std::size_t(64) << 20, kMostBodies = 100000;
constexpr double kToleranceShare = 0.01, kWallShare = 0.05;  // of the smallest radius
constexpr double kBulletRadius = 5;                          // of the largest body in Bullet's lengths
constexpr double kLargest = std::numeric_limits<float>::max();
constexpr double kHeaviest = 1e7;      // float Bullet takes what is much heavier for what stands still
constexpr double kFarthest = 1e5;      // radii from the origin: float Bullet tells no places apart there

struct Problem
{
	std::string sentence;  // element: what is wrong
};

// Follows the parser: of a member that is written twice JSON readers keep the last, without a word.
class TwiceWritten
{
public:
	void follow(json::parse_event_t event, const json& value)
	{
		const bool opens = event == json::parse_event_t::object_start || event == json::parse_event_t::array_start;
		if ((opens || event == json::parse_event_t::value) && !m_open.empty()) ++m_open.back().items;
		if (opens) m_open.push_back({event == json::parse_event_t::array_start, 0, "", {}});
		if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) m_open.pop_back();
		if (event != json::parse_event_t::key) return;
		m_open.back().name = value.get<std::string>();
		if (!m_open.back().names.insert(m_open.back().name).second) throw Problem{place() + ": is written twice"};
	}

private:
	struct Open
	{
		bool isList;
		std::size_t items;  // of a list, begun so far
		std::string name;   // of the member that is read
		std::set<std::string> names;
	};
	std::string place() const
	{
		std::string place;
		for (const Open& open : m_open)
			place += open.isList ? fmt::format("[{}]", open.items - 1) : (place.empty() ? "" : ".") + open.name;
		return place;
	}
	std::vector<Open> m_open;
};

// One value of the file and where it is in it.
class Element
{
public:
	Element(const json& value, std::string place) : m_value(value), m_place(std::move(place)) {}

	[[noreturn]] void refuse(const std::string& why) const
	{
		throw Problem{(m_place.empty() ? std::string("the scene") : m_place) + ": " + why};
	}
	// An object that has these members at most.
	void allow(const std::vector<std::string>& names) const
	{
		if (!m_value.is_object()) refuse("has to be an object");
		for (const auto& [name, value] : m_value.items())
			if (std::find(names.begin(), names.end(), name) == names.end())
				refuse(fmt::format("unknown member '{}'{}", name, cli::didYouMean(name, names)));
	}
	bool has(const char* name) const { return m_value.contains(name); }
	Element member(const char* name) const
	{
		if (!has(name)) refuse(fmt::format("'{}' is missing", name));
		return {m_value[name], m_place.empty() ? std::string(name) : m_place + "." + name};
	}
	std::vector<Element> items() const
	{
		if (!m_value.is_array()) refuse("has to be a list");
		std::vector<Element> items;
		for (std::size_t i = 0; i < m_value.size(); ++i)
			items.emplace_back(m_value[i], fmt::format("{}[{}]", m_place, i));
		return items;
	}
	double number(double low, double high) const
	{
		const double value = m_value.is_number() ? m_value.get<double>() : std::nan("");
		if (!(value >= low && value <= high)) refuse(fmt::format("has to be a number from {:g} to {:g}", low, high));
		return value;
	}
	int whole(int low, int high) const
	{
		const double value = number(low, high);
		if (value != std::floor(value)) refuse("has to be a whole number");
		return int(value);
	}
	std::string text() const
	{
		if (!m_value.is_string()) refuse("has to be text");
		return m_value.get<std::string>();
	}
	bool truth() const
	{
		if (!m_value.is_boolean()) refuse("has to be true or false");
		return m_value.get<bool>();
	}
	template <std::size_t N>
	std::array<double, N> numbers() const
	{
		const std::vector<Element> list = items();
		if (list.size() != N) refuse(fmt::format("has to be {} numbers", N));
		std::array<double, N> values;
		for (std::size_t i = 0; i < N; ++i) values[i] = list[i].number(-kLargest, kLargest);
		return values;
	}
	Vec3 vector() const
	{
		const auto v = numbers<3>();
		return {v[0], v[1], v[2]};
	}
	// Where it is there.
	void read(const char* name, double& value, double low, double high) const
	{
		if (has(name)) value = member(name).number(low, high);
	}
	void read(const char* name, int& value, int low, int high) const
	{
		if (has(name)) value = member(name).whole(low, high);
	}
	void read(const char* name, Vec3& value) const
	{
		if (has(name)) value = member(name).vector();
	}

private:
	const json& m_value;
	std::string m_place;
};

Material materialOf(const Element& element, Material material)
{
	element.allow({"friction", "rolling_friction", "spinning_friction", "restitution"});
	element.read("friction", material.friction, 0, 1e3);
	element.read("rolling_friction", material.rollingFriction, 0, kLargest);
	element.read("spinning_friction", material.spinningFriction, 0, kLargest);
	element.read("restitution", material.restitution, 0, 1);
	return material;
}

BodyJoint jointOf(const Element& element)
{
	element.allow({"kind", "point", "axis"});
	constexpr const char* kKinds[] = {"fixed", "ball", "hinge", "slider"};
	const std::vector<std::string> kinds(std::begin(kKinds), std::end(kKinds));
	const std::string kind = element.member("kind").text();
	const auto found = std::find(kinds.begin(), kinds.end(), kind);
	if (found == kinds.end())
		element.member("kind").refuse(fmt::format("'{}' is no joint{}", kind, cli::didYouMean(kind, kinds)));
	BodyJoint joint;
	joint.kind = BodyJoint::Kind(found - kinds.begin());
	joint.point = element.member("point").vector();
	element.read("axis", joint.axis);
	// Of length 1, in double: float Bullet's squares of lengths under 1e-22 are zero, of those over 1e19 infinite.
	double largest = 0;
	for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(joint.axis[k]));
	if (!(largest > 0)) element.member("axis").refuse("has no length");
	for (int k = 0; k < 3; ++k) joint.axis[k] /= largest;
	joint.axis = normalized(joint.axis);
	return joint;
}

SceneModel modelOf(const Element& element, const std::filesystem::path& folder)
{
	element.allow({"name", "file", "scale", "repair"});
	SceneModel model;
	model.name = element.member("name").text();
	if (element.has("file")) model.file = (folder / element.member("file").text()).lexically_normal().string();
	if (model.file.empty() && smallestTriangleCount(model.name) == 0)
		element.refuse(fmt::format("'{}' has no file and is no benchmark model", model.name));
	if (!model.file.empty() && !std::filesystem::is_regular_file(cli::meshPath(model.file).file))
		element.member("file").refuse(fmt::format("{}: no such file", model.file));
	element.read("scale", model.scale, 1e-12, 1e12);
	if (element.has("repair")) model.repair = element.member("repair").truth();
	return model;
}

void addBody(SceneDefinition& scene, const Element& element)
{
	element.allow({"name", "model", "mass", "position", "rotation", "velocity", "angular_velocity", "material",
				   "joints", "transparent"});
	const std::string model = element.member("model").text();
	std::vector<std::string> names;
	for (const SceneModel& known : scene.info.models) names.push_back(known.name);
	const auto found = std::find(names.begin(), names.end(), model);
	if (found == names.end())
		element.member("model").refuse(fmt::format("no model is called '{}'{}", model, cli::didYouMean(model, names)));
	SceneBody named{fmt::format("{}-{}", model, scene.bodies.size() + 1), std::size_t(found - names.begin()), false};
	if (element.has("name")) named.name = element.member("name").text();
	if (element.has("transparent")) named.isSeenThrough = element.member("transparent").truth();
	for (const SceneBody& other : scene.info.bodies)
		if (other.name == named.name) element.refuse(fmt::format("another body is called '{}' too", named.name));

	BodyDefinition body;
	element.read("mass", body.mass, 0, kHeaviest);
	element.read("position", body.start.position);
	if (element.has("rotation"))
	{
		const auto q = element.member("rotation").numbers<4>();
		const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
		if (!(size > 0)) element.member("rotation").refuse("is no rotation: all zero");
		for (std::size_t i = 0; i < 4; ++i) body.start.quaternion[i] = q[i] / size;
	}
	element.read("velocity", body.velocity);
	element.read("angular_velocity", body.turning);
	if (element.has("material")) body.material = materialOf(element.member("material"), scene.world);
	if (element.has("joints"))
		for (const Element& joint : element.member("joints").items()) body.joints.push_back(jointOf(joint));
	if (body.mass == 0)
		for (const char* moving : {"velocity", "angular_velocity", "joints"})
			if (element.has(moving)) element.member(moving).refuse("a body without mass does not move");
	scene.info.bodies.push_back(named);
	scene.bodies.push_back(body);
}

void readWorld(SceneDefinition& scene, const Element& element)
{
	static_cast<Material&>(scene.world) = Material{0.5, 0, 0, 0};
	if (element.has("material"))
		static_cast<Material&>(scene.world) = materialOf(element.member("material"), scene.world);
	scene.world.angularDamping = 0;
	element.read("linear_damping", scene.world.linearDamping, 0, 1);
	element.read("angular_damping", scene.world.angularDamping, 0, 1);
	scene.info.steps = 1200;
	element.read("solver_iterations", scene.world.solverIterations, 1, 10'000);
	element.read("steps", scene.info.steps, 1, 10'000'000);
	scene.info.dt = 1.0 / 240;
	element.read("step_seconds", scene.info.dt, 1e-6, 1);
	scene.info.worldScale = scene.info.overview.radius = 0;  // see fitToModels
	element.read("tolerance", scene.info.tolerance, 0, kLargest);
	element.read("world_scale", scene.info.worldScale, 1e-12, 1e12);
	Vec3 gravity{0, -kGravity, 0};
	element.read("gravity", gravity);
	scene.gravity = [gravity](double) { return gravity; };
}

SceneDefinition sceneOf(const Element& element, const std::string& path)
{
	element.allow({"$schema", "name", "summary", "models", "bodies", "gravity", "material", "linear_damping",
				   "angular_damping", "solver_iterations", "steps", "step_seconds", "tolerance", "world_scale"});
	SceneDefinition scene;
	scene.info.name = element.has("name") ? element.member("name").text() : std::filesystem::path(path).stem().string();
	if (element.has("summary")) scene.info.summary = element.member("summary").text();
	readWorld(scene, element);
	const std::filesystem::path folder = std::filesystem::path(path).parent_path();
	for (const Element& model : element.member("models").items())
	{
		scene.info.models.push_back(modelOf(model, folder));
		for (std::size_t i = 0; i + 1 < scene.info.models.size(); ++i)
			if (scene.info.models[i].name == scene.info.models.back().name)
				model.refuse(fmt::format("another model is called '{}' too", scene.info.models[i].name));
	}
	const std::vector<Element> bodies = element.member("bodies").items();
	if (bodies.size() < 2 || bodies.size() > kMostBodies)
		element.member("bodies").refuse(fmt::format("has to hold 2 to {} bodies", kMostBodies));
	for (const Element& body : bodies) addBody(scene, body);
	if (std::none_of(scene.bodies.begin(), scene.bodies.end(), [](const BodyDefinition& b) { return b.mass > 0; }))
		element.member("bodies").refuse("none has a mass: nothing would move");
	scene.info.hasGround = false;
	scene.inPlace = [](std::size_t, const Vec3&) { return true; };  // a file says nothing of where bodies should end
	return scene;
}
}  // namespace

Result<SceneDefinition> readScene(const std::string& path)
{
	const Result<std::vector<std::byte>> bytes = cli::readFile(path, kMostBytes);
	if (!bytes) return Error{bytes.error()};
	return parseScene({reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()}, path);
}

Result<SceneDefinition> parseScene(std::string_view text, const std::string& path)
{
	try
	{
		TwiceWritten members;
		const json document = json::parse(text,
										  [&](int, json::parse_event_t event, json& value)
										  {
											  members.follow(event, value);
											  return true;
										  });
		return sceneOf(Element(document, ""), path);
	}
	catch (const json::exception& problem)
	{
		const std::string why = problem.what();  // after the library's own number for it
		return Error{fmt::format("{}: no JSON: {}", path, why.substr(why.find("] ") + 2))};
	}
	catch (const Problem& problem)
	{
		return Error{fmt::format("{}: {}", path, problem.sentence)};
	}
}

std::string tooFar(const SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	for (std::size_t i = 0; i < scene.bodies.size(); ++i)
	{
		const BodyDefinition& body = scene.bodies[i];
		const double radius = double(models[scene.info.bodies[i].model]->asset().radius);
		const auto why = [&](const std::string& name, const Vec3& place) -> std::string
		{
			if (length(place) <= kFarthest * radius) return {};
			return fmt::format("bodies[{}].{}: {:.3g} times the body's radius ({:.3g}) from the origin; the limit is {:g}",
							   i, name, length(place) / radius, radius, kFarthest);
		};
		if (const std::string told = why("position", body.start.position); !told.empty()) return told;
		for (std::size_t k = 0; k < body.joints.size(); ++k)
			if (const std::string told = why(fmt::format("joints[{}].point", k), body.joints[k].point); !told.empty())
				return told;
	}
	return {};
}

void fitToModels(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	SceneInfo& info = scene.info;
	double largest = 0, smallest = std::numeric_limits<double>::infinity();
	for (const SceneBody& body : info.bodies)
	{
		const double radius = double(models[body.model]->asset().radius);
		largest = std::max(largest, radius);
		smallest = std::min(smallest, radius);
	}
	constexpr double kFar = std::numeric_limits<double>::infinity();
	Vec3 low{kFar, kFar, kFar}, high = -low;
	for (std::size_t i = 0; i < info.bodies.size(); ++i)
	{
		const Asset& asset = models[info.bodies[i].model]->asset();
		const double radius = double(asset.radius);
		const Vec3 center = toTransform(scene.bodies[i].start) *
							Vec3{asset.meshFromBody[0], asset.meshFromBody[1], asset.meshFromBody[2]};
		// A static ground may be far larger than what happens on it.
		const double shown = scene.bodies[i].mass > 0 ? radius : std::min(radius, 2 * smallest);
		for (int k = 0; k < 3; ++k)
		{
			low[k] = std::min(low[k], center[k] - shown);
			high[k] = std::max(high[k], center[k] + shown);
		}
	}
	if (info.tolerance == 0) info.tolerance = kToleranceShare * smallest;
	if (info.thinnerWall == 0) info.thinnerWall = kWallShare * smallest;
	if (info.worldScale == 0) info.worldScale = kBulletRadius / largest;
	if (info.overview.radius == 0)
	{
		const Vec3 middle = 0.5 * (low + high);
		info.overview = {middle, length(high - low) / 2, 20, 20, -1, "the whole scene"};
		info.closeUp = {middle, length(high - low) / 4, 60, 25, -1, "close-up"};
	}
}
}  // namespace clod::demo
