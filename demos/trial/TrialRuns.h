// SPDX-License-Identifier: Zlib
// Runs the trial's scene with one contender and measures it with code of its own: interpenetration of the full meshes,
// and how far contact points lie off their surfaces.
#pragma once
#include <functional>
#include <memory>

#include "demos/runner/Penetration.h"
#include "demos/trial/Trial.h"

namespace clod::demo
{
struct TrialRules
{
	int steps = 0, every = 1;  // steps a film's frame
	double dt = 0;
	double mostSeconds = 0;  // a contender that takes longer is stopped, and the report says so
};

using Solids = std::vector<std::shared_ptr<const SignedDistance>>;  // one a model
// The deepest interpenetration; where there is none at all, the contact point that is farthest off the surfaces.
std::size_t worstFrame(const std::vector<TrialFrame>& frames);

TrialRun runContender(const Trial& trial, const Contender& contender, const Solids& solids, const TrialRules& rules,
					  const std::function<void(double)>& progress);
}  // namespace clod::demo
