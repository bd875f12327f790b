// SPDX-License-Identifier: Zlib
// Digits on a floor: lying flat in stacks of ten (pile-stacks), poured onto a heap (pile-heap), or each by itself. A
// hundred, or as many as wanted.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "demos/models/Models.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
namespace constant
{
constexpr int digits = 10, inStack = 10, leastStacksInRow = 5, inLayer = 7, inHeap = 100;
constexpr double digitMass = 0.002, digitRadius = 0.0122, digitThickness = 0.005, stroke = 0.0032, friction = 0.5;
constexpr double stackGap = 0.0001, stackAcross = 0.020, stackAlong = 0.028;
constexpr double heapGap = 0.075, fieldGap = 0.040;  // from one to the next
constexpr double floorHalf = 0.010;  // half its thickness
constexpr double layer = 0.0255, spacing = 0.0255, lowestLayer = 0.020;
constexpr double reach = 0.100;  // a digit farther from the middle has left the floor
constexpr double border = 0.050;        // of the floor round what lies on it
constexpr double borderOfHeap = 0.150;  // likewise: digits roll away
constexpr std::uint64_t seed = 1;
constexpr int steps = 1440, iterations = 50;  // of the solver; stacks need no more than others
}  // namespace constant

// kinds: of digits. half: of the floor.
SceneDefinition digitsOnFloor(const std::string& name, const std::string& summary, int kinds, double half)
{
	SceneDefinition scene = mechanism(name, summary, constant::friction);
	SceneInfo& info = scene.info;
	const double scale = std::max(1.0, half / constant::reach), reach = scale * constant::reach;
	info.models = {{"floor", "", scale}};
	info.bodies = {{"floor", 0, true}};
	scene.bodies = {{0, {{0, -scale * constant::floorHalf, 0}}, {}}};
	for (int digit = 0; digit < std::min(kinds, constant::digits); ++digit)
		info.models.push_back({"number" + std::to_string(digit), ""});
	info.tolerance = 0.01 * constant::digitRadius;
	info.thinnerWall = constant::stroke;
	info.steps = constant::steps;
	scene.world.warmstartingFactor = kWarmstartingOfPiles;
	info.overview = {{0, 0.03, 0}, 0.11, 20, 30, -1, ""};
	info.closeUp = {{0, 0.02, 0}, 0.045, 20, 30, -1, "close-up"};
	scene.inPlace = [reach](std::size_t, const Vec3& center)
	{ return center.y > 0 && std::max(std::fabs(center.x), std::fabs(center.z)) < reach; };
	return scene;
}

void addDigit(SceneDefinition& scene, int digit, int index, const Pose& pose)
{
	scene.info.bodies.push_back(
		{"number" + std::to_string(digit) + "-" + std::to_string(index + 1), std::size_t(digit) + 1, false});
	scene.bodies.push_back({constant::digitMass, pose, {}});
}

double uniform(std::mt19937_64& random)
{
	return double(random() >> 11) / double(std::uint64_t(1) << 53);
}
// Places in rows, as square as it goes, round the middle.
class Grid
{
public:
	Grid(int count, int inRow, double across, double along)
		: m_inRow(std::max(inRow, int(std::ceil(std::sqrt(count))))),
		  m_rows((count + m_inRow - 1) / m_inRow),
		  m_across(across),
		  m_along(along)
	{
	}
	Vec3 at(int i, double height) const
	{
		return {(i % m_inRow - 0.5 * (m_inRow - 1)) * m_across, height, (i / m_inRow - 0.5 * (m_rows - 1)) * m_along};
	}
	double farthest() const { return 0.5 * std::max((m_inRow - 1) * m_across, (m_rows - 1) * m_along); }

private:
	int m_inRow, m_rows;
	double m_across, m_along;
};

double heightInStack(int place)
{
	return (place + 0.5) * constant::digitThickness + (place + 1) * constant::stackGap;
}

