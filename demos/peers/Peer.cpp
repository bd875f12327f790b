// SPDX-License-Identifier: Zlib
// What all peers share.
#include "demos/peers/Peer.h"

#include <algorithm>

namespace clod::demo
{
std::size_t PoseSample::measured() const
{
	return std::size_t(std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.measured; }));
}

PoseSample PoseSample::atRest() const
{
	PoseSample still = *this;
	for (Row& row : still.rows) row.before = row.poses;
	return still;
}

PoseSample PoseSample::cold() const
{
	PoseSample first = *this;
	first.isCold = true;
	first.rows.clear();
	std::copy_if(rows.begin(), rows.end(), std::back_inserter(first.rows), [](const Row& row) { return row.measured; });
	return first;
}

PoseSample::Row recordedRow(const std::vector<PoseRow>& poses, std::size_t row, const RowClock& clock)
{
	const PoseRow& before = poses[row > 0 ? row - 1 : 0];
	return {poses[row], before, secondsBetween(before, poses[row], clock)};
}
}  // namespace clod::demo
