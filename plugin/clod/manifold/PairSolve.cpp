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
constexpr double kSettled = 1e-6;  // of the length: what changes by less is not solved again
constexpr double kMostTurn = 0.2;  // radians a step: the farther beyond, the less the second order says of an arc

bool isOfRound(Facet::Kind kind)
{
	return kind == Facet::Kind::kVertexEdge || kind == Facet::Kind::kEdgeVertex || kind == Facet::Kind::kVertexVertex;
}

// The most that turning bodies add to a facet's distance beyond the first order, by the motion they come with: rows that
// ask for the arc of a turning that other rows made would drive each other.
double bendBound(const PointRules& rules, const Facet& facet)
{
	const double moved = rules.timeStep * length(rules.motion().velocity(facet.onA));
	const auto turnOf = [&](const PairBody& body)
	{
		const double turn = rules.timeStep * length(body.angular);
		return turn <= kMostTurn ? turn : kMostTurn * kMostTurn / turn;
	};
	const double turnA = turnOf(rules.a), turnB = turnOf(rules.b);
	return (turnA + turnB) * moved + 0.5 * (turnA * turnA * length(facet.onA - rules.a.center) +
											turnB * turnB * length(facet.onB - rules.b.center));
}
// Distance of the same facet at another pose.
double distanceAt(const FacetQuestion& question, const Facet& facet, const Transform& aFromB, const Transform& bFromA)
{
	const ContactSurface &a = question.a.surface(facet.levelA), &b = question.b.surface(facet.levelB);
	if (facet.kind == Facet::Kind::kVertexFace)
	{
		const SurfaceFace& face = b.planeOf(facet.featureB);
		return dot(face.normal, bFromA * a.vertices()[facet.featureA]) - face.offset;
	}
	if (facet.kind == Facet::Kind::kFaceVertex)
	{
		const SurfaceFace& face = a.planeOf(facet.featureA);
		return dot(face.normal, aFromB * b.vertices()[facet.featureB]) - face.offset;
	}
	if (facet.kind == Facet::Kind::kMiddleFace)
	{
		const SurfaceFace& face = b.planeOf(facet.featureB);
		return dot(face.normal, bFromA * question.rules.a.center) - face.offset - length(question.rules.a.center - facet.onA);
	}
	if (facet.kind == Facet::Kind::kFaceMiddle)
	{
		const SurfaceFace& face = a.planeOf(facet.featureA);
		return dot(face.normal, aFromB * (inverse(question.aFromB) * question.rules.b.center)) - face.offset -
			   length(question.rules.b.center - facet.onB);
	}
	if (isOfRound(facet.kind))
	{
		const Vec3 between = betweenAt(facet, a, b, aFromB);
		return std::copysign(length(between), dot(between, facet.normal));
	}
	const SurfaceEdge &e = a.edges()[facet.featureA], &k = b.edges()[facet.featureB];
	return distanceOfLines(a.vertices()[e.vertex[0]], e.direction, aFromB * b.vertices()[k.vertex[0]],
						   aFromB.rotation * k.direction, facet.normal);
}

}  // namespace

// At that pose: how far is what it is made of from being over each other?
PairSolve::Beside PairSolve::besideAt(const FacetQuestion& q, const Facet& facet, const Transform& after) const
{
	const Transform back = inverse(after);
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	if (facet.kind == Facet::Kind::kVertexFace)
		return {std::sqrt(b.squaredBeside(facet.featureB, back * a.vertices()[facet.featureA]))};
	if (facet.kind == Facet::Kind::kFaceVertex)
		return {std::sqrt(a.squaredBeside(facet.featureA, after * b.vertices()[facet.featureB]))};
	if (facet.kind == Facet::Kind::kVertexVertex) return {0};
	const auto beyond = [](const SurfaceEdge& edge, double along) { return std::max(-along, along - edge.length); };
	if (facet.kind == Facet::Kind::kVertexEdge)
	{
		const SurfaceEdge& k = b.edges()[facet.featureB];
		return {beyond(k, dot(k.direction, back * a.vertices()[facet.featureA] - b.vertices()[k.vertex[0]]))};
	}
	if (facet.kind == Facet::Kind::kEdgeVertex)
	{
		const SurfaceEdge& e = a.edges()[facet.featureA];
		return {beyond(e, dot(e.direction, after * b.vertices()[facet.featureB] - a.vertices()[e.vertex[0]]))};
	}
	const SurfaceEdge &e = a.edges()[facet.featureA], &k = b.edges()[facet.featureB];
	const Vec3 direction = after.rotation * k.direction;
	const double sine = length(cross(e.direction, direction));
	if (sine < kParallelSine) return {std::numeric_limits<double>::infinity(), 0};
	const LinesCrossing at =
		crossingOf(a.vertices()[e.vertex[0]], e.direction, after * b.vertices()[k.vertex[0]], direction);
	const double distance = std::max(beyond(e, at.alongA), beyond(k, at.alongB));
	return {distance, sine * distance};
}

