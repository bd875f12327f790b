// SPDX-License-Identifier: Zlib
#include "clod/manifold/FacetContacts.h"

#include <algorithm>
#include <limits>

#include "clod/collide/Room.h"

namespace clod
{
namespace
{
Vec3 impulseOf(const ClusterSet& set)
{
	Vec3 sum;
	for (const ContactCluster& cluster : set.slots)
		for (int i = 0; i < cluster.count; ++i)
			sum += cluster.points[std::size_t(i)].impulse * cluster.points[std::size_t(i)].point.normal;
	return sum;
}

// Sine of the angle by which a way out has to leave every facet: two normals that are 154 degrees apart leave none.
constexpr double kWayOut = 0.225;
// The same where one of them is pressed in, as a tooth is between flanks of 25 degrees: what joints do not let out by
// that way is pushed back and forth.
constexpr double kWayOutOfPress = 0.45;
constexpr int kWayOutRounds = 64;
constexpr double kFarInStep = 0.5;  // of the length: who goes farther by may meet all of a body, from any side

// The triangle on which a place of the part lies (a part may have many); kNone for a thin core.
std::uint32_t faceOf(const ContactSurface& surface, Part part, std::uint32_t feature, std::uint32_t node,
					 const Vec3& place)
{
	if (surface.isCore()) return kNone;
	switch (part)
	{
		case Part::kVertex: return surface.faceOfVertex(feature);
		case Part::kEdge:
			return surface.nearestFaceOf(surface.faces()[surface.edges()[feature].face[0]].polygon, place);
		case Part::kPolygon: return surface.nearestFaceOf(feature, place);
		case Part::kPlace: break;
	}
	return surface.firstFaceOf(node);
}

// Does no way leave all facets that touch, each by at least the angle of that sine? Finds the shortest vector in the
// convex hull of the normals (Gilbert, 1966). Its length is the sine of the angle by which the best way out leaves the
// facet that it leaves least.
bool leaveNoWay(const FacetQuestion& question, const std::vector<Facet>& facets, double sine)
{
	const RelativeMotion motion = question.rules.motion();
	// What is low over a face, but comes over it only by going far, is aside of it now.
	const auto isAside = [&](const Facet& facet)
	{
		return facet.reach > Facet::Reach::kOverlap &&
			   length(motion.velocity(facet.onA)) * motion.timeStep > kFarInStep * question.length();
	};
	const auto counts = [&](const Facet& facet)
	{ return facet.kind != Facet::Kind::kDeep && facet.distance < question.touching() && !isAside(facet); };
	const auto first = std::find_if(facets.begin(), facets.end(), counts);
	if (first == facets.end()) return false;
	Vec3 shortest = first->normal;
	for (int round = 0; round < kWayOutRounds; ++round)
	{
		const double size = length(shortest);
		if (size < sine) return true;
		const Facet* worst = &*first;
		for (const Facet& facet : facets)
			if (counts(facet) && dot(facet.normal, shortest) < dot(worst->normal, shortest)) worst = &facet;
		if (dot(worst->normal, shortest) >= sine * size) return false;
		const Vec3 towards = worst->normal - shortest;
		shortest += std::clamp(-dot(shortest, towards) / lengthSquared(towards), 0.0, 1.0) * towards;
	}
	return false;
}
}  // namespace

bool isHeldBetween(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	return leaveNoWay(question, facets, kWayOut);
}

bool isJammedBetween(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	const double inner = kInnerShare * question.length();
	const auto isPressedIn = [&](const Facet& facet) { return facet.hasFeatures() && facet.distance < -inner; };
	const bool isAny = std::any_of(facets.begin(), facets.end(), isPressedIn);
	return leaveNoWay(question, facets, isAny ? kWayOutOfPress : kWayOut);
}

void FacetContacts::find(const ContactBody& a, const ContactBody& b, const Transform& aFromB, const PointRules& rules,
						 const std::vector<Contact>& contacts, const ClusterSet& previous, FacetMemory& memory,
						 bool goesOn, const JoinedBodies& joined)
{
	m_previous = &previous;
	m_memory = &memory;
	m_goesOn = goesOn;
	m_facets.clear();
	m_question = {a,
				  b,
				  aFromB,
				  aFromBAfter(rules.a, rules.b, aFromB, rules.timeStep),
				  aFromBAfter(withoutForces(rules.a), withoutForces(rules.b), aFromB, rules.timeStep),
				  rules};
	if (goesOn)
		takeUp();
	else if (!contacts.empty())
		takeUpWhatStays(contacts);
	m_finder.find(m_question, contacts, m_facets);
	if (!joined.isEmpty())
		m_facets.erase(std::remove_if(m_facets.begin(), m_facets.end(),
									  [&](const Facet& facet) { return isAtSeam(m_question, joined, facet); }),
					   m_facets.end());
	m_choice.choose(m_question, memory.reduced, memory.aFromB, m_facets, joined);
}

void FacetContacts::settle(const std::vector<Contact>& contacts, bool isDeep)
{
	m_expected = m_question.rules.motion();
	m_spare = std::numeric_limits<double>::infinity();
	m_missed = 0;
	answerDepth(contacts, isDeep);
	m_switch.apply(m_question, contacts, m_memory->reduced, *m_previous, m_goesOn, m_memory->levels, m_facets);
	dropWhatJams();
	if (m_facets.empty() && !m_memory->isDeep())
	{
		*m_memory = {};
		return;
	}
	m_solve.solve(m_question, m_facets);
	m_expected = m_solve.motion();
	m_missed = m_solve.missed();
	m_spare = std::min(m_solve.spare(), m_finder.sought());
}

// Takes up the facets that the solver got last, where they were.
void FacetContacts::takeUp()
{
	const PointRules& rules = m_question.rules;
	forEachReduced(*m_previous, m_memory->reduced,
				   [&](const HeldPoint& old, const FacetRecord& record)
				   {
					   if (!record.hasFeatures()) return;
					   const ContactPoint& point = old.point;
					   Facet facet{};
					   static_cast<FacetRecord&>(facet) = record;
					   facet.onA = facet.ofA = point.pointOnA + rules.radiusA * point.normal;
					   facet.onB = facet.ofB = point.pointOnB - rules.radiusB * point.normal;
					   facet.normal = point.normal;
					   facet.slowOverlap = point.slowOverlap;
					   m_facets.push_back(facet);
				   });
}

// Takes up the vertices that went in through a face: each stays a contact of that face until it is out, even if it is
// beyond by more than the body is thick there. And those that counted although aside of their face: once they are out of it
// nothing else would hold them where they are.
void FacetContacts::takeUpWhatStays(const std::vector<Contact>& contacts)
{
	const auto isAskedFor = [&](const FacetRecord& record)
	{
		const auto isOfLevels = [&](const Contact& contact)
		{
			return m_question.a.levelOf(contact.nodeA) == record.levelA && m_question.b.levelOf(contact.nodeB) == record.levelB;
		};
		return std::any_of(contacts.begin(), contacts.end(), isOfLevels);
	};
	forEachReduced(*m_previous, m_memory->reduced,
				   [&](const HeldPoint& old, const FacetRecord& record)
				   {
					   if (record.isThrough)
						   takeUpThrough(old.point, record);
					   else if (record.isAside && isAskedFor(record))
						   takeUpAside(record);
				   });
}

void FacetContacts::takeUpAside(const FacetRecord& record)
{
	const FacetQuestion& q = m_question;
	Facet facet{};
	static_cast<FacetRecord&>(facet) = record;
	placeAgain(q, facet);
	if (facet.distance > q.touching() || besideAt(q, facet, q.aFromB).distance > kDeepFootShare * q.length()) return;
	facet.setLinear(q.rules.motion());
	facet.then = facet.distance + facet.linear;
	facet.reach = facet.distance < -kInnerShare * q.length() ? Facet::Reach::kOverlap : Facet::Reach::kNear;
	m_facets.push_back(facet);
}

void FacetContacts::takeUpThrough(const ContactPoint& point, const FacetRecord& record)
{
	const FacetQuestion& q = m_question;
	Facet facet{};
	static_cast<FacetRecord&>(facet) = record;
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const bool isOfA = facet.vertexIsOfA();
	if (b.isSheet())
	{
		const Transform lastBFromA = inverse(m_memory->aFromB);
		if (isOfA)
			facet.featureB = b.polygonIn(lastBFromA.rotation * point.normal, lastBFromA * point.pointOnB, q.length());
		if (!isOfA || facet.featureB == kNone) return;
		facet.nodeB = b.sheetNodeOf(facet.featureB);
	}
	placeThrough(q, facet);
	const double touch = kInnerShare * q.length();
	const Vec3 place = isOfA ? inverse(q.aFromB) * facet.onA : facet.onB;
	const bool isOver = (isOfA ? b : a).isOver(facet.polygon(), place, touch);
	if (facet.distance < 0 && isOver) m_facets.push_back(facet);
}

// Where bodies overlap and no facet tells how deep, adds the contacts of a way out (DeepOverlap.h), which stays the
// same as long as it is needed.
void FacetContacts::answerDepth(const std::vector<Contact>& contacts, bool isDeep)
{
	Vec3& wayOut = m_memory->wayOut;
	if (m_question.b.only && m_question.b.only->isSheet())
	{
		bool& isMadeIn = m_memory->isMadeIn;
		if (isMadeIn || m_memory->reduced.empty() || SheetCrossing::isDeep(m_question, m_facets))
			isMadeIn = m_sheet.find(m_question, contacts, m_choice.shift(), isMadeIn, m_facets);
		return;
	}
	const bool overlap =
		isDeep || std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.upper <= 0; });
	const bool isOverlapping =
		std::any_of(m_facets.begin(), m_facets.end(), [](const Facet& f) { return f.distance < 0; });
	// Facets hold convex bodies from opposite sides only if the bodies have got through each other.
	const bool isAnswered = isOverlapping && !(DeepOverlap::areConvex(m_question) && holdBetween());
	if (!overlap || (isAnswered && wayOut == Vec3{}))
	{
		wayOut = {};
		return;
	}
	m_deepFacets.clear();
	wayOut = m_deep.find(m_question, contacts, isDeep, wayOut, normalized(impulseOf(*m_previous)), m_deepFacets);
	// Overlapping facets that oppose the way out would hold the bodies where they are.
	if (wayOut != Vec3{})
		m_facets.erase(std::remove_if(m_facets.begin(), m_facets.end(),
									  [&](const Facet& f) { return dot(f.normal, wayOut) < kAgainst; }),
					   m_facets.end());
	m_facets.insert(m_facets.end(), m_deepFacets.begin(), m_deepFacets.end());
}

