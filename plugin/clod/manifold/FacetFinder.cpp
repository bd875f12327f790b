// SPDX-License-Identifier: Zlib
#include "clod/manifold/FacetFinder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr std::size_t kLeastTable = 64;
constexpr int kArcRounds = 6;    // of the search for where an arc meets the margin, each by the slope of the chord
constexpr double kMostSagitta = 0.05;  // up to which an arc is known to stay near its chord: a third of a radian
constexpr double kArcSpeed = 2;  // the largest speed on an arc is at most this many times its mean speed
// Other contacts may lead a feature off its predicted way. Facets are looked for up to this share of the farthest
// displacement of the step around the middle of the way, the larger share where few pairs of nodes are near
// (kFewPairs); and never farther than this many grains (mean edges) of the coarser surface.
constexpr double kRoamShare = 0.35, kRoamOfFew = 0.8, kRoamGrains = 1;

// Where a point ends, as a facet sees it: forces are counted along the normal only. Sideways another body may bear
// them, which is not known here, and a body that slides over the border of a face must not be seen to fall beneath that
// face.
Vec3 along(const Vec3& normal, const Vec3& unforced, const Vec3& then)
{
	return unforced + dot(normal, then - unforced) * normal;
}

bool isLowest(Span<Vec3> fan, const Vec3& up, double slack)
{
	for (const Vec3& d : fan)
		if (dot(d, up) < -slack) return false;
	return true;
}

bool isWithin(double along, double length, double slack)
{
	return along >= -slack && along <= length + slack;
}
}  // namespace

void FacetFinder::find(const FacetQuestion& question, const std::vector<Contact>& contacts, std::vector<Facet>& facets)
{
	m_question = &question;
	m_facets = &facets;
	m_bFromA = inverse(question.aFromB);
	m_nodesA.start(question, contacts, true);
	m_nodesB.start(question, contacts, false);
	m_motion = question.rules.motion();
	m_sagitta = 0.125 * kPathReach * length(m_motion.angular) * m_motion.timeStep;
	// What an impact of that speed may add to the turning, besides.
	const double speed = length(m_motion.velocity(question.rules.b.center));
	m_turn = (length(m_motion.angular) + speed / question.length()) * m_motion.timeStep;
	m_poses.fill({});
	placeMiddles();
	noteThrough();
	m_sought = kFar;
	m_roamShare = contacts.size() <= kFewPairs ? kRoamOfFew : kRoamShare;
	for (Facet& facet : facets) facet.setLinear(m_motion);
	std::size_t size = kLeastTable;
	while (size < 4 * (facets.size() + contacts.size())) size *= 2;
	tabulate(size);
	for (const Contact& contact : contacts) findPair(contact);
}

// Collects the planes that a vertex is known to have gone through.
void FacetFinder::noteThrough()
{
	m_through.clear();
	for (const Facet& facet : *m_facets)
	{
		if (!facet.isThrough) continue;
		const bool isOfB = facet.vertexIsOfA();
		const ContactSurface& surface =
			isOfB ? m_question->b.surface(facet.levelB) : m_question->a.surface(facet.levelA);
		if (!surface.isHalfSpace()) m_through.push_back({isOfB, surface.planeOf(facet.polygon())});
	}
}

// A vertex may enter through a face if it is the lowest of its neighbours. Where a body spans a thin wall its lowest
// corner may be beyond the wall already; any other corner may then enter through the face that this one went through.
bool FacetFinder::mayEnter(const ContactSurface& surface, const MovedCorner& vertex, const Vec3& up, const SurfaceFace& face,
						   bool faceIsOfB) const
{
	if (isLowest(surface.fan(vertex.index), up, kArcSlack + m_turn)) return true;
	const double near = kInnerShare * m_question->length();
	const auto isSame = [&](const Through& through)
	{
		return through.isOfB == faceIsOfB && dot(through.face.normal, face.normal) > kSameNormal &&
			   std::abs(through.face.offset - face.offset) < near;
	};
	return std::any_of(m_through.begin(), m_through.end(), isSame);
}

