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
const Vec3 kNowhereLow{kFar, kFar, kFar}, kNowhereHigh{-kFar, -kFar, -kFar};

constexpr std::size_t kLeastTable = 256;

void grow(Vec3& low, Vec3& high, const Vec3& p)
{
	for (int k = 0; k < 3; ++k)
	{
		low[k] = std::min(low[k], p[k]);
		high[k] = std::max(high[k], p[k]);
	}
}

bool meet(const Vec3& lowA, const Vec3& highA, const Vec3& lowB, const Vec3& highB, double reach)
{
	return lowA.x <= highB.x + reach && lowB.x <= highA.x + reach && lowA.y <= highB.y + reach &&
		   lowB.y <= highA.y + reach && lowA.z <= highB.z + reach && lowB.z <= highA.z + reach;
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
	m_bFromAThen = inverse(question.aFromBThen);
	m_motion = question.rules.motion();
	m_turn = length(m_motion.angular) * m_motion.timeStep;
	m_table.assign(std::max<std::size_t>(m_table.size(), kLeastTable), kNone);
	for (const Contact& contact : contacts) findPair(contact);
}

// Where the facet of the same features is, or would be, in the table.
std::size_t FacetFinder::slotOf(const Facet& facet) const
{
	const std::uint64_t features = std::uint64_t(facet.featureA) << 32 | facet.featureB;
	const std::uint64_t rest = std::uint64_t(facet.kind) << 32 | facet.levelA << 16 | facet.levelB;
	std::size_t at = std::size_t(((features ^ rest * 0xD6E8FEB86659FD93u) * 0x9E3779B97F4A7C15u) >> 32);
	for (;; ++at)
	{
		at &= m_table.size() - 1;
		if (m_table[at] == kNone) return at;
		const Facet& other = (*m_facets)[m_table[at]];
		if (other.featureA == facet.featureA && other.featureB == facet.featureB && other.kind == facet.kind &&
			other.levelA == facet.levelA && other.levelB == facet.levelB)
			return at;
	}
}

// Several faces of one polygon may find the same facet, and several pairs of nodes: it is what the nearest of them says.
void FacetFinder::add(Facet& facet)
{
	facet.levelA = m_pair.levelA;
	facet.levelB = m_pair.levelB;
	facet.nodeA = m_pair.nodeA;
	facet.nodeB = m_pair.nodeB;
	facet.linear = dot(m_motion.velocity(facet.onA), facet.normal) * m_motion.timeStep;
	const std::size_t slot = slotOf(facet);
	if (m_table[slot] != kNone)
	{
		Facet& known = (*m_facets)[m_table[slot]];
		if (facet.reach < known.reach) known = facet;
		return;
	}
	m_table[slot] = std::uint32_t(m_facets->size());
	m_facets->push_back(facet);
	if (2 * m_facets->size() <= m_table.size()) return;
	m_table.assign(2 * m_table.size(), kNone);
	for (std::uint32_t i = 0; i < m_facets->size(); ++i) m_table[slotOf((*m_facets)[i])] = i;
}

void FacetFinder::findPair(const Contact& contact)
{
	const FacetQuestion& q = *m_question;
	const std::uint32_t levelA = q.a.levelOf(contact.nodeA), levelB = q.b.levelOf(contact.nodeB);
	const bool mayOverlap = contact.upper <= 0;
	m_pair = {&q.a.surface(levelA), &q.b.surface(levelB), contact.nodeA, contact.nodeB, levelA, levelB, 0,
			  mayOverlap ? kFar : 2 * kInnerShare * q.length(), mayOverlap ? q.a.thicknessOf(contact.nodeA) + q.b.thicknessOf(contact.nodeB) : 0};
	gather(contact);
	verticesOverFaces(true);
	verticesOverFaces(false);
	edgesOverEdges();
}

