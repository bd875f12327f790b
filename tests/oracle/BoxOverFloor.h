// SPDX-License-Identifier: GPL-3.0-or-later
// The plainest family: a box over a large one, all its lower corners over the upper face.
#pragma once
#include "tests/oracle/Trial.h"

namespace clod::oracle
{
inline const Vec3 kHalfOfA{0.4, 0.5, 0.6}, kHalfOfB{2, 0.3, 2};

// Leaning by up to so much.
inline Family boxOverFloor(double lean)
{
	return {"box-over-floor", "",
			[]() -> std::vector<BodyPair> { return {{box(kHalfOfA), box(kHalfOfB)}}; },
			[lean](Random& random, std::size_t)
			{
				const Mat3 turn = rotation(random, lean);
				const Vec3 at{uniform(random, -1, 1), 1.1, uniform(random, -1, 1)};
				const Transform aFromB = inverse(Transform{turn, at});
				return Start{aFromB, aFromB.rotation * Vec3{0, -1, 0}, 0.6};
			}};
}

}  // namespace clod::oracle
