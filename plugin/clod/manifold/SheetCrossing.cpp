// SPDX-License-Identifier: Zlib
#include "clod/manifold/SheetCrossing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clod
{
namespace
{
constexpr double kLeastDepth = 1e-3;     // of the length: shallower overlaps are left to the facets
constexpr double kAllButIn = 0.2;        // of the length: a middle nearer to the sheet tells no side
constexpr double kSameWay = 0.3;         // cosine: directions that lie less far apart agree
constexpr double kBeyondShift = 1.05;    // edges are looked for again at so many times the shift out of what is known
constexpr double kAsFar = 0.8;           // of the depth: a polygon over a place has to be so far above it
constexpr double kLeft = 0.05;           // of an overlap: what a shift that leads out may leave
constexpr std::size_t kMostEdges = 128;  // of more edges that cross, these many are taken, evenly
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
	if (!was && std::any_of(facets.begin(), facets.end(), isThrough)) return false;  // it went in by its motion
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
		const Crossing& crossing = m_crossings[i];
		m_a = &question.a.surfaceOf(crossing.nodeA);
		const Facet facet = facetOf(crossing);
		bool counts = !isOut || dot(shift, facet.normal) < kAsFar * facet.distance;
		const auto crosses = [&](std::uint32_t, const Vec3&, const Vec3&) { counts = true; };
		if (!counts) forEachCrossed(crossing.edge, m_bFromA.rotation * (kBeyondShift * shift), crosses);
		if (!counts) continue;
		m_beyond.push_back(facet);
		if (m_way == Vec3{}) way += facet.normal;
	}
	way = normalized(way);
	const auto goesElsewhere = [&](const Facet& facet)
	{ return facet.reach == Facet::Reach::kOverlap && dot(facet.normal, way) < kAgainst; };
	// A body that is wedged in from several sides belongs to no side.
	if (way == Vec3{} || std::any_of(m_beyond.begin(), m_beyond.end(), goesElsewhere)) return false;
	for (const Facet& facet : m_beyond)
	{
		const auto isSame = [&](const Facet& other) { return other.feature == facet.feature; };
		const auto known = std::find_if(facets.begin(), facets.end(), isSame);
		known == facets.end() ? facets.push_back(facet) : void(*known = facet);
	}
	facets.erase(std::remove_if(facets.begin(), facets.end(), goesElsewhere), facets.end());
	return true;
}

// Does the shift lead out of all overlaps? No shift does where overlaps oppose each other.
bool SheetCrossing::leadsOut(const Vec3& shift, const std::vector<Facet>& facets) const
{
	const double touch = kInnerShare * m_question->length();
	return std::all_of(facets.begin(), facets.end(), [&](const Facet& f)
					   { return dot(f.normal, shift) + f.distance > std::min(0.0, kLeft * f.distance) - touch; });
}

// Collects the edges of accepted nodes that lead beyond, each once.
void SheetCrossing::collect(const std::vector<Contact>& contacts)
{
	m_crossings.clear();
	for (const Contact& contact : contacts)
		for (const std::uint32_t e : m_question->a.surfaceOf(contact.nodeA).edgesOf(contact.nodeA))
			m_crossings.push_back({contact.nodeA, e, kNone, kNone});
	std::stable_sort(m_crossings.begin(), m_crossings.end());
	m_crossings.erase(std::unique(m_crossings.begin(), m_crossings.end()), m_crossings.end());
	const auto leadsNowhere = [this](Crossing& crossing) { return !findBeyond(crossing); };
	m_crossings.erase(std::remove_if(m_crossings.begin(), m_crossings.end(), leadsNowhere), m_crossings.end());
}

// Calls each(face, start, end of the edge) for the front of every triangle that the edge crosses by more than a touch.
template <class Each>
void SheetCrossing::forEachCrossed(std::uint32_t edge, const Vec3& shift, Each each) const
{
	const ContactSurface& b = *m_question->b.only;
	const auto& [from, to] = m_a->edges()[edge].vertex;
	const Vec3 start = shift + m_bFromA * m_a->vertices()[from], end = shift + m_bFromA * m_a->vertices()[to];
	const double least = kLeastDepth * m_question->length();
	const auto eachDeep = [&](std::uint32_t f, double)
	{
		const SurfaceFace& face = b.faces()[f];
		const auto isDeep = [&](const Vec3& point) { return std::abs(dot(face.normal, point) - face.offset) >= least; };
		if (f % 2 == 0 && isDeep(start) && isDeep(end)) each(f, start, end);
	};
	b.forEachCrossed(start, end, kInnerShare * m_question->length(), eachDeep);
}

double SheetCrossing::sideOf(const PointRules& rules, const Vec3& normal, double offset, const Vec3& way)
{
	const double along = dot(normal, way), pull = dot(normal, normalized(rules.a.force - rules.b.force));
	if (std::abs(along) >= kSameWay) return along;
	const double height = dot(normal, rules.a.center) - offset;
	return std::abs(height) < kAllButIn * rules.length && std::abs(pull) >= kSameWay ? -pull : height;
}

// Which end of the edge is beyond the sheet? All triangles that it crosses have to agree, as it may have come out
// again.
bool SheetCrossing::findBeyond(Crossing& crossing)
{
	m_a = &m_question->a.surfaceOf(crossing.nodeA);
	double nearest = std::numeric_limits<double>::infinity();
	bool agree = true;
	const auto look = [&](std::uint32_t f, const Vec3& from, const Vec3& to)
	{
		// Of a triangle's two faces, back to back, the one that looks to the side where the body belongs.
		const SurfaceFace& front = m_question->b.only->faces()[f];
		const Vec3 normal = m_question->aFromB.rotation * front.normal;
		const double offset = front.offset + dot(normal, m_question->aFromB.translation);
		const std::uint32_t side = sideOf(m_question->rules, normal, offset, m_way) < 0 ? f ^ 1u : f;
		const SurfaceFace& face = m_question->b.only->faces()[side];
		const double start = dot(face.normal, from) - face.offset, end = dot(face.normal, to) - face.offset;
		const double share = std::max(start, end) / std::abs(start - end);
		const std::uint32_t beyond = m_a->edges()[crossing.edge].vertex[start < 0 ? 0 : 1];
		agree = agree && (crossing.beyond == kNone || crossing.beyond == beyond);
		crossing.beyond = beyond;
		if (share > nearest || (share == nearest && side > crossing.face)) return;
		nearest = share;
		crossing.face = side;
	};
	forEachCrossed(crossing.edge, Vec3{}, look);
	return agree && crossing.beyond != kNone;
}

// The polygon that a place is beneath. On a rough sheet it may be another than the one that was crossed, but the place
// has to be about as far beneath it.
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
	facet.nodeA = crossing.nodeA;
	facet.levelA = q.a.levelOf(crossing.nodeA);
	facet.featureA = m_a->lowestFrom(crossing.beyond, q.aFromB.rotation * b.faces()[crossing.face].normal);
	facet.featureB = polygonOver(crossing.face, m_bFromA * m_a->vertices()[facet.featureA]);
	facet.nodeB = b.sheetNodeOf(facet.featureB);
	placeThrough(q, facet);
	facet.then = facet.distance;
	return facet;
}
}  // namespace clod