SceneDefinition stacks(int count, const std::string& name, const std::string& summary)
{
	const int stacks = (count + constant::inStack - 1) / constant::inStack;
	const Grid grid(stacks, constant::leastStacksInRow, constant::stackAcross, constant::stackAlong);
	SceneDefinition scene = digitsOnFloor(name, summary, stacks, grid.farthest() + constant::border);
	scene.info.overview = {{0, 0.015, 0}, grid.farthest() + 0.03, 20, 30, -1, ""};
	for (int i = 0; i < count; ++i)
	{
		const int stack = i / constant::inStack, place = i % constant::inStack;
		addDigit(scene, stack % constant::digits, i,
				 turnedAbout({1, 0, 0}, -kPi / 2, grid.at(stack, heightInStack(place))));
	}
	scene.constants = {{"stack_gap", constant::stackGap, "m"}};
	return scene;
}

// Of a hundred each, so near each other that they meet.
SceneDefinition heaps(int count, const std::string& name, const std::string& summary)
{
	const Grid grid((count + constant::inHeap - 1) / constant::inHeap, 1, constant::heapGap, constant::heapGap);
	SceneDefinition scene = digitsOnFloor(name, summary, count, grid.farthest() + constant::borderOfHeap);
	scene.world.solverIterations = constant::iterations;
	const int layers = (std::min(count, constant::inHeap) + constant::inLayer - 1) / constant::inLayer;
	const double high = constant::lowestLayer + layers * constant::layer;
	scene.info.overview = {{0, high / 2, 0}, high / 2 + grid.farthest(), 20, 30, -1, ""};
	std::mt19937_64 random(constant::seed);
	for (int i = 0; i < count; ++i)
	{
		const int layer = i % constant::inHeap / constant::inLayer, place = i % constant::inHeap % constant::inLayer;
		const double angle = 2 * kPi / (constant::inLayer - 1) * (place + 0.5 * (layer % 2));
		const double out = place == 0 ? 0 : constant::spacing;
		const Vec3 middle = grid.at(i / constant::inHeap, constant::lowestLayer + layer * constant::layer);
		// Uniform over all orientations (Shoemake 1992).
		const double u = uniform(random), v = 2 * kPi * uniform(random), w = 2 * kPi * uniform(random);
		addDigit(scene, i % constant::digits, i,
				 {middle + Vec3{out * std::cos(angle), 0, out * std::sin(angle)},
				  {std::sqrt(1 - u) * std::sin(v), std::sqrt(1 - u) * std::cos(v), std::sqrt(u) * std::sin(w),
				   std::sqrt(u) * std::cos(w)}});
	}
	scene.constants = {{"lowest_layer", constant::lowestLayer, "m"}, {"seed", double(constant::seed), ""}};
	return scene;
}

SceneDefinition field(int count, const std::string& name)
{
	const Grid grid(count, 1, constant::fieldGap, constant::fieldGap);
	SceneDefinition scene = digitsOnFloor(name, "digits lie flat, each by itself", count, grid.farthest() + constant::border);
	scene.world.solverIterations = constant::iterations;
	for (int i = 0; i < count; ++i)
		addDigit(scene, i % constant::digits, i, turnedAbout({1, 0, 0}, -kPi / 2, grid.at(i, heightInStack(0))));
	return scene;
}
}  // namespace

SceneDefinition pileStacks()
{
	return stacks(100, "pile-stacks", "a hundred digits lie flat in ten stacks");
}

SceneDefinition pileHeap()
{
	return heaps(100, "pile-heap", "a hundred digits fall onto a heap");
}

SceneDefinition digits(Arrangement arrangement, int count)
{
	const std::string number = std::to_string(count);
	if (arrangement == Arrangement::stacks) return stacks(count, "stacks of " + number, "digits lie flat in stacks of ten");
	if (arrangement == Arrangement::heap) return heaps(count, "heap of " + number, "digits fall onto heaps");
	return field(count, "field of " + number);
}
}  // namespace clod::demo
