// SPDX-License-Identifier: Zlib
#include "clod/manifold/SheetCrossing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
constexpr double kLeastDepth = 1e-3;     // of the length: less is the facets' business
constexpr double kAllButIn = 0.2;        // of the length: from the sheet to the middle
constexpr double kSameWay = 0.3;  // cosine
constexpr double kBeyondShift = 1.05;    // times the shift edges are looked for again
constexpr double kAsFar = 0.8;           // of the depth: from here on out on the wrong side is not meant
constexpr double kLeft = 0.05;           // of an overlap, what a shift may leave
constexpr std::size_t kMostEdges = 128;  // evenly, of more
}  // namespace

bool SheetCrossing::isDeep(const FacetQuestion& question, const std::vector<Facet>& facets)
{
	const double least = kLeastDepth * question.length();
	return std::any_of(facets.begin(), facets.end(), [&](const Facet& facet) { return facet.distance < -least; });
}

bool SheetCrossing::find(const FacetQuestion& question, const std::vector<Contact>& contacts, const Vec3& shift, bool was,
						 std::vector<Facet>& facets)
{
	const auto isThrough = [](const Facet& facet) { return facet.isThrough; };
	if (!was && std::any_of(facets.begin(), facets.end(), isThrough)) return false;  // by its motion
	m_question = &question;
	m_bFromA = inverse(question.aFromB);
	Vec3 way;
	for (const Facet& facet : facets)
		if (facet.isThrough) way += facet.normal;
	m_way = normalized(way);
	collect(contacts);
	const bool isOut = leadsOut(shift, facets);
	m_beyond.clear();
	const std::size_t stride = 1 + m_crossings.size() / kMostEdges;
	for (std::size_t i = 0; i < m_crossings.size(); i += stride)
	{
		Crossing& crossing = m_crossings[i];
		m_a = &question.a.surface(question.a.levelOf(crossing.nodeA));
		if (!findBeyond(crossing)) continue;
		const Facet facet = facetOf(crossing);
		const bool isWrong = !isOut || dot(shift, facet.normal) < kAsFar * facet.distance;
		if (!isWrong && !crossesAny(crossing.edge, m_bFromA.rotation * (kBeyondShift * shift))) continue;
		m_beyond.push_back(facet);
		if (m_way == Vec3{}) way += facet.normal;
	}
	way = normalized(way);
	const auto goesElsewhere = [&](const Facet& facet)
	{ return facet.reach == Facet::Reach::kOverlap && dot(facet.normal, way) < kAgainst; };
	// What is wedged in between is no one's.
	if (way == Vec3{} || std::any_of(m_beyond.begin(), m_beyond.end(), goesElsewhere)) return false;
	for (const Facet& facet : m_beyond) add(facet, facets);
	facets.erase(std::remove_if(facets.begin(), facets.end(), goesElsewhere), facets.end());
	return true;
}

// Out of all overlaps? Where some are against each other none does.
bool SheetCrossing::leadsOut(const Vec3& shift, const std::vector<Facet>& facets) const
{
	const double touch = kInnerShare * m_question->length();
	return std::all_of(facets.begin(), facets.end(), [&](const Facet& f)
					   { return dot(f.normal, shift) + f.distance > std::min(0.0, kLeft * f.distance) - touch; });
}

// Edges of accepted nodes that cross a triangle, each once.
void SheetCrossing::collect(const std::vector<Contact>& contacts)
{
	const FacetQuestion& q = *m_question;
	m_crossings.clear();
	for (const Contact& contact : contacts)
	{
		m_a = &q.a.surface(q.a.levelOf(contact.nodeA));
		const std::uint32_t face = q.b.only->firstFaceOf(contact.nodeB);
		for (const std::uint32_t e : m_a->edgesOf(contact.nodeA))
		{
			const auto& [from, to] = m_a->edges()[e].vertex;
			if (!crosses(m_bFromA * m_a->vertices()[from], m_bFromA * m_a->vertices()[to], face)) continue;
			m_crossings.push_back({contact.nodeA, e, kNone, kNone});
		}
	}
	std::stable_sort(m_crossings.begin(), m_crossings.end());
	m_crossings.erase(std::unique(m_crossings.begin(), m_crossings.end()), m_crossings.end());
}

bool SheetCrossing::crosses(const Vec3& from, const Vec3& to, std::uint32_t f) const
{
	const ContactSurface& b = *m_question->b.only;
	const SurfaceFace& face = b.faces()[f];
	const double least = kLeastDepth * m_question->length(), touch = kInnerShare * m_question->length();
	const double start = dot(face.normal, from) - face.offset, end = dot(face.normal, to) - face.offset;
	if (std::max(start, end) < least || std::min(start, end) > -least) return false;
	const Triangle corners{b.vertices()[face.vertex[0]], b.vertices()[face.vertex[1]], b.vertices()[face.vertex[2]]};
	return nearestOnTriangle(corners, from + start / (start - end) * (to - from)).squared <= touch * touch;
}

