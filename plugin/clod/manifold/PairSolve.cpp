// SPDX-License-Identifier: Zlib
#include "clod/manifold/PairSolve.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
constexpr int kPasses = 3;
constexpr int kSweeps = 12;
constexpr std::size_t kMostBalanced = 100;  // facets, which take up to 0.2 ms
constexpr double kSettled = 1e-6;  // of the length: the solve ends once rows change by less
constexpr double kMostTurn = 0.2;  // radians a step: beyond it, the second order says less and less of an arc

bool isOfRound(const Facet& facet)
{
	const auto [ofA, ofB] = facet.parts();
	return facet.hasFeatures() && ofA != Part::kPolygon && ofB != Part::kPolygon && facet.kind != Facet::Kind::kEdgeEdge;
}

// Bounds what the turning of the bodies adds to a facet's distance beyond the first order. Only the turning that they
// come with counts: rows that corrected for turning which other rows cause would drive each other.
class BendBound
{
public:
	explicit BendBound(const PointRules& rules)
		: m_rules(rules), m_motion(rules.motion()), m_turnA(turnOf(rules.a)), m_turnB(turnOf(rules.b))
	{
	}
	double of(const Facet& facet) const
	{
		if (!(m_turnA + m_turnB > 0)) return 0;
		const double moved = m_rules.timeStep * length(m_motion.velocity(facet.onA));
		const auto bent = [](double turn, const Vec3& arm) { return turn > 0 ? turn * turn * length(arm) : 0; };
		return (m_turnA + m_turnB) * moved +
			   0.5 * (bent(m_turnA, facet.onA - m_rules.a.center) + bent(m_turnB, facet.onB - m_rules.b.center));
	}
	// Of two edges more, if still they cross at the end of the step: the place where they do may have run all along the
	// shorter one, the farther the more they are parallel.
	double ofCrossing(const FacetQuestion& q, const Facet& facet) const
	{
		const double lengthA = q.a.surface(facet.levelA).edges()[facet.featureA].length,
					 lengthB = q.b.surface(facet.levelB).edges()[facet.featureB].length;
		return (m_turnA + m_turnB) * std::min(lengthA, lengthB);
	}

private:
	double turnOf(const PairBody& body) const
	{
		const double turn = m_rules.timeStep * length(body.turning());
		return turn <= kMostTurn ? turn : kMostTurn * kMostTurn / turn;
	}
	const PointRules& m_rules;
	const RelativeMotion m_motion;
	const double m_turnA, m_turnB;
};

// The least speed at which the bodies have to part at the facet.
double wantedSpeed(const PointRules& rules, const Facet& facet)
{
	const double height = facet.distance - rules.margin + facet.slowOverlap;
	return -velocityRow(height, facet.curvature()) / rules.timeStep;
}

// The distance of the same facet at another pose of the bodies.
double distanceAt(const FacetQuestion& question, const Facet& facet, const Transform& aFromB, const Transform& bFromA)
{
	const ContactSurface &a = question.a.surface(facet.levelA), &b = question.b.surface(facet.levelB);
	const Vec3 &centerA = question.rules.a.center, &centerB = question.rules.b.center;
	const auto above = [](const SurfaceFace& face, const Vec3& place) { return dot(face.normal, place) - face.offset; };
	switch (facet.kind)
	{
		case Facet::Kind::kVertexFace: return above(b.planeOf(facet.featureB), bFromA * a.vertices()[facet.featureA]);
		case Facet::Kind::kFaceVertex: return above(a.planeOf(facet.featureA), aFromB * b.vertices()[facet.featureB]);
		case Facet::Kind::kMiddleFace: return above(b.planeOf(facet.featureB), bFromA * centerA) - length(centerA - facet.onA);
		case Facet::Kind::kFaceMiddle:
			return above(a.planeOf(facet.featureA), aFromB * (inverse(question.aFromB) * centerB)) - length(centerB - facet.onB);
		default: break;
	}
	if (isOfRound(facet))
	{
		const Vec3 between = betweenAt(facet, a, b, aFromB);
		return std::copysign(length(between), dot(between, facet.normal));
	}
	const SurfaceEdge &e = a.edges()[facet.featureA], &k = b.edges()[facet.featureB];
	return distanceOfLines(a.vertices()[e.vertex[0]], e.direction, aFromB * b.vertices()[k.vertex[0]],
						   aFromB.rotation * k.direction, facet.normal);
}
}  // namespace