void PairSolve::push(const Row& row, double impulse)
{
	m_a.linear += impulse * m_a.inverseMass * row.normal;
	m_a.angular += impulse * row.pushA;
	m_b.linear -= impulse * m_b.inverseMass * row.normal;
	m_b.angular -= impulse * row.pushB;
}

void PairSolve::push(const Facet& facet, const Vec3& impulse)
{
	m_a.linear += m_a.inverseMass * impulse;
	m_a.angular += m_a.inverseInertia * cross(facet.onA - m_a.center, impulse);
	m_b.linear -= m_b.inverseMass * impulse;
	m_b.angular -= m_b.inverseInertia * cross(facet.onB - m_b.center, impulse);
}

// Friction of at most so much, against the sliding.
void PairSolve::rub(const Facet& facet, double most, Vec3& friction)
{
	const Vec3 armA = facet.onA - m_a.center, armB = facet.onB - m_b.center;
	const Vec3 speed = m_a.linear + cross(m_a.angular, armA) - m_b.linear - cross(m_b.angular, armB);
	const Vec3 sliding = speed - dot(speed, facet.normal) * facet.normal, along = normalized(sliding);
	const Vec3 turnA = cross(armA, along), turnB = cross(armB, along);
	const double inverseMass = m_a.inverseMass + m_b.inverseMass + dot(turnA, m_a.inverseInertia * turnA) +
							   dot(turnB, m_b.inverseInertia * turnB);
	Vec3 next = friction - (1 / inverseMass) * sliding;
	const double size = length(next);
	if (size > most) next = (most / size) * next;
	push(facet, next - friction);
	friction = next;
}

void PairSolve::sweep(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	m_a = question.rules.a;
	m_b = question.rules.b;
	for (std::size_t i = 0; i < facets.size(); ++i)
	{
		const double multiplier = m_multipliers[i];
		if (multiplier == 0) continue;
		const Row& row = m_rows[i];
		push(row, multiplier);
		push(facets[i], m_frictions[i]);
	}
	for (int round = 0; round < kSweeps; ++round)
	{
		double change = 0;
		for (std::size_t i = 0; i < facets.size(); ++i)
		{
			if (facets[i].reach == Facet::Reach::kPossible) continue;
			const Row& row = m_rows[i];
			const double height = facets[i].distance - question.rules.margin + facets[i].slowOverlap;
			const double wanted = -velocityRow(height, facets[i].curvature()) / question.rules.timeStep;
			const double speed = dot(row.normal, m_a.linear - m_b.linear) + dot(row.turnA, m_a.angular) -
								 dot(row.turnB, m_b.angular);
			const double old = m_multipliers[i];
			m_multipliers[i] = std::max(0.0, old + row.effectiveMass * (wanted - speed));
			const double impulse = m_multipliers[i] - old;
			if (impulse != 0)
			{
				change = std::max(change, std::abs(wanted - speed));
				push(row, impulse);
			}
			if (question.rules.friction > 0 && (m_multipliers[i] > 0 || old > 0))
				rub(facets[i], question.rules.friction * m_multipliers[i], m_frictions[i]);
		}
		if (change * question.rules.timeStep < kSettled * question.length()) break;
	}
}