// Of a triangle's two the one that looks to where the body belongs.
std::uint32_t SheetCrossing::faceToSide(std::uint32_t f) const
{
	const SurfaceFace& face = m_question->b.only->faces()[f];
	const Vec3 normal = m_question->aFromB.rotation * face.normal;
	const double offset = face.offset + dot(normal, m_question->aFromB.translation);
	return sideOf(m_question->rules, normal, offset, m_way) < 0 ? f ^ 1u : f;
}

double SheetCrossing::sideOf(const PointRules& rules, const Vec3& normal, double offset, const Vec3& way)
{
	const double along = dot(normal, way), pull = dot(normal, normalized(rules.a.force - rules.b.force));
	if (std::abs(along) >= kSameWay) return along;
	const double height = dot(normal, rules.a.center) - offset;
	return std::abs(height) < kAllButIn * rules.length && std::abs(pull) >= kSameWay ? -pull : height;
}

bool SheetCrossing::crossesAny(std::uint32_t edge, const Vec3& shift) const
{
	const auto& [from, to] = m_a->edges()[edge].vertex;
	const Vec3 start = shift + m_bFromA * m_a->vertices()[from], end = shift + m_bFromA * m_a->vertices()[to];
	for (std::uint32_t f = 0; f < m_question->b.only->faces().size(); f += 2)
		if (crosses(start, end, f)) return true;
	return false;
}

// Which end is beyond? All triangles that the edge crosses have to agree: it may be out again.
bool SheetCrossing::findBeyond(Crossing& crossing) const
{
	const ContactSurface& b = *m_question->b.only;
	const SurfaceEdge& edge = m_a->edges()[crossing.edge];
	const Vec3 from = m_bFromA * m_a->vertices()[edge.vertex[0]], to = m_bFromA * m_a->vertices()[edge.vertex[1]];
	double nearest = std::numeric_limits<double>::infinity();
	for (std::uint32_t f = 0; f < b.faces().size(); f += 2)
	{
		if (!crosses(from, to, f)) continue;
		const std::uint32_t side = faceToSide(f);
		const auto heightOf = [&](const Vec3& point) { return dot(b.faces()[side].normal, point) - b.faces()[side].offset; };
		const double start = heightOf(from), end = heightOf(to), share = std::max(start, end) / std::abs(start - end);
		const std::uint32_t beyond = edge.vertex[start < 0 ? 0 : 1];
		if (crossing.beyond != kNone && crossing.beyond != beyond) return false;
		crossing.beyond = beyond;
		if (share >= nearest) continue;
		nearest = share;
		crossing.face = side;
	}
	return crossing.beyond != kNone;
}

// The one that a place is beneath, as far as beneath the face that was crossed; of a rough sheet it may be another.
std::uint32_t SheetCrossing::polygonOver(std::uint32_t f, const Vec3& place) const
{
	const ContactSurface& b = *m_question->b.only;
	const SurfaceFace& face = b.faces()[f];
	const double touch = kInnerShare * m_question->length(), depth = face.offset - dot(face.normal, place);
	if (b.isOver(face.polygon, place, touch)) return face.polygon;
	std::uint32_t best = face.polygon;
	double least = std::numeric_limits<double>::infinity();
	for (std::uint32_t p = 0; p < b.polygonCount(); ++p)
	{
		const SurfaceFace& plane = b.planeOf(p);
		const double there = plane.offset - dot(plane.normal, place);
		if (there <= 0 || std::abs(there - depth) >= least || dot(plane.normal, face.normal) < kSameWay) continue;
		if (!b.isOver(p, place, touch)) continue;
		least = std::abs(there - depth);
		best = p;
	}
	return best;
}

Facet SheetCrossing::facetOf(const Crossing& crossing) const
{
	const FacetQuestion& q = *m_question;
	const ContactSurface& b = *q.b.only;
	Facet facet{};
	facet.kind = Facet::Kind::kVertexFace;
	facet.reach = Facet::Reach::kOverlap;
	facet.isThrough = true;
	facet.nodeA = crossing.nodeA;
	facet.levelA = q.a.levelOf(crossing.nodeA);
	facet.featureA = m_a->lowestFrom(crossing.beyond, q.aFromB.rotation * b.faces()[crossing.face].normal);
	const Vec3& own = m_a->vertices()[facet.featureA];
	const Vec3 place = m_bFromA * own;
	facet.featureB = polygonOver(crossing.face, place);
	facet.nodeB = b.sheetNodeOf(facet.featureB);
	facet.levelB = 0;
	facet.feature = featureOf(*m_a, b, facet);
	const SurfaceFace& plane = b.planeOf(facet.featureB);
	facet.normal = q.aFromB.rotation * plane.normal;
	facet.distance = dot(plane.normal, place) - plane.offset;
	facet.span(own, true);
	facet.linear = dot(q.rules.motion().velocity(facet.onA), facet.normal) * q.rules.timeStep;
	facet.then = facet.distance + facet.linear;
	return facet;
}

void SheetCrossing::add(const Facet& facet, std::vector<Facet>& facets)
{
	const auto isSame = [&](const Facet& other) { return other.feature == facet.feature; };
	const auto known = std::find_if(facets.begin(), facets.end(), isSame);
	if (known == facets.end())
		facets.push_back(facet);
	else
		*known = facet;
}
}  // namespace clod
