// SPDX-License-Identifier: Zlib
// Two identical spoons, one lying in the other, held at three gaps while the upper one circles a little: large-area
// parallel contact, where methods differ most. Both follow courses; nothing is simulated.
#include <algorithm>
#include <cmath>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr double gapShares[] = {0.001, 0.005, 0.01};  // held gaps, of the spoon's radius
constexpr double radius = 0.0701;                     // of the spoon
constexpr double holdTime = 0.6, changeTime = 0.1;    // seconds at each gap, and between two
// The upper spoon's circling along x and z: lengths of the half axes, turns a second.
constexpr double alongReach = 0.0015, alongFrequency = 1.1, acrossReach = 0.0008, acrossFrequency = 1.7;
constexpr double keyStep = 5.0 / 240;  // seconds between poses that are found exactly
constexpr double gapError = 0.02;      // of the gap, at those poses
constexpr int attempts = 40;
}  // namespace constant

double gapAt(double time)
{
	constexpr double period = constant::holdTime + constant::changeTime;
	const int last = int(std::size(constant::gapShares)) - 1;
	const int now = std::min(last, int(time / period)), next = std::min(last, now + 1);
	const double change = smoothStep((time - now * period - constant::holdTime) / constant::changeTime);
	return constant::radius *
		   (constant::gapShares[now] + change * (constant::gapShares[next] - constant::gapShares[now]));
}

Vec3 sideways(double time)
{
	return {constant::alongReach * std::sin(2 * kPi * constant::alongFrequency * time), 0,
			constant::acrossReach * std::sin(2 * kPi * constant::acrossFrequency * time)};
}

// Heights at which one solid keeps a wanted gap over its copy.
class Lift
{
public:
	explicit Lift(const Hierarchy& spoon) : m_spoon(spoon)
	{
		m_settings.metric.exact = true;
		m_settings.distance = true;
	}
	// The gap grows with the height, at most as fast: going up by what is missing never overshoots, and the secant
	// through the last two heights speeds it up.
	double over(const Vec3& place, double gap, double start)
	{
		double height = start, before = 0, gapBefore = 0;
		for (int i = 0; i < constant::attempts; ++i)
		{
			const double now = gapOf({{}, {place.x, height, place.z}});
			if (std::fabs(now - gap) <= constant::gapError * gap) break;
			const double slope = i > 0 && height != before ? (now - gapBefore) / (height - before) : 1;
			before = height;
			gapBefore = now;
			height += (gap - now) / std::clamp(slope, 0.3, 1.0);
		}
		return height;
	}

private:
	double gapOf(const Transform& lowerFromUpper)
	{
		signedGap(m_spoon, m_spoon, lowerFromUpper, m_settings, m_cache, m_result);
		return m_result.minDistance;
	}
	const Hierarchy& m_spoon;
	GapSettings m_settings;
	GapCache m_cache;
	GapResult m_result;
};

void findCourse(SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models)
{
	Lift lift(*models[0]);
	std::vector<double> heights;
	double height = 2 * SPOON_BOWL_THICKNESS;
	for (double time = 0; time < scene.info.steps * scene.info.dt + constant::keyStep; time += constant::keyStep)
	{
		height = lift.over(sideways(time), gapAt(time), height);
		heights.push_back(height);
	}
	scene.bodies[1].course = [heights](double time)
	{
		const double key = std::clamp(time / constant::keyStep, 0.0, double(heights.size() - 1));
		const std::size_t low = std::min(std::size_t(key), heights.size() - 2);
		Vec3 place = sideways(time);
		place.y = heights[low] + (key - double(low)) * (heights[low + 1] - heights[low]);
		return Pose{place, {0, 0, 0, 1}};
	};
}

SceneInfo describe()
{
	SceneInfo info;
	info.name = "spoons-nested";
	info.summary = "a spoon held in an identical one at three gaps, circling";
	info.models = {{"spoon", ""}};
	info.bodies = {{"lower", 0, false}, {"upper", 0, true}};
	info.tolerance = 1.1 * constant::gapShares[2] * constant::radius;
	info.thinnerWall = SPOON_BOWL_THICKNESS;
	info.dt = 1.0 / 240;
	info.steps = 480;
	info.worldScale = 100;
	info.overview = {{0.07, 0.01, 0}, 0.075, 25, 40, -1, ""};
	info.closeUp = {{0.023, 0, 0}, 0.030, 30, 35, -1, "close-up of the bowls, through the upper spoon"};
	info.hasGround = false;
	return info;
}
}  // namespace

SceneDefinition spoonsNested()
{
	SceneDefinition scene;
	scene.info = describe();
	scene.bodies.resize(2);
	scene.gravity = steadyGravity;
	scene.inPlace = [](std::size_t, const Vec3&) { return true; };
	scene.prepare = findCourse;
	using namespace constant;
	scene.constants = {{"held_gap_1", gapShares[0] * radius, "m"}, {"held_gap_2", gapShares[1] * radius, "m"},
					   {"held_gap_3", gapShares[2] * radius, "m"}, {"hold_time", holdTime, "s"},
					   {"change_time", changeTime, "s"},           {"along_reach", alongReach, "m"},
					   {"along_frequency", alongFrequency, "Hz"},  {"across_reach", acrossReach, "m"},
					   {"across_frequency", acrossFrequency, "Hz"}};
	return scene;
}
}  // namespace clod::demo