// What of either node comes near the other in the step: by boxes, and by what lies between the hulls.
void FacetFinder::gather(const Contact& contact)
{
	const ContactSurface &a = *m_pair.a, &b = *m_pair.b;
	const FacetQuestion& q = *m_question;
	Vec3 lowA = kNowhereLow, highA = kNowhereHigh, lowB = kNowhereLow, highB = kNowhereHigh;
	const std::uint32_t firstA = a.firstFaceOf(m_pair.nodeA), lastA = firstA + a.faceCountOf(m_pair.nodeA);
	for (std::uint32_t f = firstA; f < lastA; ++f)
		for (const std::uint32_t v : a.faces()[f].vertex) grow(lowA, highA, a.vertices()[v]);
	const std::uint32_t firstB = b.firstFaceOf(m_pair.nodeB), lastB = firstB + b.faceCountOf(m_pair.nodeB);
	m_facesB.clear();
	double displaced = 0;
	for (std::uint32_t f = firstB; f < lastB; ++f)
		for (const std::uint32_t v : b.faces()[f].vertex)
			displaced = std::max(displaced, lengthSquared(q.aFromBThen * b.vertices()[v] - q.aFromB * b.vertices()[v]));
	m_pair.roam = 0.5 * std::sqrt(displaced);
	const double reach = q.touching() + kFootShare * q.length() + m_pair.beneath + m_pair.roam;
	// Between hulls that are apart what is far from the other along the way between them is far from it.
	const bool isApart = contact.lower > 0 && contact.normal != Vec3{};
	const double along = kPathReach * 2 * m_pair.roam + reach;
	const double highestA = dot(contact.normal, contact.pointOnB) + along,
				 lowestB = dot(contact.normal, contact.pointOnA) - along;
	const auto isFarA = [&](const Vec3& p) { return isApart && dot(contact.normal, p) > highestA; };
	const auto isFarB = [&](const Vec3& now) { return isApart && dot(contact.normal, now) < lowestB; };
	for (std::uint32_t f = firstB; f < lastB; ++f)
	{
		Vec3 low = kNowhereLow, high = kNowhereHigh;
		bool isFar = true;
		for (const std::uint32_t v : b.faces()[f].vertex)
		{
			const Vec3 &p = b.vertices()[v], now = q.aFromB * p;
			isFar = isFar && isFarB(now);
			grow(low, high, now);
			grow(low, high, now + kPathReach * (q.aFromBThen * p - now));
		}
		if (isFar) continue;
		grow(lowB, highB, low);
		grow(lowB, highB, high);
		if (meet(low, high, lowA, highA, reach)) m_facesB.push_back(f);
	}
	m_facesA.clear();
	m_verticesA.clear();
	m_verticesB.clear();
	m_edgesA.clear();
	m_edgesB.clear();
	if (m_facesB.empty()) return;
	for (std::uint32_t f = firstA; f < lastA; ++f)
	{
		Vec3 low = kNowhereLow, high = kNowhereHigh;
		bool isFar = true;
		for (const std::uint32_t v : a.faces()[f].vertex)
		{
			grow(low, high, a.vertices()[v]);
			isFar = isFar && isFarA(a.vertices()[v]);
		}
		if (!isFar && meet(low, high, lowB, highB, reach)) m_facesA.push_back(f);
	}
	for (const std::uint32_t v : a.verticesOf(m_pair.nodeA))
	{
		const Vec3& p = a.vertices()[v];
		if (!isFarA(p) && meet(p, p, lowB, highB, reach)) m_verticesA.push_back({m_bFromA * p, m_bFromAThen * p, v});
	}
	for (const std::uint32_t v : b.verticesOf(m_pair.nodeB))
	{
		const MovedVertex moved{q.aFromB * b.vertices()[v], q.aFromBThen * b.vertices()[v], v};
		if (isFarB(moved.now)) continue;
		Vec3 low = kNowhereLow, high = kNowhereHigh;
		grow(low, high, moved.now);
		grow(low, high, moved.now + kPathReach * (moved.then - moved.now));
		if (meet(low, high, lowA, highA, reach)) m_verticesB.push_back(moved);
	}
	for (const std::uint32_t e : a.edgesOf(m_pair.nodeA))
	{
		Vec3 low = kNowhereLow, high = kNowhereHigh;
		bool isFar = true;
		for (const std::uint32_t v : a.edges()[e].vertex)
		{
			grow(low, high, a.vertices()[v]);
			isFar = isFar && isFarA(a.vertices()[v]);
		}
		if (!isFar && meet(low, high, lowB, highB, reach)) m_edgesA.push_back(e);
	}
	for (const std::uint32_t e : b.edgesOf(m_pair.nodeB))
	{
		const SurfaceEdge& edge = b.edges()[e];
		MovedEdge moved;
		moved.index = e;
		bool isFar = true;
		moved.low = kNowhereLow;
		moved.high = kNowhereHigh;
		for (const std::uint32_t v : edge.vertex)
		{
			const Vec3 &p = b.vertices()[v], now = q.aFromB * p;
			grow(moved.low, moved.high, now);
			grow(moved.low, moved.high, now + kPathReach * (q.aFromBThen * p - now));
			isFar = isFar && isFarB(now);
		}
		if (isFar || !meet(moved.low, moved.high, lowA, highA, reach)) continue;
		moved.start = q.aFromB * b.vertices()[edge.vertex[0]];
		moved.thenStart = q.aFromBThen * b.vertices()[edge.vertex[0]];
		moved.direction = q.aFromB.rotation * edge.direction;
		moved.thenDirection = q.aFromBThen.rotation * edge.direction;
		m_edgesB.push_back(moved);
	}
}

