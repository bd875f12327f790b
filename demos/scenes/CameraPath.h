// SPDX-License-Identifier: Zlib
// Where the camera of view metrics is, step by step.
#pragma once
#include <algorithm>
#include <cstdint>

#include "clod/query/ContactMetric.h"

namespace clod::demo
{
// Part of a way of `steps` steps that lies behind at a step, 0 to 1; without steps there is none.
inline double partOfWay(std::int64_t step, std::int64_t steps)
{
	return steps > 0 ? std::clamp(double(step) / double(steps), 0.0, 1.0) : 0.0;
}

// The same picture of a world whose lengths are multiplied.
inline ViewCamera scaled(ViewCamera camera, double scale)
{
	camera.eye = scale * camera.eye;
	camera.nearDistance *= scale;
	return camera;
}

// A camera that goes evenly and straight from `start` to `end` in `steps` steps, then stays; 0: it stands.
struct CameraPath
{
	ViewCamera start, end;
	std::int64_t steps = 0;

	ViewCamera at(std::int64_t step) const
	{
		const double way = partOfWay(step, steps);
		ViewCamera camera = start;
		camera.eye += way * (end.eye - start.eye);
		camera.fieldOfView += way * (end.fieldOfView - start.fieldOfView);
		camera.nearDistance += way * (end.nearDistance - start.nearDistance);
		return camera;
	}
};
}  // namespace clod::demo
