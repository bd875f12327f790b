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
constexpr int kArcRounds = 6;    // of the search for where an arc meets the margin (regula falsi)
constexpr double kMostBend = 0.05;  // up to which an arc is known to stay near its chord: a third of a radian
constexpr double kArcSpeed = 2;  // the largest speed on an arc is at most this many times its mean speed
// Other contacts may lead a feature off its predicted way. Facets are looked for up to this share of the farthest
// displacement of the step around the middle of the way, the larger share where few pairs of nodes are near
// (kFewPairs); and never farther than kRoamGrains.
constexpr double kRoamShare = 0.35, kRoamOfFew = 0.8;

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
	const double turns = length(question.rules.a.turning()) + length(question.rules.b.turning());
	m_bend = 0.125 * kPathReach * std::max(turns, length(m_motion.angular)) * m_motion.timeStep;
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
	m_pairs.clear();
	m_borderApart = borderApart(contacts);
	for (const Contact& contact : contacts) m_pairs.push_back(pairOf(contact));
	if (m_nodesB.isOne()) m_nodesB.listNear(*m_pairs[0].movedB, placesNearA());
	for (const Pair& pair : m_pairs) findPair(pair);
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
bool FacetFinder::mayEnter(const ContactSurface& surface, const MovedCorner& vertex, const Vec3& up,
						   const SurfaceFace& face, bool faceIsOfB) const
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
	facet.levelA = m_pair.movedA->level;
	facet.levelB = m_pair.movedB->level;
	facet.nodeA = m_pair.movedA->node;
	facet.nodeB = m_pair.movedB->node;
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

// The distance at the end of the way looked ahead.
double FacetFinder::endOf(double now, double then) const
{
	return now + kPathReach * (then - now);
}

// Can features at this distance now and at the end of the step make a facet that Meeting::findReach() would accept?
bool FacetFinder::isInReach(double now, double then) const
{
	const PointRules& rules = m_question->rules;
	return now >= -m_pair.deepest && (now <= highest(now - then) || endOf(now, then) <= rules.margin ||
									  now <= rules.margin + rules.heldReach);
}

// Two features on their way through the step, seen in the frame in which one of them stands still: there the place of
// the other one (a vertex, or where an edge starts) and the direction of an edge change. `up`: the way their distance
// grows.
struct FacetFinder::Features
{
	double distance, distanceThen;
	Vec3 normal, up;  // of the facet, in frame A; and there
	Vec3 now, then, unforced;
	Vec3 direction{}, directionThen{};
	Vec3 met = now, metDirection = direction;  // where they were found to be over each other last
};

struct FacetFinder::VertexOverFace : Features
{
	const Vec3& own;  // in the frame of its body
	const ContactSurface& faces;
	std::uint32_t polygon;
	bool isOfA, isLowest, mayTouch;
	bool isOver(const Vec3& place, const Vec3&, double slack) const { return faces.isOver(polygon, place, slack); }
	Vec3 placeAt(const Transform& aFromB) const { return (isOfA ? inverse(aFromB) : aFromB) * own; }
	Vec3 directionAt(const Transform&) const { return {}; }
	double distanceAt(const Vec3& place, const Vec3&) const { return dot(up, place) - faces.planeOf(polygon).offset; }
	Vec3 placeInA() const { return isOfA ? own : now; }
	void placeWhatMeets(const Transform& aFromB, Facet& facet) const
	{
		const Vec3 foot = met - distanceAt(met, {}) * faces.planeOf(polygon).normal;
		facet.ofA = isOfA ? own : foot;
		facet.ofB = isOfA ? aFromB * foot : now;
	}
	Vec3 seen(const Vec3& wayOfB, const Transform& bFromA) const
	{
		return isOfA ? -(bFromA.rotation * wayOfB) : wayOfB;
	}
};

