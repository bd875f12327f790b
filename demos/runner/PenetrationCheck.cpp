// SPDX-License-Identifier: Zlib
#include "demos/runner/PenetrationCheck.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace clod::demo
{
PenetrationCheck checkPenetration(const SceneRunOptions& run, const std::vector<Surface>& meshes,
								  std::vector<SceneRow>& rows, const std::function<void(double)>& progress)
{
	std::vector<std::shared_ptr<const SignedDistance>> solids;
	for (const Surface& mesh : meshes) solids.push_back(std::make_shared<SignedDistance>(mesh));
	const auto solid = [&](std::uint32_t body) { return solids[run.info.bodies[body].model]; };
	std::map<std::pair<std::uint32_t, std::uint32_t>, PenetrationMeter> meters;
	PenetrationCheck check;
	for (std::size_t i = 0; i < rows.size(); ++i)
	{
		for (const PoseRow& poses : posesOf(rows[i].state))
		{
			auto& meter =
				meters.try_emplace({poses.bodyA, poses.bodyB}, solid(poses.bodyA), solid(poses.bodyB)).first->second;
			const double depth = meter.depth(relativePose(poses, {}, {}));
			if (depth > check.deepest) check.deepest = depth, check.where = poses;
		}
		rows[i].deepest = check.deepest;
		for (const ReplayRow& pair : rows[i].pairs)
			if (!std::isinf(pair.errorBound)) check.bound = std::max(check.bound, pair.errorBound);
		if (run.scene.budget.isLimited()) check.bound = std::max(check.bound, rows[i].state.contactError);
		progress(double(i + 1) / double(rows.size()));
	}
	check.limit = kPenetrationShare * run.info.thinnerWall + (run.scene.metric.exact ? 0 : check.bound);
	return check;
}

nlohmann::ordered_json toJson(const PenetrationCheck& check, const SceneInfo& info)
{
	return {{"deepest", check.deepest},
			{"step", check.where.step},
			{"bodies", {info.bodies[check.where.bodyA].name, info.bodies[check.where.bodyB].name}},
			{"share_of_thinner_wall", check.deepest / info.thinnerWall},
			{"certified_bound_in_use", check.bound},
			{"limit", check.limit},
			{"within_limit", check.holds()}};
}
}  // namespace clod::demo