// Of facets that contacts may lead to, when their motion as predicted closes by so much.
double FacetFinder::highest(double closing) const
{
	return m_question->touching() + m_pair.roam + 0.5 * closing;
}

void FacetFinder::verticesOverFaces(bool vertexIsOfA)
{
	for (const MovedVertex& vertex : vertexIsOfA ? m_verticesA : m_verticesB)
		for (const std::uint32_t face : vertexIsOfA ? m_facesB : m_facesA) vertexOverFace(vertex, face, vertexIsOfA);
}

// In the face's frame.
void FacetFinder::vertexOverFace(const MovedVertex& vertex, std::uint32_t faceIndex, bool vertexIsOfA)
{
	const FacetQuestion& q = *m_question;
	const ContactSurface& faces = vertexIsOfA ? *m_pair.b : *m_pair.a;
	const ContactSurface& vertices = vertexIsOfA ? *m_pair.a : *m_pair.b;
	const SurfaceFace& face = faces.faces()[faceIndex];
	const double now = dot(face.normal, vertex.now) - face.offset;
	const double then = dot(face.normal, vertex.then) - face.offset;
	const double end = now + kPathReach * (then - now);
	if (now > highest(now - then) && end > q.rules.margin) return;
	if (now < -m_pair.deepest) return;

	const Vec3 up = vertexIsOfA ? q.aFromB.rotation * face.normal : m_bFromA.rotation * face.normal;
	if (!isLowest(vertices.fan(vertex.index), up, kArcSlack + m_turn)) return;
	const Vec3 foot = vertex.now - now * face.normal;
	const double touch = 2 * kInnerShare * q.length();
	Facet facet;
	facet.reach = now >= -touch ? Facet::Reach::kNear : Facet::Reach::kOverlap;
	bool counts = false;
	if (now <= q.touching())
	{
		const double slack =
			std::max(kFootShare * q.length(), std::min(-now, kDeepFootShare * q.length()));
		counts = isLowest(vertices.fan(vertex.index), up, kArcSlack) &&
				 faces.squaredBeside(faceIndex, foot) <= slack * slack;
	}
	if (!counts && now > 0 && end <= q.rules.margin && end < now)
	{
		facet.reach = Facet::Reach::kPath;
		const Vec3 move = kPathReach * (vertex.then - vertex.now);
		const double slack = kPathSlack * length(move) + kInnerShare * q.length();
		const double first = std::max(0.0, (now - q.rules.margin) / (now - end)), last = std::min(1.0, now / (now - end));
		const auto meets = [&](double share)
		{
			const Vec3 p = vertex.now + share * move;
			return faces.squaredBeside(faceIndex, p) <= slack * slack;
		};
		counts = meets(first) || meets(last);
	}
	if (!counts && now > 0 && now <= highest(now - then))
	{
		facet.reach = Facet::Reach::kPossible;
		const Vec3 middle = 0.5 * (vertex.now + vertex.then);
		const double slack = m_pair.roam + kFootShare * q.length();
		counts = faces.squaredBeside(faceIndex, middle) <= slack * slack;
	}
	if (!counts) return;
	facet.kind = vertexIsOfA ? Facet::Kind::kVertexFace : Facet::Kind::kFaceVertex;
	const std::uint32_t featureA = vertexIsOfA ? vertex.index : face.polygon;
	const std::uint32_t featureB = vertexIsOfA ? face.polygon : vertex.index;
	facet.featureA = featureA;
	facet.featureB = featureB;
	facet.distance = now;
	facet.then = then;
	facet.faceA = vertexIsOfA ? vertices.faceOfVertex(vertex.index) : faceIndex;
	facet.faceB = vertexIsOfA ? faceIndex : vertices.faceOfVertex(vertex.index);
	if (vertexIsOfA)
	{
		facet.normal = q.aFromB.rotation * face.normal;
		facet.onA = m_pair.a->vertices()[vertex.index];
		facet.onB = facet.onA - now * facet.normal;
	}
	else
	{
		facet.normal = -face.normal;
		facet.onB = vertex.now;
		facet.onA = facet.onB + now * facet.normal;
	}
	add(facet);
}