// A's edge stands still.
struct FacetFinder::EdgeOverEdge : Features
{
	const Vec3& start;  // of A's
	const SurfaceEdge &edge, &other;
	const Vec3& otherStart;  // in the frame of B
	bool isLowest, mayTouch;
	bool isOver(const Vec3& place, const Vec3& along, double slack) const
	{
		if (lengthSquared(cross(edge.direction, along)) < kParallelSine * kParallelSine) return false;
		const LinesCrossing at = crossingOf(start, edge.direction, place, along);
		return isWithin(at.alongA, edge.length, slack) && isWithin(at.alongB, other.length, slack);
	}
	Vec3 placeAt(const Transform& aFromB) const { return aFromB * otherStart; }
	Vec3 directionAt(const Transform& aFromB) const { return aFromB.rotation * other.direction; }
	double distanceAt(const Vec3& place, const Vec3& along) const
	{
		return distanceOfLines(start, edge.direction, place, along, normal);
	}
	// Where the edges meet.
	Vec3 placeInA() const
	{
		const double along = crossingOf(start, edge.direction, met, metDirection).alongA;
		return start + std::max(0.0, std::min(edge.length, along)) * edge.direction;
	}
	void placeWhatMeets(const Transform&, Facet& facet) const
	{
		const double along = crossingOf(start, edge.direction, met, metDirection).alongB;
		facet.ofB = now + std::max(0.0, std::min(other.length, along)) * direction;
	}
	Vec3 seen(const Vec3& wayOfB, const Transform&) const { return wayOfB; }
};

