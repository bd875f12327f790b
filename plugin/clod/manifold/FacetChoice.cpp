// SPDX-License-Identifier: Zlib
#include "clod/manifold/FacetChoice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "clod/manifold/PairSolve.h"

namespace clod
{
namespace
{
constexpr double kSatisfied = 0.02;       // of its depth: what a facet may lack and is satisfied
constexpr double kSatisfiedShare = 1e-6;  // of the length, likewise
constexpr double kSettledShare = 1e-9;    // of the length: a least shift is known to this
constexpr double kBeyond = 1.05;     // overlaps are looked for again at this many times the least shift, and a touch
constexpr double kTooDeep = 2;       // times as deep as may be: what a depth may grow by, as facets meet at angles
constexpr double kHardlyIn = 0.02;   // of the length: bodies that a farther shift takes apart are deep
constexpr double kAsShallow = 1e-3;  // of the length: overlaps that count as equally deep
constexpr double kInValley = 0.2;    // of the length: how far from a contact a facet may be
constexpr double kSamePlace = 2e-3;  // of the length: points that count as at one place

// A point deep inside the wedge of four half-spaces through two points: where the smallest distance to them is large.
Vec3 deepPoint(const Vec3 (&normal)[4], const double (&offset)[4], const Vec3& start, double size)
{
	Vec3 point = start, best = start;
	double step = 0.5 * size, least = std::numeric_limits<double>::infinity();
	for (int round = 0; round < 24; ++round, step *= 0.85)
	{
		const auto out = [&](int i) { return dot(normal[i], point) - offset[i]; };
		int worst = 0;
		for (int i = 1; i < 4; ++i)
			if (out(i) > out(worst)) worst = i;
		if (out(worst) < least)
		{
			least = out(worst);
			best = point;
		}
		point -= step * normal[worst];
	}
	return best;
}
}  // namespace

void FacetChoice::choose(const FacetQuestion& question, const std::vector<FacetRecord>& last, const Transform& lastAFromB,
						 std::vector<Facet>& facets, const JoinedBodies& joined)
{
	m_question = &question;
	dropTooDeep(last, lastAFromB, facets);
	passParallels(joined, facets);
	knowAgain(last, lastAFromB, facets);
	dropInner(facets);
	limitWaysOut(facets);
	dropRidges(facets);
	keepValleys(facets);
}

// Do the bodies overlap at the facet once A is moved by the shift?
bool FacetChoice::overlapsAt(const Facet& facet, const Vec3& shift) const
{
	const FacetQuestion& q = *m_question;
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const double inner = std::min(kInnerShare * q.length(), 0.5 * std::abs(facet.distance));
	const auto isInA = [&](const Vec3& place) { return a.isInside(place - shift); };
	const auto isInB = [&](const Vec3& place) { return b.isInside(inverse(q.aFromB) * place); };
	if (!b.isClosed() && !b.isHalfSpace())
	{
		// A sheet has no inside. It is crossed where the facet's point on it lies inside A, with some of A on either
		// side. A point that lies on A's surface belongs to the facet there; the walls around it, which would call it
		// as deep as A is wide, do not count.
		const double touch = kInnerShare * q.length();
		if (facet.kind != Facet::Kind::kVertexFace && facet.distance < -touch &&
			a.nearest(facet.onB - shift, touch).face != kNone)
			return false;
		const Vec3 off = std::min(2 * inner, 0.5 * std::abs(facet.distance)) * facet.normal;
		const auto isCrossedAt = [&](const Vec3& point) { return isInA(point - off) && isInA(point + off); };
		if (isCrossedAt(facet.onB)) return true;
		// Where a wall of A stands upright on the sheet the point lies on A's surface: look a little further in.
		return facet.kind == Facet::Kind::kVertexFace && isCrossedAt(facet.onB - inner * a.pseudonormal(facet.featureA));
	}
	// Just inside the corner.
	if (facet.kind == Facet::Kind::kVertexFace)
		return isInB(facet.onA + shift - inner * a.pseudonormal(facet.featureA));
	if (facet.kind == Facet::Kind::kFaceVertex)
		return isInA(facet.onB - inner * (q.aFromB.rotation * b.pseudonormal(facet.featureB)));
	// For two edges: a point deep inside the wedge that both bodies have in common there.
	const SurfaceEdge& edgeA = a.edges()[facet.featureA];
	const SurfaceEdge& edgeB = b.edges()[facet.featureB];
	const Vec3 normal[4] = {edgeA.normal[0], edgeA.normal[1], q.aFromB.rotation * edgeB.normal[0],
							q.aFromB.rotation * edgeB.normal[1]};
	const Vec3 onA = facet.onA + shift;
	const double offset[4] = {dot(normal[0], onA), dot(normal[1], onA), dot(normal[2], facet.onB),
							  dot(normal[3], facet.onB)};
	const Vec3 point = deepPoint(normal, offset, 0.5 * (onA + facet.onB), std::abs(facet.distance));
	return isInA(point) && isInB(point);
}

void FacetChoice::removeDropped(std::vector<Facet>& facets) const
{
	std::size_t kept = 0;
	for (std::uint32_t i = 0; i < facets.size(); ++i)
		if (m_isKept[i])
		{
			if (kept != i) facets[kept] = facets[i];
			++kept;
		}
	facets.resize(kept, Facet{});
}

// Nothing is deeper than the deepest of the last step and what bodies have gone since: the ends of a hole, beneath which
// a pin is by its length, are no way out where it has sunk into the wall. Of another level nothing is known.
void FacetChoice::dropTooDeep(const std::vector<FacetRecord>& last, const Transform& lastAFromB,
							  std::vector<Facet>& facets) const
{
	const auto isUnknown = [](const FacetRecord& record) { return !record.hasFeatures(); };
	if (std::any_of(last.begin(), last.end(), isUnknown)) return;
	double deepest = -kInnerShare * m_question->length();
	for (const FacetRecord& record : last) deepest = std::min(deepest, record.distance);
	const Transform lastAFromA = lastAFromB * inverse(m_question->aFromB);
	const auto isTooDeep = [&](const Facet& facet)
	{
		if (facet.isThrough || facet.distance >= kTooDeep * deepest) return false;
		const double gone = length(lastAFromA * facet.onB - facet.onB);
		if (facet.distance >= kTooDeep * (deepest - gone)) return false;
		const auto isOfLevels = [&](const FacetRecord& record)
		{ return record.levelA == facet.levelA && record.levelB == facet.levelB; };
		const auto isSame = [&](const FacetRecord& record) { return record.feature == facet.feature; };
		return std::any_of(last.begin(), last.end(), isOfLevels) && std::none_of(last.begin(), last.end(), isSame);
	};
	facets.erase(std::remove_if(facets.begin(), facets.end(), isTooDeep), facets.end());
}

void FacetChoice::knowAgain(const std::vector<FacetRecord>& last, const Transform& lastAFromB, std::vector<Facet>& facets)
{
	dropWhatHoldsThrough(facets);
	m_isKnown.assign(facets.size(), 0);
	const auto isOverlap = [](const Facet& facet) { return facet.reach == Facet::Reach::kOverlap; };
	if (std::none_of(facets.begin(), facets.end(), isOverlap)) return;
	for (std::uint32_t i = 0; i < facets.size() && !last.empty(); ++i)
	{
		Facet& facet = facets[i];
		if (!isOverlap(facet)) continue;
		const auto isSame = [&](const FacetRecord& record) { return record.hasFeatures() && record.feature == facet.feature; };
		const auto known = std::find_if(last.begin(), last.end(), isSame);
		facet.isThrough = facet.isThrough || wentThrough(facet, known == last.end() ? nullptr : &*known, last, lastAFromB);
		m_isKnown[i] = known != last.end() || facet.isThrough;
	}
}

// A vertex beneath the same face as one that is known to have gone through it, and joined to that one by an edge, came
// in the same way, though it was not the lowest then. Not for sheets, whose triangles have two sides, nor for half
// spaces, which nothing leaves on a far side.
void FacetChoice::followThrough(std::vector<Facet>& facets)
{
	const FacetQuestion& q = *m_question;
	const auto follows = [&](const Facet& facet, const Facet& through)
	{
		const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
		if (b.isSheet() || b.isHalfSpace()) return false;
		if (facet.kind != through.kind || facet.levelA != through.levelA || facet.levelB != through.levelB) return false;
		if (facet.polygon() != through.polygon()) return false;
		const ContactSurface& surface = facet.vertexIsOfA() ? a : b;
		const Span<std::uint32_t> edges = surface.edgesOf(facet.vertexIsOfA() ? facet.nodeA : facet.nodeB);
		const std::uint32_t v = facet.vertex(), w = through.vertex();
		const auto joins = [&](std::uint32_t e)
		{
			const auto& [from, to] = surface.edges()[e].vertex;
			return (from == v && to == w) || (from == w && to == v);
		};
		return std::any_of(edges.begin(), edges.end(), joins);
	};
	for (std::size_t i = 0; i < m_through.size(); ++i)
	{
		const Facet through = m_through[i];
		for (Facet& facet : facets)
		{
			if (facet.reach != Facet::Reach::kOverlap || facet.isThrough || !follows(facet, through)) continue;
			facet.isThrough = true;
			m_through.push_back(facet);
		}
	}
}

// A vertex that has gone through a face has to go back through it. Faces of the far side, which would push it on, are
// no contacts for it.
void FacetChoice::dropWhatHoldsThrough(std::vector<Facet>& facets)
{
	m_through.clear();
	for (const Facet& facet : facets)
		if (facet.isThrough) m_through.push_back(facet);
	if (m_through.empty()) return;
	followThrough(facets);
	const auto isHolding = [](const Facet& facet, const Facet& through)
	{
		const bool isSameVertex = facet.kind == through.kind && facet.vertex() == through.vertex();
		return isSameVertex && !facet.isThrough && dot(facet.normal, through.normal) < kAgainst;
	};
	const auto holdsAny = [&](const Facet& facet)
	{ return std::any_of(m_through.begin(), m_through.end(), [&](const Facet& f) { return isHolding(facet, f); }); };
	facets.erase(std::remove_if(facets.begin(), facets.end(), holdsAny), facets.end());
}

// Is the facet's vertex beneath the face because it came in through it, in the last step or earlier?
bool FacetChoice::wentThrough(const Facet& facet, const FacetRecord* known, const std::vector<FacetRecord>& last,
							  const Transform& lastAFromB) const
{
	const FacetQuestion& q = *m_question;
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	if (!facet.isOfVertex()) return false;
	const bool isOfA = facet.vertexIsOfA();
	const ContactSurface& faces = isOfA ? b : a;
	const Vec3& own = (isOfA ? a : b).vertices()[facet.vertex()];
	const auto placeBy = [&](const Transform& aFromB) { return isOfA ? inverse(aFromB) * own : aFromB * own; };
	const Vec3 now = placeBy(q.aFromB);
	const auto isOver = [&](const Vec3& point) { return faces.isOver(facet.polygon(), point, kInnerShare * q.length()); };
	if (!isOver(now)) return false;
	if (known && known->isThrough) return true;
	// The vertex had gone through another face: it is on its way back from beyond the far side, and this is not its
	// face.
	const auto isOfVertex = [&](const FacetRecord& record)
	{ return record.isThrough && record.kind == facet.kind && record.vertex() == facet.vertex(); };
	if (!(isOfA ? a : b).isSheet() && std::any_of(last.begin(), last.end(), isOfVertex)) return false;
	const Vec3 before = placeBy(lastAFromB);
	const SurfaceFace& face = faces.planeOf(facet.polygon());
	const double height = dot(face.normal, before) - face.offset;
	if (height < 0) return known && facet.distance < height;
	const double share = height / (height - facet.distance);
	return isOver(before + share * (now - before));
}

// Drops overlapping facets inside the difference. Those that were contacts in the last step are taken first, then the
// shallowest, of several as shallow the one that the motion leaves least beneath; each next one counts only if the
// bodies still overlap there once they are moved out of those before.
void FacetChoice::dropInner(std::vector<Facet>& facets)
{
	m_order.clear();
	m_beside.clear();
	m_isKept.assign(facets.size(), 1);
	for (std::uint32_t i = 0; i < facets.size(); ++i)
	{
		if (facets[i].reach == Facet::Reach::kBeside && facets[i].distance < -kInnerShare * m_question->length())
			m_beside.push_back(i);
		if (facets[i].reach != Facet::Reach::kOverlap) continue;
		m_isKept[i] = facets[i].isThrough || overlapsAt(facets[i], Vec3{}) ? 1 : 0;
		if (m_isKept[i]) m_order.push_back(i);
	}
	std::sort(m_beside.begin(), m_beside.end(), [&](std::uint32_t i, std::uint32_t j)
			  { return std::tie(facets[j].distance, i) < std::tie(facets[i].distance, j); });
	double shallowest = -std::numeric_limits<double>::infinity();  // of those that are new
	for (const std::uint32_t i : m_order)
		if (m_isKnown[i] == 0) shallowest = std::max(shallowest, facets[i].distance);
	const double tie = shallowest - kAsShallow * m_question->length();
	const auto placeOf = [&](std::uint32_t i)
	{
		const Facet& facet = facets[i];
		const bool isTied = m_isKnown[i] == 0 && facet.distance >= tie;
		return std::make_tuple(m_isKnown[i] == 0, !isTied, -facet.distance - (isTied ? facet.linear : 0), i);
	};
	std::sort(m_order.begin(), m_order.end(), [&](std::uint32_t i, std::uint32_t j) { return placeOf(i) < placeOf(j); });
	m_planes.clear();
	for (const Facet& facet : facets)
		if (facet.reach < Facet::Reach::kPossible && facet.reach != Facet::Reach::kOverlap && facet.distance < 0)
			m_planes.push_back({facet.normal, facet.distance});
	m_shift = m_planes.empty() || m_order.empty() ? Vec3{} : leastShift(m_planes, kSettledShare * m_question->length());
	for (const std::uint32_t i : m_order)
	{
		const Facet& facet = facets[i];
		if (isSatisfied(facet)) continue;
		// The overlap is looked for a little beyond the shift: a facet that lacks no more than that carries with the
		// others.
		const double touch = kInnerShare * m_question->length(), far = length(m_shift), beyond = (kBeyond - 1) * far + touch;
		if (!m_isKnown[i] && !m_planes.empty() && lacking(facet) > beyond + touch &&
			!overlapsAt(facet, (1 + (far > 0 ? beyond / far : 0)) * m_shift))
		{
			m_isKept[i] = 0;
			continue;
		}
		takeOut(facet);
		while (takeBeside(facets)) {}
	}
	for (bool isTaken = m_planes.empty(); isTaken;) isTaken = takeBeside(facets);
	removeDropped(facets);
}

// How far A is beneath the facet's plane once it is shifted.
double FacetChoice::lacking(const Facet& facet) const
{
	return -(dot(facet.normal, m_shift) + facet.distance);
}

bool FacetChoice::isSatisfied(const Facet& facet) const
{
	return lacking(facet) <= kSatisfied * -facet.distance + kSatisfiedShare * m_question->length();
}

void FacetChoice::takeOut(const Facet& facet)
{
	m_planes.push_back({facet.normal, facet.distance});
	m_shift = leastShift(m_planes, kSettledShare * m_question->length());
}

// Beneath one wall of a hollow corner a vertex is beyond the border of the other one: what is aside counts where the
// shift brings it over. Where two saddles are pressed into each other all edges may cross just beyond their ends: where nothing
// else overlaps the shallowest counts. False if there is none.
bool FacetChoice::takeBeside(std::vector<Facet>& facets)
{
	const FacetQuestion& q = *m_question;
	if (length(m_shift) > kHardlyIn * q.length()) return false;
	Transform shifted = q.aFromB;
	shifted.translation -= m_shift;
	for (const std::uint32_t i : m_beside)
	{
		Facet& facet = facets[i];
		if (facet.reach != Facet::Reach::kBeside || isSatisfied(facet)) continue;
		const bool isOver = m_planes.empty() || besideAt(q, facet, shifted).distance <= q.footSlack(-lacking(facet));
		if (!isOver || !overlapsAt(facet, m_shift)) continue;
		facet.reach = Facet::Reach::kOverlap;
		facet.isAside = m_planes.empty() && facet.isOfVertex() && !q.b.surface(facet.levelB).isSheet();
		takeOut(facet);
		return true;
	}
	return false;
}

// The centre of the facet, as part of the boundary of the Minkowski difference a - b at the present pose; frame A.
Vec3 FacetChoice::centerOf(const Facet& facet) const
{
	const FacetQuestion& q = *m_question;
	const ContactSurface &a = q.a.surface(facet.levelA), &b = q.b.surface(facet.levelB);
	const auto centerOfEdge = [](const ContactSurface& surface, std::uint32_t e)
	{
		const SurfaceEdge& edge = surface.edges()[e];
		return 0.5 * (surface.vertices()[edge.vertex[0]] + surface.vertices()[edge.vertex[1]]);
	};
	switch (facet.kind)
	{
		case Facet::Kind::kVertexFace: return facet.onA - q.aFromB * b.centerOf(facet.featureB);
		case Facet::Kind::kFaceVertex: return a.centerOf(facet.featureA) - facet.onB;
		case Facet::Kind::kEdgeEdge: return centerOfEdge(a, facet.featureA) - q.aFromB * centerOfEdge(b, facet.featureB);
		default: return facet.onA - facet.onB;
	}
}

void FacetChoice::Places::sort(const std::vector<Facet>& facets, const std::vector<std::uint32_t>& order,
							   Vec3 Facet::*point)
{
	sorted.clear();
	if (order.empty()) return;
	Box box{facets[order[0]].*point, facets[order[0]].*point};
	for (const std::uint32_t i : order) box.add(facets[i].*point);
	const Vec3 extent = box.high - box.low;
	axis = extent.x >= std::max(extent.y, extent.z) ? Vec3{1, 0, 0} : extent.y >= extent.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
	for (std::uint32_t k = 0; k < order.size(); ++k) sorted.emplace_back(dot(axis, facets[order[k]].*point), k);
	std::sort(sorted.begin(), sorted.end());
}

Span<std::pair<double, std::uint32_t>> FacetChoice::Places::near(const Vec3& point, double distance) const
{
	const double coordinate = dot(axis, point);
	const auto first = std::lower_bound(sorted.begin(), sorted.end(), std::make_pair(coordinate - distance, std::uint32_t(0)));
	const auto end = std::upper_bound(first, sorted.end(), std::make_pair(coordinate + distance, kNone));
	return {sorted.data() + (first - sorted.begin()), std::size_t(end - first)};
}

// Two facets at one place, each below the plane of the other, meet in a convex ridge of the difference. Is `other` on
// the far side of such a ridge from `best`, whose centre is given?
bool FacetChoice::isBeyondRidge(const Facet& best, const Vec3& center, const Facet& other) const
{
	const double size = m_question->length(), near = kSamePlace * size, tie = kTie * size, slack = 1e-6 * size;
	if (dot(best.normal, other.normal) > kSameNormal) return false;
	// One of the two may be met farther on the way.
	const double betweenA = lengthSquared(best.ofA - other.ofA), betweenB = lengthSquared(best.ofB - other.ofB);
	const double reach = near + std::max(std::abs(best.linear), std::abs(other.linear));
	if (std::min(betweenA, betweenB) > near * near || std::max(betweenA, betweenB) > reach * reach) return false;
	// Both hold where the motion ends over the ridge itself, as where an edge stands on a parallel edge.
	if (std::abs(best.distance - other.distance) < tie &&
		std::abs(best.distance + best.linear - other.distance - other.linear) < tie)
		return false;
	const Vec3 between = centerOf(other) - center;
	// Normals point into the difference, hence the signs.
	return dot(best.normal, between) > slack && dot(other.normal, between) < -slack;
}

// May the facet tell on which side of a ridge the bodies pass? One that is merely possible, where they touch, and the
// motion as predicted ends over it: a corner on its way round a ridge leaves the face that it was over. It then takes the
// place of what it drops.
bool FacetChoice::mayDecide(const Facet& facet) const
{
	const FacetQuestion& q = *m_question;
	if (facet.isOfMiddle() || facet.reach == Facet::Reach::kOverlap || facet.reach == Facet::Reach::kBeside) return false;
	return facet.reach != Facet::Reach::kPossible ||
		   (!q.isRound() && facet.distance <= q.touching() &&
			besideAt(q, facet, q.aFromBThen).distance <= kInnerShare * q.length());
}

void FacetChoice::dropRidges(std::vector<Facet>& facets)
{
	const double near = kSamePlace * m_question->length();
	m_isKept.assign(facets.size(), 1);
	m_order.clear();
	for (std::uint32_t i = 0; i < facets.size(); ++i)
		if (mayDecide(facets[i])) m_order.push_back(i);
	// The facet that the motion crosses last comes first; ties go by the order in which facets were found.
	std::sort(m_order.begin(), m_order.end(),
			  [&](std::uint32_t i, std::uint32_t j)
			  {
				  const double a = facets[i].distance + facets[i].linear, b = facets[j].distance + facets[j].linear;
				  return std::tie(b, i) < std::tie(a, j);
			  });
	m_placesA.sort(facets, m_order, &Facet::ofA);
	m_placesB.sort(facets, m_order, &Facet::ofB);
	for (std::uint32_t k = 0; k < m_order.size(); ++k)
	{
		const Facet& best = facets[m_order[k]];
		if (!m_isKept[m_order[k]]) continue;
		const Vec3 center = centerOf(best);
		const auto drop = [&](const Places& places, const Vec3& point)
		{
			for (const auto& [coordinate, place] : places.near(point, near))
			{
				const std::uint32_t other = m_order[place];
				if (place <= k || !m_isKept[other] || facets[other].reach == Facet::Reach::kPossible) continue;
				if (!isBeyondRidge(best, center, facets[other])) continue;
				m_isKept[other] = 0;
				if (best.reach == Facet::Reach::kPossible) facets[m_order[k]].reach = facets[other].reach;
			}
		};
		drop(m_placesA, best.ofA);
		drop(m_placesB, best.ofB);
	}
	removeDropped(facets);
}

// Two facets each of which lies above the plane of the other one meet in a valley of the difference. It leaves free what
// is above both planes: neither forbids anything, near the valley, that the other one allows, nor is deeper where that one
// is a contact.
bool FacetChoice::meetInValley(const Facet& contact, const Vec3& centerOfContact, const Facet& other, const Vec3& center) const
{
	const double size = m_question->length(), near = kInValley * size, slack = 1e-6 * size;
	if (!(dot(contact.normal, other.normal) > 0) || other.distance < std::min(contact.distance, 0.0)) return false;
	if (lengthSquared(contact.ofA - other.ofA) > near * near || lengthSquared(contact.ofB - other.ofB) > near * near) return false;
	const Vec3 between = center - centerOfContact;
	// Normals point into the difference, hence the signs.
	return dot(contact.normal, between) < -slack && dot(other.normal, between) > slack;
}

// Does the motion as predicted end beneath the facet's plane, but beside it?
bool FacetChoice::isPassed(const Facet& facet) const
{
	const FacetQuestion& q = *m_question;
	return facet.then < q.rules.margin && besideAt(q, facet, q.aFromBThen).distance > q.footSlack(facet.then);
}

// Facets aside, and merely possible ones, count where they meet a contact in a valley: the least motion leads from the
// one to the other within the step, as wherever saddles touch, or corners in hollows. Vertices whose way is clear pass.
// Of edges no way is known to be: joints hold the bodies by where they cross.
void FacetChoice::keepValleys(std::vector<Facet>& facets)
{
	const auto isOfSurfaces = [](const Facet& facet) { return facet.hasFeatures() && !facet.isOfMiddle(); };
	m_isKept.assign(facets.size(), 1);
	m_order.clear();
	m_centers.clear();
	for (std::uint32_t i = 0; i < facets.size(); ++i)
	{
		if (facets[i].reach >= Facet::Reach::kPossible || !isOfSurfaces(facets[i]) || facets[i].isThrough) continue;
		m_order.push_back(i);
		m_centers.push_back(centerOf(facets[i]));
	}
	m_placesA.sort(facets, m_order, &Facet::ofA);
	const double near = kInValley * m_question->length();
	for (std::uint32_t i = 0; i < facets.size(); ++i)
	{
		Facet& facet = facets[i];
		if (facet.reach < Facet::Reach::kPossible || !isOfSurfaces(facet)) continue;
		const Vec3 center = centerOf(facet);
		const auto holds = [&](const std::pair<double, std::uint32_t>& place)
		{ return meetInValley(facets[m_order[place.second]], m_centers[place.second], facet, center); };
		const auto contacts = m_placesA.near(facet.ofA, near);
		const bool counts = std::any_of(contacts.begin(), contacts.end(), holds) && !(facet.isOfVertex() && isPassed(facet));
		m_isKept[i] = counts || facet.reach == Facet::Reach::kPossible;
		if (counts) facet.reach = Facet::Reach::kBeside;
	}
	removeDropped(facets);
}
}  // namespace clod
