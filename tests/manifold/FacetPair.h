// SPDX-License-Identifier: GPL-3.0-or-later
// Two bodies at a pose and the points of their contacts, without an engine and without a last step.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "clod/manifold/FacetContacts.h"
#include "clod/manifold/PairSolve.h"
#include "clod/query/Query.h"
#include "tests/bullet/PatchHierarchy.h"

namespace clod::test
{
using HierarchyPointer = std::shared_ptr<const Hierarchy>;

inline void setUnitMasses(PointRules& rules)
{
	for (PairBody* body : {&rules.a, &rules.b})
	{
		body->inverseMass = 1;
		body->inverseInertia = Mat3{};
	}
}

struct FacetPair
{
	HierarchyPointer a, b;
	Transform aFromB;
	PointRules rules;

	FacetPair(HierarchyPointer first, HierarchyPointer second, const Transform& pose)
		: a(std::move(first)), b(std::move(second)), aFromB(pose)
	{
		rules.length = std::min(double(a->asset().radius), double(b->asset().radius));
		rules.resting = kRestingShare * rules.length;
		rules.b.center = pose.translation;
	}
	// B moves on so far in a step, all at once.
	void move(const Vec3& way)
	{
		rules.timeStep = 1.0 / 240;
		setUnitMasses(rules);
		rules.b.linear = (1 / rules.timeStep) * way;
	}
	std::vector<ContactPoint> points() const
	{
		FacetMemory memory;
		return points(memory);
	}
	ContactResult result() const
	{
		ContactSettings settings;
		settings.metric.exact = true;
		settings.tolerance = rules.margin + rules.resting;
		settings.sweep = {kPathReach * rules.timeStep * rules.b.linear, {}};
		PairCache cache;
		ContactResult result;
		contacts(*a, *b, aFromB, settings, cache, result);
		return result;
	}
	std::vector<ContactPoint> points(FacetMemory& memory) const
	{
		const ContactResult result = this->result();
		FacetContacts facets;
		ClusterSet none, set;
		facets.find(contactBody(*a), contactBody(*b), aFromB, rules, result.contacts, none, memory);
		facets.settle(result.contacts, result.deep);
		facets.reduce(set);
		std::vector<ContactPoint> points;
		for (const ContactCluster& cluster : set.slots)
			for (int i = 0; i < cluster.count; ++i) points.push_back(cluster.points[std::size_t(i)].point);
		return points;
	}
};

inline HierarchyPointer cubeOf(int cells = 2)
{
	return patchHierarchy(boxMesh({1, 1, 1}, {cells, cells, cells}, 1));
}

inline Transform at(const Vec3& place, const Mat3& turn = {})
{
	return {turn, place};
}
}  // namespace clod::test