void FacetFinder::tabulate(std::size_t size)
{
	m_table.assign(size, kNone);
	for (std::uint32_t i = 0; i < m_facets->size(); ++i) m_table[slotOf((*m_facets)[i].feature)] = i;
}

// The place in the table of the facet made of these features, or the free one where it would be put.
std::size_t FacetFinder::slotOf(std::uint64_t feature) const
{
	for (std::size_t at = std::size_t(feature >> 32);; ++at)
	{
		at &= m_table.size() - 1;
		if (m_table[at] == kNone || (*m_facets)[m_table[at]].feature == feature) return at;
	}
}

// Several pairs of nodes may find the same facet: the one whose reach says most is kept.
void FacetFinder::add(Facet& facet)
{
	facet.levelA = m_pair.levelA;
	facet.levelB = m_pair.levelB;
	facet.nodeA = m_pair.nodeA;
	facet.nodeB = m_pair.nodeB;
	facet.setLinear(m_motion);
	facet.feature = featureOf(*m_pair.a, *m_pair.b, facet);
	const std::size_t slot = slotOf(facet.feature);
	if (m_table[slot] != kNone)
	{
		Facet& known = (*m_facets)[m_table[slot]];
		if (facet.reach < known.reach) known = facet;
		return;
	}
	m_table[slot] = std::uint32_t(m_facets->size());
	m_facets->push_back(facet);
	if (2 * m_facets->size() > m_table.size()) tabulate(2 * m_table.size());
}

void FacetFinder::findPair(const Contact& contact)
{
	const FacetQuestion& q = *m_question;
	MovedNode& nodeB = m_nodesB.of(contact.nodeB);
	const bool mayOverlap = contact.upper <= 0;
	const ContactSurface &a = q.a.surface(q.a.levelOf(contact.nodeA)), &b = q.b.surface(nodeB.level);
	const double most = m_roamShare * nodeB.displaced, roam = std::min(most, kRoamGrains * std::max(a.grain(), b.grain()));
	if (roam < most) m_sought = std::min(m_sought, roam);
	const double beside = kFootShare * q.length() + roam;
	double reach = q.touching() + q.rules.heldReach + beside;
	// The features of a facet are as far apart as its height and, at a right angle to it, as far as its foot is from both
	// features, when it is nearest. For a ball this straight distance leaves out most that boxes grown by the reach hold.
	const double aside = 2 * beside + std::max(0.0, 0.5 - m_roamShare) * nodeB.displaced;
	const double straight = !mayOverlap && b.isCore() ? std::sqrt(reach * reach + aside * aside) : kFar;
	if (mayOverlap) reach += q.a.thicknessOf(contact.nodeA) + q.b.thicknessOf(contact.nodeB);
	MovedNode& nodeA = m_nodesA.of(contact.nodeA, m_nodesB.isOne() ? Near(nodeB.box, reach, straight) : Near());
	m_pair = {&a, &b, contact.nodeA, contact.nodeB, nodeA.level, nodeB.level};
	m_pair.roam = roam;
	m_pair.deepest = mayOverlap ? kFar : kInnerShare * q.length();
	m_pair.reach = reach;
	gather(nodeA, nodeB);
	verticesOverFaces();
	edgesOverEdges(mayOverlap);
	if (m_middleA.height > 0)
		for (const std::uint32_t polygon : m_polygonsB) middleOverFace(m_middleA, polygon, true);
	if (m_middleB.height > 0)
		for (const std::uint32_t polygon : m_polygonsA) middleOverFace(m_middleB, polygon, false);
	if (q.isRound()) findRound();
}

void FacetFinder::verticesOverFaces()
{
	for (const MovedCorner* corner : m_cornersA)
		for (const std::uint32_t polygon : m_polygonsB) vertexOverFace(*corner, polygon, true);
	for (const MovedCorner* corner : m_cornersB)
		for (const std::uint32_t polygon : m_polygonsA) vertexOverFace(*corner, polygon, false);
}