void PairSolve::solve(const FacetQuestion& question, std::vector<Facet>& facets)
{
	const auto removePossible = [&](const auto& isGivenUp)
	{
		facets.erase(std::remove_if(facets.begin(), facets.end(),
									[&](const Facet& f) { return f.reach == Facet::Reach::kPossible && isGivenUp(f); }),
					 facets.end());
	};
	const PointRules& rules = question.rules;
	const bool canMove = rules.timeStep > 0 && (rules.a.inverseMass > 0 || rules.b.inverseMass > 0);
	m_a = rules.a;
	m_b = rules.b;
	m_timeStep = rules.timeStep;
	m_spare = std::numeric_limits<double>::infinity();
	if (!canMove) removePossible([](const Facet&) { return true; });
	if (facets.empty() || !canMove) return;
	m_rows.clear();
	m_multipliers.assign(facets.size(), 0);
	m_frictions.assign(facets.size(), Vec3{});
	for (const Facet& facet : facets)
	{
		Row row;
		row.normal = facet.normal;
		row.turnA = cross(facet.onA - question.rules.a.center, facet.normal);
		row.turnB = cross(facet.onB - question.rules.b.center, facet.normal);
		row.pushA = question.rules.a.inverseInertia * row.turnA;
		row.pushB = question.rules.b.inverseInertia * row.turnB;
		row.effectiveMass = 1 / (question.rules.a.inverseMass + question.rules.b.inverseMass + dot(row.pushA, row.turnA) +
								 dot(row.pushB, row.turnB));
		m_rows.push_back(row);
	}
	Transform after;
	for (int pass = 0; pass < kPasses; ++pass)
	{
		sweep(question, facets);
		after = aFromBAfter(m_a, m_b, question.aFromB, rules.timeStep);
		const Transform back = inverse(after);
		const PairBody unforcedA = withoutForces(m_a), unforcedB = withoutForces(m_b);
		const Transform unforced = aFromBAfter(unforcedA, unforcedB, question.aFromB, rules.timeStep);
		const bool isTurned =
			std::any_of(m_multipliers.begin(), m_multipliers.end(), [](double multiplier) { return multiplier != 0; });
		double change = 0;  // of what the next sweeps would begin with
		for (std::size_t i = 0; i < facets.size(); ++i)
		{
			Facet& facet = facets[i];
			const Row& row = m_rows[i];
			const double curvature = facet.curvature();
			facet.linear = question.rules.timeStep * (dot(row.normal, m_a.linear - m_b.linear) + dot(row.turnA, m_a.angular) -
											  dot(row.turnB, m_b.angular));
			facet.then = facet.distance + facet.linear;
			if (!facet.hasFeatures()) continue;
			facet.then = distanceAt(question, facet, after, back);
			// A normal turns no faster than the bodies, but that of two edges all but parallel, and, away from what goes by, of a
			// round corner.
			const double most = bendBound(question.rules, facet);
			const double bent = std::max(-most, isOfRound(facet.kind) ? facet.curvature() : std::min(most, facet.curvature()));
			facet.then = facet.distance + facet.linear + bent;
			// Where it comes within the margin, or at the end. As long as nothing turns the motion, all that it meets is on the
			// path.
			const double enters = std::max(0.0, facet.distance - rules.margin) / (facet.distance - facet.then);
			const auto isMet = [&](const Transform& pose)
			{ return besideAt(question, facet, pose).distance <= kInnerShare * question.length(); };
			const auto isMetBy = [&](const PairBody& a, const PairBody& b, const Transform& end)
			{ return isMet(aFromBAfter(a, b, question.aFromB, enters * rules.timeStep)) || isMet(end); };
			if (isTurned && facet.reach == Facet::Reach::kPossible && facet.then < rules.margin &&
				isMetBy(m_a, m_b, after) && (rules.holds(facet.normal) || isMetBy(unforcedA, unforcedB, unforced)))
			{
				facet.reach = Facet::Reach::kPath;
				change = question.length();
			}
			if (facet.reach != Facet::Reach::kPossible)
				change = std::max(change, std::abs(facet.curvature() - curvature));
		}
		if (change < kSettled * question.length()) break;
	}
	for (std::size_t i = 0; i < facets.size(); ++i) facets[i].multiplier = m_multipliers[i];
	// A third body may push them onto those that they are no farther beside than above. The planes of others would deflect them.
	const auto isPassed = [&](const Facet& facet)
	{
		const Beside beside = besideAt(question, facet, after);
		const double above = std::min(facet.distance, facet.then) - rules.margin;
		if (above > 0 && beside.distance <= above) return false;
		m_spare = std::min(m_spare, std::max(above, beside.way));
		return true;
	};
	removePossible(isPassed);
}
}  // namespace clod
