// SPDX-License-Identifier: GPL-3.0-or-later
// A hash of the bits of numbers, one after the other (FNV's step), and of the way that bodies go.
#pragma once
#include <cstdint>
#include <cstring>

namespace clod::test
{
inline std::uint64_t mixed(std::uint64_t hash, double value)
{
	std::uint64_t bits;
	std::memcpy(&bits, &value, sizeof bits);
	return (hash ^ bits) * 0x100000001B3u;
}

// Steps a world of Bullet's, and hashes where the bodies are after each step.
template <class World, class Bodies, class Scalar>
std::uint64_t hashOfWay(World& world, const Bodies& bodies, Scalar timeStep, int steps)
{
	std::uint64_t hash = 0;
	for (int i = 0; i < steps; ++i)
	{
		world.stepSimulation(timeStep, 0);
		for (const auto& body : bodies)
			for (int k = 0; k < 3; ++k) hash = mixed(hash, double(body->getWorldTransform().getOrigin()[k]));
	}
	return hash;
}
}  // namespace clod::test