// Where the hulls overlap, edges may have sunk past each other by any depth: no box leaves them out.
void FacetFinder::edgesOverEdges(bool mayOverlap)
{
	if (m_edgesA.empty()) return;
	for (MovedEdge* edgeB : m_edgesB)
	{
		m_nodesB.turn(*m_pair.b, *edgeB);
		for (const MovedEdge* edgeA : m_edgesA)
			if (mayOverlap || edgeA->box.meets(edgeB->box, m_pair.reach)) edgeOverEdge(*edgeA, *edgeB);
	}
}

// Lists the features of either node that come near the other node in the step.
void FacetFinder::gather(MovedNode& nodeA, MovedNode& nodeB)
{
	const auto gatherOf = [this](MovedNode& node, const Box& other, std::vector<const MovedCorner*>& corners,
								 std::vector<MovedEdge*>& edges, std::vector<std::uint32_t>& polygons)
	{
		const double reach = m_pair.reach;
		corners.clear();
		edges.clear();
		polygons.clear();
		for (MovedCorner& corner : node.corners)
		{
			if (!corner.box.meets(other, reach)) continue;
			if (!corner.isPlaced) m_nodesA.place(*m_pair.a, corner);
			corners.push_back(&corner);
		}
		for (MovedEdge& edge : node.edges)
			if (edge.box.meets(other, reach)) edges.push_back(&edge);
		for (const MovedPolygon& polygon : node.polygons)
			if (polygon.box.meets(other, reach)) polygons.push_back(polygon.index);
	};
	gatherOf(nodeA, nodeB.box, m_cornersA, m_edgesA, m_polygonsA);
	gatherOf(nodeB, nodeA.box, m_cornersB, m_edgesB, m_polygonsB);
}

// The largest distance from which other contacts may lead the features of a facet together, if the predicted motion
// brings them nearer by `closing`.
double FacetFinder::highest(double closing) const
{
	return m_question->touching() + m_pair.roam + (1 - m_roamShare) * closing;
}

// The pose of B in A after a share of the way looked ahead, without forces. The poses at multiples of 1 / kArcParts are
// computed once a dispatch.
Transform FacetFinder::poseAt(double share)
{
	const PointRules& rules = m_question->rules;
	const auto work = [&]
	{
		return aFromBAfter(withoutForces(rules.a), withoutForces(rules.b), m_question->aFromB,
						   kPathReach * share * rules.timeStep);
	};
	const double part = kArcParts * share;
	if (part != std::floor(part)) return work();
	std::optional<Transform>& pose = m_poses[std::size_t(part)];
	if (!pose) pose = work();
	return *pose;
}

// Follows the arc of turning bodies to where the features come within the margin, and asks whether they meet there.
// height(share, forced) places the features at a share of the way and returns their distance; meets(slack) tells
// whether they are then over each other up to the slack. forced: what forces displace by the end; way: how far the
// features go.
template <class Height, class Meets>
bool FacetFinder::meetsOnArc(double now, double closing, double way, const Vec3& forced, Height height, Meets meets) const
{
	const double near = kInnerShare * m_question->length(), margin = m_question->rules.margin;
	const double wayOfHeight = kArcSpeed * way / closing;
	const auto heightAt = [&](double share) { return height(share, share * forced) - margin; };
	double share = std::round(kArcParts * std::max(0.0, std::min(1.0, (now - margin) / closing))) / kArcParts;
	double above = heightAt(share);
	for (int round = 0; std::abs(above) > near; ++round)
	{
		const double next = std::max(0.0, std::min(1.0, share + above / closing));
		if (round == kArcRounds || next == share || !meets(near + wayOfHeight * std::abs(above))) return false;
		share = next;
		above = heightAt(share);
	}
	return meets(near);
}

