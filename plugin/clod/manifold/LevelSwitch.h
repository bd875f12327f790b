// SPDX-License-Identifier: Zlib
// Makes a change of level smooth. Another level's surface lies elsewhere: where it lies back the bodies would fall, where
// it lies forward they would be thrust apart. So points that carried go on while their level is no longer asked for, and
// let the bodies down slowly; and an overlap that came with the new level is left as slowly.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/Facet.h"
#include "clod/query/Query.h"

namespace clod
{
inline constexpr double kIdle = 0.1;  // seconds that a point goes on without a load, as loads wander between points

// Of a pair, from step to step.
struct SwitchMemory
{
	struct Levels
	{
		std::uint32_t a, b;
		bool operator==(const Levels& other) const { return a == other.a && b == other.b; }
	};
	std::vector<Levels> asked;  // of the last dispatch
	double overlap = 0;         // came with a change of level, and is left slowly: less each step, wherever the bodies are
	bool isOther = false;       // B's surface is another than in the last dispatch, by no change of level: nothing goes on
	CLOD_API void passStep(const PointRules& rules);
};

// For any number of pairs, one after the other.
class LevelSwitch
{
public:
	// Appends to the facets those of `reduced`, which the solver got last, that go on; their points are `previous`
	// (with B's motion and impulses). stays: nothing but the motion of the rules has changed.
	void apply(const FacetQuestion& question, const std::vector<Contact>& contacts, const std::vector<FacetRecord>& reduced,
			   const ClusterSet& previous, bool stays, SwitchMemory& memory, std::vector<Facet>& facets);
	// Does the facet go on although its level is no longer asked for?
	bool isOfLevelLeft(const Facet& facet) const
	{
		return facet.kind == Facet::Kind::kHeld && !isAmong(m_asked, facet);
	}
	// Of a facet of kind kHeld, as last written.
	const ContactPoint& pointOf(const Facet& held) const { return m_points[held.featureA]; }

private:
	static bool isAmong(const std::vector<SwitchMemory::Levels>& asked, const Facet& facet);
	bool isLost(const FacetQuestion& question, const ContactPoint& old, const Transform& motionOfB, const Facet& facet,
				Span<Facet> found) const;
	bool goOn(const FacetQuestion& question, const ContactPoint& point, const Transform& motionOfB, Facet& facet);

	std::vector<SwitchMemory::Levels> m_asked;
	std::vector<ContactPoint> m_points;
};

// Length a second at which bodies are let down, or leave an overlap that came with a level.
CLOD_API double switchSpeed(const PointRules& rules);
}  // namespace clod