Beside besideAt(const FacetQuestion& q, const Facet& facet, const Transform& after)
{
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const auto [ofA, ofB] = facet.parts();
	const auto vertexOfA = [&] { return inverse(after) * a.vertices()[facet.featureA]; };
	const auto vertexOfB = [&] { return after * b.vertices()[facet.featureB]; };
	if (ofB == Part::kPolygon) return {std::sqrt(b.squaredBeside(facet.featureB, vertexOfA()))};
	if (ofA == Part::kPolygon) return {std::sqrt(a.squaredBeside(facet.featureA, vertexOfB()))};
	if (facet.kind == Facet::Kind::kVertexVertex) return {0};
	const auto beyond = [](const SurfaceEdge& edge, double along) { return std::max(-along, along - edge.length); };
	const auto besideEdge = [&](const ContactSurface& surface, std::uint32_t index, const Vec3& vertex) -> Beside
	{
		const SurfaceEdge& edge = surface.edges()[index];
		return {beyond(edge, dot(edge.direction, vertex - surface.vertices()[edge.vertex[0]]))};
	};
	if (ofA == Part::kVertex) return besideEdge(b, facet.featureB, vertexOfA());
	if (ofB == Part::kVertex) return besideEdge(a, facet.featureA, vertexOfB());
	const SurfaceEdge &e = a.edges()[facet.featureA], &k = b.edges()[facet.featureB];
	const Vec3 direction = after.rotation * k.direction;
	const double sine = length(cross(e.direction, direction));
	if (sine < kParallelSine) return {std::numeric_limits<double>::infinity(), 0};
	const LinesCrossing at =
		crossingOf(a.vertices()[e.vertex[0]], e.direction, after * b.vertices()[k.vertex[0]], direction);
	const double distance = std::max(beyond(e, at.alongA), beyond(k, at.alongB));
	return {distance, sine * distance};
}

// The speed at which the facet's features part.
double PairSolve::speedOf(const Row& row) const
{
	return dot(row.normal, m_a.linear - m_b.linear) + dot(row.turnA, m_a.angular) - dot(row.turnB, m_b.angular);
}

void PairSolve::push(const Row& row, double impulse)
{
	if (m_movesA)
	{
		m_a.linear += impulse * m_a.inverseMass * row.normal;
		m_a.angular += impulse * row.pushA;
	}
	if (m_movesB)
	{
		m_b.linear -= impulse * m_b.inverseMass * row.normal;
		m_b.angular -= impulse * row.pushB;
	}
}

void PairSolve::push(const Row& row, const Vec3& impulse)
{
	if (m_movesA)
	{
		m_a.linear += m_a.inverseMass * impulse;
		m_a.angular += m_a.inverseInertia * cross(row.armA, impulse);
	}
	if (m_movesB)
	{
		m_b.linear -= m_b.inverseMass * impulse;
		m_b.angular -= m_b.inverseInertia * cross(row.armB, impulse);
	}
}

// Adds friction against the sliding; its impulse is `most` at most.
void PairSolve::rub(const Row& row, double most, Vec3& friction)
{
	const Vec3 speed =
		m_a.linear + cross(m_a.angular, row.armA) - m_b.linear - cross(m_b.angular, row.armB);
	const Vec3 sliding = speed - dot(speed, row.normal) * row.normal, along = normalized(sliding);
	const auto turned = [&](const PairBody& body, const Vec3& arm)
	{
		const Vec3 turn = cross(arm, along);
		return dot(turn, body.inverseInertia * turn);
	};
	double inverseMass = m_a.inverseMass + m_b.inverseMass;
	if (m_movesA) inverseMass += turned(m_a, row.armA);
	if (m_movesB) inverseMass += turned(m_b, row.armB);
	Vec3 next = friction - (1 / inverseMass) * sliding;
	const double size = length(next);
	if (size > most) next = (most / size) * next;
	push(row, next - friction);
	friction = next;
}