// Do the features meet on their way through the step? meetsOn(move, closing, slack) answers for a straight chord; where
// the arc departs too far from its chord, height and meets answer for the arc (meetsOnArc). up: the direction in which
// the height grows; mayHold: this facet may hold the bodies against the forces on them (PointRules::holds).
template <class MeetsOn, class Height, class Meets>
bool FacetFinder::meetsOnPath(const Way& way, const Vec3& up, double now, double closing, bool mayHold,
							  MeetsOn meetsOn, Height height, Meets meets) const
{
	const double inner = kInnerShare * m_question->length();
	const Vec3 move = kPathReach * (along(up, way.unforced, way.then) - way.now);
	const Vec3 forced = kPathReach * dot(up, way.then - way.unforced) * up;
	const double bulge = m_sagitta * length(move);
	if (bulge <= inner ? meetsOn(move, closing, bulge + inner) : meetsOnArc(now, closing, length(move), forced, height, meets))
		return true;
	if (forced == Vec3{}) return false;
	// With the forces in full. A facet that cannot hold the bodies against them counts only if it is met without them,
	// too.
	const Vec3 toUnforced = kPathReach * (way.unforced - way.now);
	const double closingUnforced = -dot(up, toUnforced);
	return meetsOn(kPathReach * (way.then - way.now), closing, inner) &&
		   (mayHold || (closingUnforced > 0 && meetsOn(toUnforced, closingUnforced, inner)));
}

// Would the features meet if a third body held one of the two bodies still, so that only the other moved? place: where
// the features are, in frame A. meetsOn(way, closing) answers for a straight way of B, in frame A.
template <class MeetsOn>
bool FacetFinder::meetsIfHeld(const Vec3& place, const Vec3& normal, double now, MeetsOn meetsOn) const
{
	const PointRules& rules = m_question->rules;
	const auto meetsOnWayOf = [&](const PairBody& body, double sign)
	{
		Vec3 way = sign * rules.timeStep * (body.linear + cross(body.angular, place - body.center));
		const double far = length(way);
		if (far > rules.heldReach) way = (rules.heldReach / far) * way;
		const double closing = dot(normal, way);
		return closing > 0 && now - closing <= rules.margin && meetsOn(way, closing);
	};
	return rules.heldReach > 0 && (meetsOnWayOf(rules.b, 1) || meetsOnWayOf(rules.a, -1));
}

// The distance at the end of the way looked ahead.
double FacetFinder::endOf(double now, double then) const
{
	return now + kPathReach * (then - now);
}

// Can features at this distance now and at the end of the step make a facet that reachOf() would accept?
bool FacetFinder::isInReach(double now, double then) const
{
	const PointRules& rules = m_question->rules;
	return now >= -m_pair.deepest && (now <= highest(now - then) || endOf(now, then) <= rules.margin ||
									  now <= rules.margin + rules.heldReach);
}

// Why a facet counts, the strongest reason first: its features are over each other now; they meet on the way of the
// step, or of one body alone; or they are, at the middle of the step, within what other contacts may lead them.
// Nothing if it does not count.
template <class IsOver, class MeetsOnWay, class MeetsAlone, class IsPossible>
std::optional<Facet::Reach> FacetFinder::reachOf(double now, double then, IsOver isOver, MeetsOnWay meetsOnWay,
												 MeetsAlone meetsAlone, IsPossible isPossible) const
{
	const FacetQuestion& q = *m_question;
	const double end = endOf(now, then);
	if (now <= q.touching() && isOver())
		return now >= -kInnerShare * q.length() ? Facet::Reach::kNear : Facet::Reach::kOverlap;
	if (now <= 0) return {};
	if (end <= q.rules.margin ? end < now && meetsOnWay() : meetsAlone()) return Facet::Reach::kPath;
	if (now <= highest(now - then) && isPossible()) return Facet::Reach::kPossible;
	return {};
}

// How far beside a polygon the foot of a vertex may be now for any of the questions of reachOf() to find it over the
// polygon. Most vertices are farther beside, which one distance tells in the place of four.
double FacetFinder::mostBeside(const MovedCorner& vertex, double now) const
{
	if (m_sagitta > kMostSagitta) return kFar;
	const Vec3 ahead = vertex.then - vertex.now, unforced = vertex.unforced - vertex.now;
	const double way = kPathReach * std::sqrt(std::max(lengthSquared(ahead), lengthSquared(unforced)));
	const FacetQuestion& q = *m_question;
	return q.footSlack(now) + 2 * kInnerShare * q.length() + m_pair.roam + q.rules.heldReach + (1 + 2 * m_sagitta) * way;
}