// Points that go on from a level that jammed would hold the bodies as it did, against those of the finer one.
void FacetContacts::dropWhatJams()
{
	const auto isLeft = [this](const Facet& facet) { return m_switch.isOfLevelLeft(facet); };
	if (std::none_of(m_facets.begin(), m_facets.end(), isLeft) || !jamBetween()) return;
	m_facets.erase(std::remove_if(m_facets.begin(), m_facets.end(), isLeft), m_facets.end());
}

void FacetContacts::reduce(ClusterSet& next)
{
	m_points.clear();
	m_memory->reduced.clear();
	m_memory->aFromB = m_question.aFromB;
	for (const Facet& facet : m_facets) m_points.push_back(pointOf(facet));
	m_reducer.reduce(m_facets, m_points, *m_previous, m_question.rules, next);
	for (std::size_t i = 0; i < m_facets.size(); ++i)
		if (m_facets[i].reach == Facet::Reach::kPossible && !m_reducer.isChosen(i))
			m_spare = std::min(m_spare, m_facets[i].then - m_question.rules.margin);
	const Transform bFromA = inverse(m_question.aFromB);
	shrinkRoom(m_memory->reduced, m_reducer.count());
	m_memory->reduced.reserve(m_reducer.count());
	Vec3 through;
	for (std::size_t slot = 0; slot < next.slots.size(); ++slot)
		for (std::size_t i = 0; i < std::size_t(next.slots[slot].count); ++i)
		{
			const Facet& facet = m_facets[m_reducer.facetOf(slot, i)];
			if (facet.kind != Facet::Kind::kHeld) nameFaces(facet, bFromA, next.slots[slot].points[i].point);
			m_memory->reduced.push_back(facet);
			if (facet.isThrough) through += facet.normal;
		}
	m_memory->through = normalized(bFromA.rotation * through);
}

