// SPDX-License-Identifier: Zlib
// One probe a connected component.
#include "clod/query/InsideTest.h"

#include <algorithm>
#include <limits>

#include "clod/query/Constants.h"

namespace clod
{
namespace
{
// One corner of each connected component of the input surface.
std::vector<Vec3> componentPoints(const Hierarchy& hierarchy)
{
	const Level& level = hierarchy.levels()[0];
	std::vector<Vec3> points;
	std::vector<bool> seen(level.faceCount, false);
	std::vector<std::uint32_t> stack;
	for (std::uint32_t first = 0; first < level.faceCount; ++first)
	{
		if (seen[first]) continue;
		const std::uint32_t face = level.firstFace + first;
		const Node& owner = hierarchy.node(ownerOf(hierarchy, face));
		points.push_back(triangleOf(hierarchy, owner, hierarchy.faces()[face])[0]);
		if (points.size() == hierarchy.asset().componentCount) break;
		seen[first] = true;
		stack.push_back(first);
		while (!stack.empty())
		{
			const Face& top = hierarchy.faces()[level.firstFace + stack.back()];
			stack.pop_back();
			for (const std::uint32_t neighbour : top.neighbour)
			{
				if (seen[neighbour - level.firstFace]) continue;
				seen[neighbour - level.firstFace] = true;
				stack.push_back(neighbour - level.firstFace);
			}
		}
	}
	return points;
}
}  // namespace

void InsideProbes::prepare(const Hierarchy& hierarchy)
{
	if (!m_probes.empty()) return;
	for (const Vec3& point : componentPoints(hierarchy)) m_probes.push_back({point});
}

// The face that was nearest is not far.
void InsideProbes::test(Probe& probe, const Hierarchy& other, const Vec3& place, QueryStats& stats)
{
	double within = std::numeric_limits<double>::infinity();
	if (probe.face != kNone)
	{
		const Node& owner = other.node(ownerOf(other, probe.face));
		within = std::sqrt(nearestOnTriangle(triangleOf(other, owner, other.faces()[probe.face]), place).squared);
	}
	++stats.pointQueries;
	const SignedDistance found = distanceToInput(other, place, stats.boxTests, within);
	probe.place = place;
	probe.distance = found.distance;
	probe.face = found.face;
}

// The sign holds until the point has moved by the distance: from where it was tested, or where the surfaces were found
// apart.
bool InsideProbes::holds(Probe& probe, const Vec3& place, double apart)
{
	const double left = kKeptOfSign * probe.distance - length(place - probe.place);
	if (!(left > 0)) return false;
	if (apart > left)
	{
		probe.place = place;
		probe.distance = apart;
	}
	return true;
}

double InsideProbes::depthInside(const Hierarchy& other, const Transform& intoOther, double apart, QueryStats& stats)
{
	const bool areOutside = std::all_of(m_probes.begin(), m_probes.end(), [&](Probe& probe)
										{ return holds(probe, intoOther * probe.point, apart); });
	if (areOutside)
	{
		stats.skippedBySlack += std::uint32_t(m_probes.size());
		return 0;
	}
	const OrientedBox& around = other.cullBox(other.root());
	double depth = 0;
	for (Probe& probe : m_probes)
	{
		const Vec3 place = intoOther * probe.point;
		if (boxDistance(around, place) > 0 || holds(probe, place, apart)) continue;
		test(probe, other, place, stats);  // how deep inside is measured anew
		depth = std::max(depth, -probe.distance);
	}
	return depth;
}

double InsideProbes::distanceOutside(const Hierarchy& other, const Transform& intoOther, double wanted,
									 QueryStats& stats)
{
	double least = wanted / kKeptOfSign;
	for (Probe& probe : m_probes)
	{
		const Vec3 place = intoOther * probe.point;
		const double toBox = boxDistance(other.cullBox(other.root()), place);
		if (toBox >= least || probe.distance - length(place - probe.place) >= least) continue;
		test(probe, other, place, stats);
		least = std::min(least, std::max(toBox, probe.distance));
	}
	return kKeptOfSign * std::max(0.0, least);
}
}  // namespace clod