// Works in the frame of the face's body.
void FacetFinder::vertexOverFace(const MovedCorner& vertex, std::uint32_t polygon, bool vertexIsOfA)
{
	const FacetQuestion& q = *m_question;
	const ContactSurface& faces = vertexIsOfA ? *m_pair.b : *m_pair.a;
	const ContactSurface& vertices = vertexIsOfA ? *m_pair.a : *m_pair.b;
	const SurfaceFace& face = faces.planeOf(polygon);
	const double now = dot(face.normal, vertex.now) - face.offset;
	const Vec3 normal = vertexIsOfA ? q.aFromB.rotation * face.normal : -face.normal;
	const double then = dot(face.normal, vertex.then) - face.offset;
	if (!isInReach(now, then)) return;

	const Vec3 up = vertexIsOfA ? normal : m_bFromA.rotation * face.normal;
	const double squaredBeside = faces.squaredBesideWithin(polygon, vertex.now, mostBeside(vertex, now));
	if (squaredBeside == kFar || !mayEnter(vertices, vertex, up, face, vertexIsOfA)) return;
	const Vec3& own = vertices.vertices()[vertex.index];
	// A vertex that has sunk in stays a contact although another is lower: turning may make it the lowest within the
	// step.
	const auto isOver = [&]
	{
		return (now < -kInnerShare * q.length() || isLowest(vertices.fan(vertex.index), up, kArcSlack)) &&
			   squaredBeside <= q.footSlack(now) * q.footSlack(now);
	};
	const auto meetsOn = [&](const Vec3& move, double closing, double slack)
	{
		const double enters = std::max(0.0, (now - q.rules.margin) / closing), crosses = std::min(1.0, now / closing);
		return faces.isOver(polygon, vertex.now + enters * move, slack) ||
			   faces.isOver(polygon, vertex.now + crosses * move, slack);
	};
	const auto meetsOnWay = [&]
	{
		Vec3 place;
		const auto height = [&](double share, const Vec3& forced)
		{
			const Transform pose = poseAt(share);
			place = (vertexIsOfA ? inverse(pose) * own : pose * own) + forced;
			return dot(face.normal, place) - face.offset;
		};
		return meetsOnPath({vertex.now, vertex.then, vertex.unforced}, face.normal, now, now - endOf(now, then),
						   q.rules.holds(normal), meetsOn, height,
						   [&](double slack) { return faces.isOver(polygon, place, slack); });
	};
	const auto meetsOnWayOfOne = [&](const Vec3& way, double closing)
	{ return meetsOn(vertexIsOfA ? -(m_bFromA.rotation * way) : way, closing, kInnerShare * q.length()); };
	const auto meetsAlone = [&] { return meetsIfHeld(vertexIsOfA ? own : vertex.now, normal, now, meetsOnWayOfOne); };
	const auto isPossible = [&]
	{ return faces.isOver(polygon, 0.5 * (vertex.now + vertex.then), m_pair.roam + kFootShare * q.length()); };
	const std::optional<Facet::Reach> reach = reachOf(now, then, isOver, meetsOnWay, meetsAlone, isPossible);
	if (!reach) return;
	Facet facet;
	facet.kind = vertexIsOfA ? Facet::Kind::kVertexFace : Facet::Kind::kFaceVertex;
	facet.reach = *reach;
	facet.featureA = vertexIsOfA ? vertex.index : polygon;
	facet.featureB = vertexIsOfA ? polygon : vertex.index;
	facet.distance = now;
	facet.then = then;
	facet.normal = normal;
	facet.span(vertexIsOfA ? own : vertex.now, vertexIsOfA);
	add(facet);
}