// Sets the triangles that a point lies on. Not for points that go on after a change of level, whose surface may be
// gone.
void FacetContacts::nameFaces(const Facet& facet, const Transform& bFromA, ContactPoint& point) const
{
	const ContactSurface &a = m_question.a.surface(facet.levelA), &b = m_question.b.surface(facet.levelB);
	const auto [ofA, ofB] = facet.parts();
	point.faceA = m_question.a.globalFace(facet.levelA, faceOf(a, ofA, facet.featureA, facet.nodeA, facet.onA));
	point.faceB =
		m_question.b.globalFace(facet.levelB, faceOf(b, ofB, facet.featureB, facet.nodeB, bFromA * facet.onB));
}

ContactPoint FacetContacts::pointOf(const Facet& facet) const
{
	ContactPoint point = facet.kind == Facet::Kind::kHeld ? m_switch.pointOf(facet) : ContactPoint{};
	point.pointOnA = facet.onA - m_question.rules.radiusA * facet.normal;
	point.pointOnB = facet.onB + m_question.rules.radiusB * facet.normal;
	point.normal = facet.normal;
	point.height = facet.distance - m_question.rules.margin;
	point.bend = facet.curvature();
	point.slowOverlap = facet.slowOverlap;
	if (facet.kind == Facet::Kind::kHeld) return point;
	point.feature = facet.feature;
	point.nodeA = facet.nodeA;
	point.nodeB = facet.nodeB;
	point.rebounds = !facet.isOfMiddle() && facet.reach < Facet::Reach::kPossible;
	return point;
}
}  // namespace clod