void PairSolve::sweep(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	m_a = question.rules.a;
	m_b = question.rules.b;
	m_acting.clear();
	for (std::size_t i = 0; i < facets.size(); ++i)
	{
		if (facets[i].reach == Facet::Reach::kPossible) continue;
		m_acting.push_back(std::uint32_t(i));
		m_rows[i].wanted = wantedSpeed(question.rules, facets[i]);
		if (m_multipliers[i] == 0) continue;
		push(m_rows[i], m_multipliers[i]);
		push(m_rows[i], m_frictions[i]);
	}
	for (int round = 0; round < kSweeps; ++round)
	{
		double change = 0;
		for (const std::uint32_t i : m_acting)
		{
			const Row& row = m_rows[i];
			const double lacking = row.wanted - speedOf(row), old = m_multipliers[i];
			m_multipliers[i] = std::max(0.0, old + row.effectiveMass * lacking);
			const double impulse = m_multipliers[i] - old;
			if (impulse != 0)
			{
				change = std::max(change, std::abs(lacking));
				push(row, impulse);
			}
			if (question.rules.friction > 0 && (m_multipliers[i] > 0 || old > 0))
				rub(row, question.rules.friction * m_multipliers[i], m_frictions[i]);
		}
		if (change * question.rules.timeStep < kSettled * question.length()) break;
	}
	if (question.rules.liesAlone && facets.size() <= kMostBalanced) balance(question, facets);
}

// From what the sweeps have left, exactly: where a body that rolls or rocks ends is told by the balance of contacts that
// are close together.
void PairSolve::balance(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	const bool isA = m_a.inverseMass > 0;
	const double sign = isA ? 1 : -1;
	const PairBody& other = isA ? m_b : m_a;
	m_balance.start(isA ? question.rules.a : question.rules.b);
	for (const std::uint32_t i : m_acting)
	{
		const Facet& facet = facets[i];
		const Vec3& place = isA ? facet.onA : facet.onB;
		m_balance.add({place, sign * facet.normal, other.linear + cross(other.angular, place - other.center),
					   m_rows[i].wanted, question.rules.friction, m_multipliers[i],
					   sign * m_frictions[i]});
	}
	if (!m_balance.solve()) return;
	(isA ? m_a : m_b) = m_balance.body();
	std::size_t at = 0;
	for (const std::uint32_t i : m_acting)
	{
		const BodyBalance::Contact& found = m_balance.contact(at++);
		m_multipliers[i] = found.impulse;
		m_frictions[i] = sign * found.rub;
	}
}

void PairSolve::makeRows(const PointRules& rules, const std::vector<Facet>& facets)
{
	const auto isMoved = [](const PairBody& body)
	{ return body.inverseMass != 0 || !(body.inverseInertia == Mat3{{Vec3{}, Vec3{}, Vec3{}}}); };
	m_movesA = isMoved(rules.a);
	m_movesB = isMoved(rules.b);
	m_rows.clear();
	for (const Facet& facet : facets)
	{
		Row row;
		row.armA = facet.onA - rules.a.center;
		row.armB = facet.onB - rules.b.center;
		row.normal = facet.normal;
		row.turnA = cross(row.armA, facet.normal);
		row.turnB = cross(row.armB, facet.normal);
		row.pushA = rules.a.inverseInertia * row.turnA;
		row.pushB = rules.b.inverseInertia * row.turnB;
		row.effectiveMass = 1 / (rules.a.inverseMass + rules.b.inverseMass + dot(row.pushA, row.turnA) +
								 dot(row.pushB, row.turnB));
		m_rows.push_back(row);
	}
}

