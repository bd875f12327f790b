// SPDX-License-Identifier: Zlib
// Is one body, or a component of it, wholly inside the other? Asked only when no contact hulls overlap: the surfaces
// are then apart, and one point of each component tells.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/hierarchy/InputSurface.h"
#include "clod/query/QueryContext.h"

namespace clod
{
// What the test needs of one hierarchy, gathered at the first test: it reads level 0.
class CLOD_API InsideProbes
{
public:
	void prepare(const Hierarchy& hierarchy);
	void clear() { m_probes.clear(); }

	// The deepest of the probes inside `other`, as a depth > 0; 0 when all of them are outside. intoOther maps the own
	// body frame into that of `other`. apart: the two surfaces are at least so far from each other, if known.
	double depthInside(const Hierarchy& other, const Transform& intoOther, double apart, QueryStats& stats);

	// No probe comes to lie inside before it has moved so far, looked at up to `wanted`; 0 where one is already.
	double distanceOutside(const Hierarchy& other, const Transform& intoOther, double wanted, QueryStats& stats);

private:
	struct Probe
	{
		Vec3 point;  // a vertex of one component
		// Where it was in the other body, and how far outside its surface at least; of the last test the nearest face
		// of that, and how far exactly, inside as well.
		Vec3 place = {};
		double distance = 0;
		std::uint32_t face = kNone;
	};
	static bool holds(Probe& probe, const Vec3& place, double apart);
	static void test(Probe& probe, const Hierarchy& other, const Vec3& place, QueryStats& stats);
	std::vector<Probe> m_probes;  // one a component
};

// Counts boxes that point queries meet in its lifetime as such.
class PointBoxes
{
public:
	explicit PointBoxes(QueryStats& stats) : m_stats(stats), m_before(stats.boxTests) {}
	~PointBoxes()
	{
		m_stats.pointBoxes += m_stats.boxTests - m_before;
		m_stats.boxTests = m_before;
	}
	PointBoxes(const PointBoxes&) = delete;
	PointBoxes& operator=(const PointBoxes&) = delete;

private:
	QueryStats& m_stats;
	const std::uint32_t m_before;
};
}  // namespace clod