// Whether two features make a facet.
template <class Kind>
class FacetFinder::Meeting
{
public:
	Meeting(FacetFinder& finder, Kind& features)
		: m_finder(finder),
		  m_question(*finder.m_question),
		  m_rules(m_question.rules),
		  m_inner(kInnerShare * m_rules.length),
		  m_of(features)
	{
	}
	void addTo(Facet& facet, bool isPlacedOnA)
	{
		if (!findReach(facet.reach)) return;
		facet.distance = m_of.distance;
		facet.then = m_of.distanceThen;
		facet.normal = m_of.normal;
		facet.span(m_of.placeInA(), isPlacedOnA);
		m_of.placeWhatMeets(m_question.aFromB, facet);
		m_finder.add(facet);
	}

private:
	// Why the facet counts, the strongest reason first: its features are over each other now; they meet on the way of
	// the step, or of one body alone; or they are, at the middle of the step, within what other contacts may lead them.
	bool findReach(Facet::Reach& reach)
	{
		const double now = m_of.distance, end = m_finder.endOf(now, m_of.distanceThen);
		const double beside = m_finder.m_pair.roam + kFootShare * m_rules.length;
		const Vec3 middle = 0.5 * (m_of.now + m_of.then);
		if (now <= m_question.touching() && m_of.mayTouch &&
			m_of.isOver(m_of.now, m_of.direction, m_question.footSlack(now)))
			reach = now >= -m_inner ? Facet::Reach::kNear : Facet::Reach::kOverlap;
		else if (now > 0 && (end <= m_rules.margin ? end < now && meetOnPath(now - end) : meetIfHeld()))
			reach = Facet::Reach::kPath;
		else if (now > 0 && now <= m_finder.highest(now - m_of.distanceThen) &&
				 m_of.isOver(middle, m_of.direction, beside))
			reach = Facet::Reach::kPossible;
		else if ((now < -m_inner && m_of.mayTouch && isBesideOverlap()) || (m_of.isLowest && isBeside()))
			reach = Facet::Reach::kBeside;
		else
			return false;
		return true;
	}
	bool isBeside() const
	{
		const double beside = m_question.besideSlack(m_of.placeInA(), m_of.distance);
		return m_of.distance - beside <= m_rules.margin && m_of.isOver(m_of.now, m_of.direction, beside);
	}
	// Beneath one wall of a hollow corner bodies are beyond the border of the other.
	bool isBesideOverlap() const { return m_of.isOver(m_of.now, m_of.direction, kBesideMost * m_rules.length); }
	// On their way through the step, straight or, where the arc departs too far from its chord, on the arc.
	bool meetOnPath(double closing)
	{
		const Vec3 move = kPathReach * (along(m_of.up, m_of.unforced, m_of.then) - m_of.now);
		const Vec3 turn = kPathReach * (m_of.directionThen - m_of.direction);
		const Vec3 forced = kPathReach * dot(m_of.up, m_of.then - m_of.unforced) * m_of.up;
		const double bulge = m_finder.m_sagitta * length(move);
		if (bulge <= m_inner ? meetOn(move, turn, closing, bulge + m_inner) : meetOnArc(closing, length(move), forced))
			return true;
		if (forced == Vec3{}) return false;
		// With the forces in full. A facet that cannot hold the bodies against them (PointRules::holds) counts only if
		// it is met without them, too.
		const Vec3 toUnforced = kPathReach * (m_of.unforced - m_of.now);
		const double closingUnforced = -dot(m_of.up, toUnforced);
		return meetOn(kPathReach * (m_of.then - m_of.now), turn, closing, m_inner) &&
			   (m_rules.holds(m_of.normal) ||
				(closingUnforced > 0 && meetOn(toUnforced, turn, closingUnforced, m_inner)));
	}
	// On a straight way, where they come within the margin or where they cross.
	bool meetOn(const Vec3& move, const Vec3& turn, double closing, double slack)
	{
		const double enters = std::max(0.0, (m_of.distance - m_rules.margin) / closing);
		for (const double share : {enters, std::min(1.0, m_of.distance / closing)})
			if (meet(m_of.now + share * move, normalized(m_of.direction + share * turn), slack)) return true;
		return false;
	}
	// Follows the arc of turning bodies to where the features come within the margin, and asks whether they meet there.
	// forced: what forces displace by the end; way: how far the features go.
	bool meetOnArc(double closing, double way, const Vec3& forced)
	{
		const double wayOfHeight = kArcSpeed * way / closing;
		Vec3 place, direction;
		const auto heightAt = [&](double share)
		{
			const Transform pose = m_finder.poseAt(share);
			place = m_of.placeAt(pose) + share * forced;
			direction = m_of.directionAt(pose);
			return m_of.distanceAt(place, direction) - m_rules.margin;
		};
		const double enters = std::max(0.0, std::min(1.0, (m_of.distance - m_rules.margin) / closing));
		double share = std::round(kArcParts * enters) / kArcParts;
		double above = heightAt(share);
		// The way in lies between `from` and `to`, where the height is that much. An end that stays counts half.
		double from = 0, to = 1, aboveFrom = m_of.distance - m_rules.margin, aboveTo = aboveFrom - closing;
		if (!(aboveFrom > 0)) return std::abs(above) <= m_inner && meet(place, direction, m_inner);
		bool wasAbove = above <= 0;
		for (int round = 0; std::abs(above) > m_inner; ++round)
		{
			const double slack = m_inner + wayOfHeight * std::abs(above);
			if (round == kArcRounds || to <= from || !meet(place, direction, slack)) return false;
			const bool isAbove = above > 0;
			if (isAbove)
				from = share, aboveFrom = above, aboveTo *= wasAbove ? 0.5 : 1;
			else
				to = share, aboveTo = above, aboveFrom *= wasAbove ? 1 : 0.5;
			wasAbove = isAbove;
			share = from + (to - from) * aboveFrom / (aboveFrom - aboveTo);
			above = heightAt(share);
		}
		return meet(place, direction, m_inner);
	}
	// If a third body held one of the two bodies still, so that only the other moved.
	bool meetIfHeld()
	{
		const auto meetOnWayOf = [&](const PairBody& body, double sign)
		{
			Vec3 way = sign * m_rules.timeStep * body.velocityAt(m_of.placeInA());
			const double far = length(way);
			if (far > m_rules.heldReach) way = (m_rules.heldReach / far) * way;
			const double closing = dot(m_of.normal, way);
			return closing > 0 && m_of.distance - closing <= m_rules.margin &&
				   meetOn(m_of.seen(way, m_finder.m_bFromA), Vec3{}, closing, m_inner);
		};
		return m_rules.heldReach > 0 && (meetOnWayOf(m_rules.b, 1) || meetOnWayOf(m_rules.a, -1));
	}
	bool meet(const Vec3& place, const Vec3& direction, double slack)
	{
		if (!m_of.isOver(place, direction, slack)) return false;
		m_of.met = place;
		m_of.metDirection = direction;
		return true;
	}

	FacetFinder& m_finder;
	const FacetQuestion& m_question;
	const PointRules& m_rules;
	const double m_inner;
	Kind& m_of;
};

