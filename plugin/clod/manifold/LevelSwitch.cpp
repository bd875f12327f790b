// SPDX-License-Identifier: Zlib
#include "clod/manifold/LevelSwitch.h"

#include <algorithm>
#include <cmath>

#include "clod/query/StopRule.h"

namespace clod
{
namespace
{
constexpr double kSwitchShare = 5e-5;   // of the speed of a fall by the length; a motion gains some ten times of it
constexpr double kBesideShare = 0.01;   // of the length: the most that a point that goes on may have slid
constexpr double kUnmovedShare = 1e-5;  // of the length a step: bodies that move less lose no contact by their motion

// By how much the surfaces of a facet's nodes may lie in front of what they stand for.
double errorOf(const FacetQuestion& question, const Facet& facet)
{
	const Node& a = question.a.hierarchy->node(facet.nodeA);
	if (!question.b.hierarchy) return std::max(a.cover, a.protrude);
	return certifiedErrorApart(a, question.b.hierarchy->node(facet.nodeB));
}
}  // namespace

double switchSpeed(const PointRules& rules)
{
	const double pull = rules.timeStep > 0 ? std::max(length(rules.a.force), length(rules.b.force)) / rules.timeStep : 0;
	return kSwitchShare * std::sqrt(std::max(pull, rules.length) * rules.length);
}

void SwitchMemory::passStep(const PointRules& rules)
{
	overlap = std::max(0.0, overlap - switchSpeed(rules) * rules.timeStep);
}

// Makes a facet of last step's point: between its two places as they are now, margins taken off. False if it slid away.
bool LevelSwitch::goOn(const FacetQuestion& question, const ContactPoint& point, const Transform& motionOfB,
					   Facet& facet)
{
	const PointRules& rules = question.rules;
	const Vec3 normalWithB = motionOfB.rotation * point.normal;
	const Vec3 onB = motionOfB * point.pointOnA - dot(point.normal, point.pointOnA - point.pointOnB) * normalWithB;
	const double gap = dot(point.normal, point.pointOnA - onB);
	const double most = kBesideShare * question.length();
	if (lengthSquared(point.pointOnA - onB - gap * point.normal) > most * most) return false;
	const double height = gap + rules.radiusA + rules.radiusB - rules.margin;
	facet.kind = Facet::Kind::kHeld;
	facet.isThrough = false;  // of a face that is there no longer
	facet.reach = Facet::Reach::kNear;
	facet.featureA = facet.featureB = std::uint32_t(m_points.size());
	facet.normal = point.normal;
	facet.onA = facet.ofA = point.pointOnA + rules.radiusA * point.normal;
	facet.onB = facet.ofB = onB - rules.radiusB * point.normal;
	facet.distance = facet.then = rules.margin + std::max(height, switchSpeed(rules) * rules.timeStep);
	facet.linear = facet.multiplier = facet.slowOverlap = 0;
	m_points.push_back(point);
	m_points.back().pointOnB = onB;
	m_points.back().goesOn = true;
	return true;
}

bool LevelSwitch::isAmong(const std::vector<SwitchMemory::Levels>& asked, const Facet& facet)
{
	return std::find(asked.begin(), asked.end(), SwitchMemory::Levels{facet.levelA, facet.levelB}) != asked.end();
}

// Has a point lost its facet though no motion of the bodies took it away?
bool LevelSwitch::isLost(const FacetQuestion& question, const ContactPoint& old, const Transform& motionOfB,
						 const Facet& facet, Span<Facet> found) const
{
	if (!isAmong(m_asked, facet)) return true;
	const double unmoved = kUnmovedShare * question.length();
	if (lengthSquared(motionOfB * old.pointOnA - old.pointOnA) > unmoved * unmoved) return false;
	return std::none_of(found.begin(), found.end(),
						[&](const Facet& f) { return f.feature == old.feature && f.reach != Facet::Reach::kPossible; });
}

void LevelSwitch::apply(const FacetQuestion& question, const std::vector<Contact>& contacts,
						const std::vector<FacetRecord>& reduced, const ClusterSet& previous, bool stays, SwitchMemory& memory,
						std::vector<Facet>& facets)
{
	m_points.clear();
	m_asked.clear();
	for (const Contact& contact : contacts)
	{
		const SwitchMemory::Levels levels = {question.a.levelOf(contact.nodeA), question.b.levelOf(contact.nodeB)};
		if (std::find(m_asked.begin(), m_asked.end(), levels) == m_asked.end()) m_asked.push_back(levels);
	}

	// Overlaps; fresh: of levels that were not asked for. Of bodies first seen it is the levels' unless one is deeper than
	// they may err: these overlap in truth.
	double deepest = 0, fresh = 0;
	bool isTrue = false;
	for (const Facet& facet : facets)
	{
		if (facet.kind == Facet::Kind::kDeep) continue;
		const double overlap = question.rules.margin - facet.distance;
		deepest = std::max(deepest, overlap);
		if (!isAmong(memory.asked, facet)) fresh = std::max(fresh, overlap);
		isTrue = isTrue || (memory.asked.empty() && overlap > errorOf(question, facet));
	}
	if (isTrue) fresh = 0;
	const std::size_t found = facets.size();
	double before = 0;
	const Transform& motionOfB = previous.motionOfB;
	forEachReduced(previous, reduced,
				   [&](const HeldPoint& old, const FacetRecord& record)
				   {
					   Facet facet{};
					   static_cast<FacetRecord&>(facet) = record;
					   const bool wasHeld = facet.kind == Facet::Kind::kHeld, carried = old.impulse > 0;
					   if (!wasHeld) before = std::max(before, -old.point.height);
					   const bool mayGoOn = !memory.isOther && facet.kind != Facet::Kind::kDeep && !record.isOfMiddle() &&
											(carried || (wasHeld && old.point.idle < kIdle));
					   const bool isGone =
						   !stays && mayGoOn && isLost(question, old.point, motionOfB, facet, {facets.data(), found});
					   if (!(stays ? wasHeld : isGone) || !goOn(question, old.point, motionOfB, facet)) return;
					   facets.push_back(facet);
					   m_points.back().idle = carried ? 0 : old.point.idle + (stays ? 0 : question.rules.timeStep);
				   });
	if (!stays)
	{
		memory.passStep(question.rules);
		memory.overlap = std::min(deepest, std::max(memory.overlap, fresh - before));
	}
	memory.asked = m_asked;
	for (Facet& facet : facets)
		if (facet.kind != Facet::Kind::kDeep)
			facet.slowOverlap = std::max(0.0, std::min(question.rules.margin - facet.distance,
													   std::max(facet.slowOverlap, memory.overlap)));
}
}  // namespace clod