void FacetFinder::edgesOverEdges()
{
	const ContactSurface& a = *m_pair.a;
	const double reach = m_question->touching() + m_pair.beneath + m_pair.roam + kFootShare * m_question->length();
	for (const std::uint32_t e : m_edgesA)
	{
		const SurfaceEdge& edge = a.edges()[e];
		Vec3 low = kNowhereLow, high = kNowhereHigh;
		for (const std::uint32_t v : edge.vertex) grow(low, high, a.vertices()[v]);
		for (const MovedEdge& moved : m_edgesB)
			if (meet(low, high, moved.low, moved.high, reach)) edgeOverEdge(edge, moved);
	}
}

void FacetFinder::edgeOverEdge(const SurfaceEdge& edge, const MovedEdge& moved)
{
	const FacetQuestion& q = *m_question;
	const SurfaceEdge& other = m_pair.b->edges()[moved.index];
	Vec3 normal = cross(edge.direction, moved.direction);
	const double sine = length(normal);
	if (sine < kParallelSine) return;
	normal = (1 / sine) * normal;
	const Vec3 otherIn[2] = {q.aFromB.rotation * other.inward[0], q.aFromB.rotation * other.inward[1]};
	if (dot(normal, edge.inward[0] + edge.inward[1] - otherIn[0] - otherIn[1]) < 0) normal = -normal;
	const double arc = std::min(std::min(dot(normal, edge.inward[0]), dot(normal, edge.inward[1])),
								std::min(-dot(normal, otherIn[0]), -dot(normal, otherIn[1])));
	if (arc < -kArcSlack - m_turn) return;

	const Vec3& start = m_pair.a->vertices()[edge.vertex[0]];
	const double now = dot(normal, start - moved.start);
	if (now < -m_pair.deepest) return;
	Vec3 thenNormal = cross(edge.direction, moved.thenDirection);
	const double thenSine = length(thenNormal);
	double then = dot(normal, start - moved.thenStart);
	if (thenSine > kParallelSine)
	{
		thenNormal = (1 / thenSine) * thenNormal;
		if (dot(thenNormal, normal) < 0) thenNormal = -thenNormal;
		then = dot(thenNormal, start - moved.thenStart);
	}
	const double end = now + kPathReach * (then - now);
	if (now > highest(now - then) && end > q.rules.margin) return;

	LinesCrossing at = crossingOf(start, edge.direction, moved.start, moved.direction);
	Facet facet;
	facet.reach = now >= -2 * kInnerShare * q.length() ? Facet::Reach::kNear : Facet::Reach::kOverlap;
	bool counts = false;
	if (now <= q.touching() && arc >= -kArcSlack)
	{
		const double slack = std::max(kFootShare * q.length(), std::min(-now, kDeepFootShare * q.length()));
		counts = isWithin(at.alongA, edge.length, slack) && isWithin(at.alongB, other.length, slack);
	}
	if (!counts && now > 0 && end <= q.rules.margin && end < now)
	{
		facet.reach = Facet::Reach::kPath;
		const Vec3 move = kPathReach * (moved.thenStart - moved.start);
		const double slack = kPathSlack * length(move) + kInnerShare * q.length();
		const double first = std::max(0.0, (now - q.rules.margin) / (now - end)), last = std::min(1.0, now / (now - end));
		for (const double share : {first, last})
		{
			const Vec3 direction =
				normalized(moved.direction + share * kPathReach * (moved.thenDirection - moved.direction));
			if (length(cross(edge.direction, direction)) < kParallelSine) continue;
			const LinesCrossing there = crossingOf(start, edge.direction, moved.start + share * move, direction);
			if (!isWithin(there.alongA, edge.length, slack) || !isWithin(there.alongB, other.length, slack)) continue;
			counts = true;
			at = there;
			break;
		}
	}
	if (!counts && now > 0 && now <= highest(now - then))
	{
		facet.reach = Facet::Reach::kPossible;
		const double slack = m_pair.roam + kFootShare * q.length();
		const LinesCrossing middle =
			crossingOf(start, edge.direction, 0.5 * (moved.start + moved.thenStart), moved.direction);
		counts = isWithin(middle.alongA, edge.length, slack) && isWithin(middle.alongB, other.length, slack);
	}
	if (!counts) return;
	facet.kind = Facet::Kind::kEdgeEdge;
	facet.featureA = std::uint32_t(&edge - m_pair.a->edges().data());
	facet.featureB = moved.index;
	facet.faceA = edge.face[0];
	facet.faceB = other.face[0];
	facet.normal = normal;
	facet.distance = now;
	facet.then = then;
	// Where it will be met, on the way.
	at.alongA = std::max(0.0, std::min(edge.length, at.alongA));
	facet.onA = start + at.alongA * edge.direction;
	facet.onB = facet.onA - now * normal;
	add(facet);
}
}  // namespace clod