void FacetFinder::edgeOverEdge(const MovedEdge& still, const MovedEdge& moved)
{
	const FacetQuestion& q = *m_question;
	const SurfaceEdge& edge = m_pair.a->edges()[still.index];
	const SurfaceEdge& other = m_pair.b->edges()[moved.index];
	Vec3 normal = cross(edge.direction, moved.direction);
	if (dot(normal, edge.inward[0] + edge.inward[1] - moved.inward[0] - moved.inward[1]) < 0) normal = -normal;
	double arc = std::min(std::min(dot(normal, edge.inward[0]), dot(normal, edge.inward[1])),
						  std::min(-dot(normal, moved.inward[0]), -dot(normal, moved.inward[1])));
	const double sineSquared = lengthSquared(normal), mostBeside = kArcSlack + m_turn;
	if (arc < 0 && arc * arc > mostBeside * mostBeside * sineSquared) return;
	if (sineSquared < kParallelSine * kParallelSine) return;
	const double sine = std::sqrt(sineSquared);
	normal = (1 / sine) * normal;
	arc /= sine;

	const Vec3& start = m_pair.a->vertices()[edge.vertex[0]];
	const double now = dot(normal, start - moved.start);
	const double then = distanceOfLines(start, edge.direction, moved.thenStart, moved.thenDirection, normal);
	if (!isInReach(now, then)) return;

	LinesCrossing at = crossingOf(start, edge.direction, moved.start, moved.direction);
	const auto isOn = [&](const LinesCrossing& there, double slack)
	{ return isWithin(there.alongA, edge.length, slack) && isWithin(there.alongB, other.length, slack); };
	// Do the edges cross once B's edge has gone to that place and direction? If so, `at` is where.
	const auto crossesAt = [&](const Vec3& place, const Vec3& direction, double slack)
	{
		const double squared = lengthSquared(cross(edge.direction, direction));
		if (squared < kParallelSine * kParallelSine) return false;
		const LinesCrossing there = crossingOf(start, edge.direction, place, direction);
		if (!isOn(there, slack)) return false;
		at = there;
		return true;
	};
	const auto meetsOn = [&](const Vec3& move, const Vec3& turn, double closing, double slack)
	{
		for (const double share : {std::max(0.0, (now - q.rules.margin) / closing), std::min(1.0, now / closing)})
			if (crossesAt(moved.start + share * move, normalized(moved.direction + share * turn), slack)) return true;
		return false;
	};
	const auto isOver = [&] { return arc >= -kArcSlack && isOn(at, q.footSlack(now)); };
	const auto meetsOnWay = [&]
	{
		const Vec3 turn = kPathReach * (moved.thenDirection - moved.direction);
		Vec3 place, direction;
		const auto height = [&](double share, const Vec3& forced)
		{
			const Transform pose = poseAt(share);
			place = pose * m_pair.b->vertices()[other.vertex[0]] + forced;
			direction = pose.rotation * other.direction;
			return distanceOfLines(start, edge.direction, place, direction, normal);
		};
		const auto meetsTurning = [&](const Vec3& move, double closing, double slack)
		{ return meetsOn(move, turn, closing, slack); };
		return meetsOnPath({moved.start, moved.thenStart, moved.unforcedStart}, -normal, now, now - endOf(now, then),
						   q.rules.holds(normal), meetsTurning, height,
						   [&](double slack) { return crossesAt(place, direction, slack); });
	};
	const auto meetsOnWayOfOne = [&](const Vec3& way, double closing)
	{ return meetsOn(way, Vec3{}, closing, kInnerShare * q.length()); };
	const auto meetsAlone = [&]
	{
		const double along = std::max(0.0, std::min(edge.length, at.alongA));
		return meetsIfHeld(start + along * edge.direction, normal, now, meetsOnWayOfOne);
	};
	const auto isPossible = [&]
	{
		const Vec3 middle = 0.5 * (moved.start + moved.thenStart);
		return isOn(crossingOf(start, edge.direction, middle, moved.direction), m_pair.roam + kFootShare * q.length());
	};
	const std::optional<Facet::Reach> reach = reachOf(now, then, isOver, meetsOnWay, meetsAlone, isPossible);
	if (!reach) return;
	Facet facet;
	facet.reach = *reach;
	facet.kind = Facet::Kind::kEdgeEdge;
	facet.featureA = still.index;
	facet.featureB = moved.index;
	facet.normal = normal;
	facet.distance = now;
	facet.then = then;
	// The point is where the edges will meet on the way.
	at.alongA = std::max(0.0, std::min(edge.length, at.alongA));
	facet.span(start + at.alongA * edge.direction, true);
	add(facet);
}
}  // namespace clod
