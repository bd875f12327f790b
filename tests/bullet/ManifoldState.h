// SPDX-License-Identifier: GPL-3.0-or-later
// All bits of a world's bodies and manifold points, for worlds that must not differ; and Bullet's global callbacks.
#pragma once
#include <cstdint>
#include <vector>

#include "tests/bullet/BulletWorld.h"

namespace clod::test
{
// Sets a callback of Bullet's for the time of a scope.
template <class Callback>
class SetCallback
{
public:
	SetCallback(Callback& callback, Callback value) : m_callback(callback), m_before(callback) { callback = value; }
	~SetCallback() { m_callback = m_before; }
	SetCallback(const SetCallback&) = delete;
	SetCallback& operator=(const SetCallback&) = delete;

private:
	Callback& m_callback;
	Callback m_before;
};

using Bits = std::vector<std::uint64_t>;
// Bodies and manifolds, in Bullet's order, and what the pairs report of their points. Without the directions of
// friction, which the solver chooses anew in every step.
Bits stateOf(BulletWorld& scene);
std::vector<btPersistentManifold*> manifoldsOf(BulletWorld& scene);
// Of all manifold points, along their normals.
double impulseOf(BulletWorld& scene);
}  // namespace clod::test