// Works out where the facets are at the end of the step as solved. Possible facets that this motion meets become
// contacts on the path. Returns the largest change of a row, as a length: what the next sweeps would begin with.
double PairSolve::moveOn(const FacetQuestion& question, std::vector<Facet>& facets)
{
	const PointRules& rules = question.rules;
	const auto aFromBBy = [&](double time) { return aFromBAfter(m_a, m_b, question.aFromB, time); };
	const auto unforcedBy = [&](double time)
	{ return aFromBAfter(withoutForces(m_a), withoutForces(m_b), question.aFromB, time); };
	m_after = aFromBBy(rules.timeStep);
	const Transform back = inverse(m_after), unforced = unforcedBy(rules.timeStep);
	const bool isTurned = std::any_of(m_multipliers.begin(), m_multipliers.end(), [](double m) { return m != 0; });
	const BendBound bound(rules);
	double change = 0;
	m_missed = 0;
	for (std::size_t i = 0; i < facets.size(); ++i)
	{
		Facet& facet = facets[i];
		const double curvature = facet.curvature();
		facet.linear = rules.timeStep * speedOf(m_rows[i]);
		facet.then = facet.distance + facet.linear;
		if (!facet.hasFeatures()) continue;
		facet.then = distanceAt(question, facet, m_after, back);
		// A normal turns no faster than the bodies do. Exceptions are that of two almost parallel edges, hence the
		// bound, and that of a round corner, which turns away as something goes by.
		double most = bound.of(facet);
		if (facet.kind == Facet::Kind::kEdgeEdge && std::abs(facet.curvature()) > most &&
			besideAt(question, facet, m_after).distance <= 0)
			most += bound.ofCrossing(question, facet);
		const double bent = std::max(-most, isOfRound(facet) ? facet.curvature() : std::min(most, facet.curvature()));
		const double end = facet.then;
		facet.then = facet.distance + facet.linear + bent;
		if (facet.reach != Facet::Reach::kPossible)
		{
			const double missed = std::min({facet.then, facet.distance, rules.margin}) - end;
			if (missed > m_missed && !facet.isOfMiddle() &&
				besideAt(question, facet, m_after).distance <= kInnerShare * question.length())
				m_missed = missed;
			change = std::max(change, std::abs(facet.curvature() - curvature));
			continue;
		}
		// Met where it comes within the margin, or at the end of the step. While no contact changes the motion nothing
		// needs to be asked: all that the predicted motion meets is known to be on the path.
		const double enters = std::max(0.0, facet.distance - rules.margin) / (facet.distance - facet.then) * rules.timeStep;
		const auto isMetAt = [&](const Transform& pose)
		{ return besideAt(question, facet, pose).distance <= kInnerShare * question.length(); };
		if (isTurned && facet.then < rules.margin && (isMetAt(aFromBBy(enters)) || isMetAt(m_after)) &&
			(rules.holds(facet.normal) || isMetAt(unforcedBy(enters)) || isMetAt(unforced)))
		{
			facet.reach = Facet::Reach::kPath;
			change = question.length();
		}
	}
	return change;
}

// Removes possible facets that the bodies pass beside. Kept are those that they stay above and are no farther beside
// than above: a third body may push them there. The planes of the others would deflect what flies past.
void PairSolve::removePassed(const FacetQuestion& question, std::vector<Facet>& facets)
{
	const auto isPassed = [&](const Facet& facet)
	{
		if (facet.reach != Facet::Reach::kPossible) return false;
		const Beside beside = besideAt(question, facet, m_after);
		const double above = std::min(facet.distance, facet.then) - question.rules.margin;
		if (above > 0 && beside.distance <= above) return false;
		m_spare = std::min(m_spare, std::max(above, beside.way));
		return true;
	};
	facets.erase(std::remove_if(facets.begin(), facets.end(), isPassed), facets.end());
}

void PairSolve::solve(const FacetQuestion& question, std::vector<Facet>& facets)
{
	const PointRules& rules = question.rules;
	m_a = rules.a;
	m_b = rules.b;
	m_timeStep = rules.timeStep;
	m_spare = std::numeric_limits<double>::infinity();
	m_missed = 0;
	if (!(rules.timeStep > 0 && (rules.a.inverseMass > 0 || rules.b.inverseMass > 0)))
	{
		const auto isPossible = [](const Facet& facet) { return facet.reach >= Facet::Reach::kPossible; };
		facets.erase(std::remove_if(facets.begin(), facets.end(), isPossible), facets.end());
		return;
	}
	if (facets.empty()) return;
	makeRows(rules, facets);
	m_multipliers.assign(facets.size(), 0);
	m_frictions.assign(facets.size(), Vec3{});
	for (int pass = 0; pass < kPasses; ++pass)
	{
		sweep(question, facets);
		if (moveOn(question, facets) < kSettled * question.length()) break;
	}
	for (std::size_t i = 0; i < facets.size(); ++i) facets[i].multiplier = m_multipliers[i];
	removePassed(question, facets);
}
}  // namespace clod