// How far beside a polygon the foot of a vertex may be now for any of the questions of Meeting to find it over the
// polygon. Most vertices are farther beside, which one distance tells in the place of four.
double FacetFinder::mostBeside(const MovedCorner& vertex, double now) const
{
	if (m_bend > kMostBend) return kFar;
	const Vec3 ahead = vertex.then - vertex.now, unforced = vertex.unforced - vertex.now;
	const double way = kPathReach * std::sqrt(std::max(lengthSquared(ahead), lengthSquared(unforced)));
	const FacetQuestion& q = *m_question;
	const double aside = 2 * kInnerShare * q.length() + m_pair.roam + q.rules.heldReach + (1 + 2 * m_bend) * way;
	return q.footSlack(now) + std::max(aside, kBesideMost * q.length());
}

// Works in the frame of the face's body.
void FacetFinder::vertexOverFace(const MovedCorner& vertex, const MovedPolygon& moved, bool vertexIsOfA)
{
	const std::uint32_t polygon = moved.index;
	const ContactSurface& faces = vertexIsOfA ? *m_pair.b : *m_pair.a;
	const ContactSurface& vertices = vertexIsOfA ? *m_pair.a : *m_pair.b;
	const SurfaceFace& face = faces.planeOf(polygon);
	const double now = dot(face.normal, vertex.now) - face.offset, then = dot(face.normal, vertex.then) - face.offset;
	if (!isInReach(now, then)) return;
	const Vec3& up = moved.up;
	if (!mayEnter(vertices, vertex, up, face, vertexIsOfA)) return;
	if (!faces.isOver(polygon, vertex.now, mostBeside(vertex, now))) return;
	// A vertex that has sunk in stays a contact although another is lower: turning may make it the lowest within the
	// step.
	const bool isLow = isLowest(vertices.fan(vertex.index), up, kArcSlack);
	const bool mayTouch = now < -kInnerShare * m_question->length() || (now <= m_question->touching() && isLow);
	const Features features{now, then, vertexIsOfA ? up : -face.normal, face.normal, vertex.now, vertex.then,
							vertex.unforced};
	Facet facet;
	facet.kind = vertexIsOfA ? Facet::Kind::kVertexFace : Facet::Kind::kFaceVertex;
	facet.featureA = vertexIsOfA ? vertex.index : polygon;
	facet.featureB = vertexIsOfA ? polygon : vertex.index;
	VertexOverFace both{features, vertices.vertices()[vertex.index], faces, polygon, vertexIsOfA, isLow, mayTouch};
	Meeting<VertexOverFace>(*this, both).addTo(facet, vertexIsOfA);
}

void FacetFinder::edgeOverEdge(const MovedEdge& still, const MovedEdge& moved)
{
	const ContactSurface &a = *m_pair.a, &b = *m_pair.b;
	const SurfaceEdge &edge = a.edges()[still.index], &other = b.edges()[moved.index];
	Vec3 normal = cross(edge.direction, moved.direction);
	if (dot(normal, edge.inward[0] + edge.inward[1] - moved.inward[0] - moved.inward[1]) < 0) normal = -normal;
	const double sineSquared = lengthSquared(normal), mostBeside = kArcSlack + m_turn;
	const auto isBeside = [&](double arc) { return arc < 0 && arc * arc > mostBeside * mostBeside * sineSquared; };
	const double arcOfA = std::min(dot(normal, edge.inward[0]), dot(normal, edge.inward[1]));
	if (isBeside(arcOfA)) return;
	const double arc = std::min(arcOfA, std::min(-dot(normal, moved.inward[0]), -dot(normal, moved.inward[1])));
	if (isBeside(arc)) return;
	if (sineSquared < kParallelSine * kParallelSine) return;
	const double sine = std::sqrt(sineSquared);
	normal = (1 / sine) * normal;

	const Vec3& start = a.vertices()[edge.vertex[0]];
	const double now = dot(normal, start - moved.start);
	const double then = distanceOfLines(start, edge.direction, moved.thenStart, moved.thenDirection, normal);
	if (!isInReach(now, then)) return;
	const Features features{now, then, normal, -normal, moved.start, moved.thenStart, moved.unforcedStart,
							moved.direction, moved.thenDirection};
	Facet facet;
	facet.kind = Facet::Kind::kEdgeEdge;
	facet.featureA = still.index;
	facet.featureB = moved.index;
	const bool isCrossed = arc / sine >= -kArcSlack;
	EdgeOverEdge both{features, start, edge, other, b.vertices()[other.vertex[0]], isCrossed, isCrossed};
	Meeting<EdgeOverEdge>(*this, both).addTo(facet, true);
}
}  // namespace clod
