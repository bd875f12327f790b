// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Overlap.h"

#include <algorithm>
#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr double kOnSurface = 1e-11;  // share of the radius
constexpr double kTiny = 1e-300;  // what isAny answers for an overlap of no depth

Mat3 rotationBy(const Vec3& angle)
{
	const double size = length(angle);
	if (size == 0) return {};
	const double s = std::sin(0.5 * size) / size;
	return rotationFromQuaternion(s * angle.x, s * angle.y, s * angle.z, std::cos(0.5 * size));
}

void dropRepeated(std::vector<std::uint32_t>& indices)
{
	std::sort(indices.begin(), indices.end());
	indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}
}  // namespace

Transform displacement(const RelativeMotion& motion, const Vec3& center, double t)
{
	const double time = t * motion.timeStep;
	const Mat3 rotation = rotationBy(time * motion.angular);
	return {rotation, center - rotation * center + time * motion.velocity(center)};
}

Overlap::Overlap(const Solid& a, const Solid& b, const Transform& aFromB, double reach)
	: m_a(a), m_b(b), m_aFromB(aFromB), m_bFromA(inverse(aFromB))
{
	for (const Vec3& v : b.mesh().vertices) m_atB.push_back(aFromB * v);
	for (std::uint32_t f = 0; f < b.mesh().triangles.size(); ++f)
		m_normalsB.push_back(aFromB.rotation * b.normal(f));
	m_atA = a.mesh().vertices;
	m_normalsA.resize(a.mesh().triangles.size());
	m_seenA.resize(m_atA.size());
	m_seenB.resize(m_atB.size());
	collect(reach);
}

// Pairs of an edge of one and a face of the other whose boxes come within reach.
std::array<Overlap::EdgeFacePairs, 2> Overlap::nearPairs(double reach) const
{
	using Pair = std::pair<std::uint32_t, std::uint32_t>;
	std::array<EdgeFacePairs, 2> found;
	const auto boxOf = [](const Edge& edge, const std::vector<Vec3>& at)
	{
		Box box;
		for (const std::uint32_t v : edge.vertex) box.add(at[v]);
		return box;
	};
	std::vector<Box> boxesB(m_b.mesh().triangles.size());
	for (std::size_t f = 0; f < boxesB.size(); ++f)
		for (const std::uint32_t v : m_b.mesh().triangles[f]) boxesB[f].add(m_atB[v]);
	const auto addFaces = [&](std::uint32_t fa, std::uint32_t fb)
	{
		const Box &boxA = m_a.faceBox(fa), &boxB = boxesB[fb];
		if (gap(boxA, boxB) > reach) return;
		const auto add = [&](std::size_t side, std::uint32_t edge, std::uint32_t face, double apart)
		{
			if (apart <= reach) found[side].push_back({{edge, face}, apart});
		};
		for (const std::uint32_t e : m_a.ownEdges(fa))
			add(0, e, fb, gap(boxOf(m_a.edges()[e], m_atA), boxB));
		for (const std::uint32_t e : m_b.ownEdges(fb))
			add(1, e, fa, gap(boxOf(m_b.edges()[e], m_atB), boxA));
	};
	std::vector<Pair> stack = {{0, 0}};
	while (!stack.empty())
	{
		const Pair top = stack.back();
		stack.pop_back();
		const BoxNode &na = m_a.nodes()[top.first], &nb = m_b.nodes()[top.second];
		const Box boxB = transformed(nb.box, m_aFromB);
		if (gap(na.box, boxB) > reach) continue;
		if (na.count > 0 && nb.count > 0)
		{
			for (std::uint32_t i = 0; i < na.count; ++i)
				for (std::uint32_t k = 0; k < nb.count; ++k)
					addFaces(m_a.ordered(na.first + i), m_b.ordered(nb.first + k));
			continue;
		}
		const bool openA = nb.count > 0 || (na.count == 0 && lengthSquared(na.box.high - na.box.low) >
																 lengthSquared(nb.box.high - nb.box.low));
		for (std::uint32_t i = 0; i < 2; ++i)
			stack.push_back(openA ? Pair{na.first + i, top.second} : Pair{top.first, nb.first + i});
	}
	for (EdgeFacePairs& pairs : found) std::sort(pairs.begin(), pairs.end());
	return found;
}

void Overlap::collect(double reach)
{
	m_sides[0].solid = m_sides[1].other = &m_b;
	m_sides[1].solid = m_sides[0].other = &m_a;
	const std::array<EdgeFacePairs, 2> found = nearPairs(reach);
	for (std::size_t s = 0; s < 2; ++s)
	{
		Side& side = m_sides[s];
		for (const auto& [pair, apart] : found[s])
		{
			if (side.edges.empty() || side.edges.back() != pair.first)
			{
				side.edges.push_back(pair.first);
				side.firstFace.push_back(std::uint32_t(side.faces.size()));
				side.leastGaps.push_back(apart);
			}
			side.faces.push_back(pair.second);
			side.gaps.push_back(apart);
			side.leastGaps.back() = std::min(side.leastGaps.back(), apart);
		}
		side.firstFace.push_back(std::uint32_t(side.faces.size()));
	}
	m_usedFacesA = m_sides[1].faces;
	dropRepeated(m_usedFacesA);
	for (const std::uint32_t e : m_sides[0].edges)
		for (const std::uint32_t v : m_a.edges()[e].vertex) m_usedA.push_back(v);
	for (const std::uint32_t f : m_usedFacesA)
		for (const std::uint32_t v : m_a.mesh().triangles[f]) m_usedA.push_back(v);
	dropRepeated(m_usedA);
}

void Overlap::place(const Transform& moved)
{
	m_moved = moved;
	m_back = inverse(moved);
	for (const std::uint32_t v : m_usedA) m_atA[v] = moved * m_a.mesh().vertices[v];
	for (const std::uint32_t f : m_usedFacesA) m_normalsA[f] = moved.rotation * m_a.normal(f);
}

double Overlap::find(const Transform& moved, double way, bool isDepth)
{
	if (m_sides[0].edges.empty() && m_sides[1].edges.empty()) return 0;
	place(moved);
	++m_call;
	const double first = findSide(true, way, isDepth);
	if (first > 0 && !isDepth) return first;
	return std::max(first, findSide(false, way, isDepth));
}

double Overlap::findSide(bool edgesOfA, double way, bool isDepth)
{
	const Side& side = m_sides[edgesOfA ? 0 : 1];
	const std::vector<Vec3>&from = edgesOfA ? m_atA : m_atB, &to = edgesOfA ? m_atB : m_atA;
	const std::vector<Vec3>& normals = edgesOfA ? m_normalsB : m_normalsA;
	double deepest = 0;
	for (std::size_t k = 0; k < side.edges.size(); ++k)
	{
		if (side.leastGaps[k] > way) continue;
		const Edge& edge = side.other->edges()[side.edges[k]];
		const Vec3 &p = from[edge.vertex[0]], &q = from[edge.vertex[1]];
		m_crossings.clear();
		for (std::uint32_t i = side.firstFace[k]; i < side.firstFace[k + 1]; ++i)
		{
			if (side.gaps[i] > way) continue;
			const std::uint32_t f = side.faces[i];
			const auto& t = side.solid->mesh().triangles[f];
			const Vec3& n = normals[f];
			const double dp = dot(n, p - to[t[0]]), dq = dot(n, q - to[t[0]]);
			if ((dp < 0) == (dq < 0)) continue;
			const double at = dp / (dp - dq);
			const Vec3 x = p + at * (q - p);
			bool isInside = true;
			for (std::size_t c = 0; c < 3 && isInside; ++c)
				isInside = dot(n, cross(to[t[(c + 1) % 3]] - to[t[c]], x - to[t[c]])) >= 0;
			if (!isInside) continue;
			if (!isDepth) return kTiny;
			m_crossings.push_back({at, f, dp > dq});
		}
		if (!m_crossings.empty()) deepest = std::max(deepest, depthOf(edgesOfA, side.edges[k]));
	}
	return deepest;
}

// Of one edge, from the faces it crosses.
double Overlap::depthOf(bool edgesOfA, std::uint32_t edge)
{
	std::sort(m_crossings.begin(), m_crossings.end(),
			  [](const Crossing& l, const Crossing& r) { return l.at < r.at; });
	const Side& side = m_sides[edgesOfA ? 0 : 1];
	const Edge& e = side.other->edges()[edge];
	const std::vector<Vec3>& from = edgesOfA ? m_atA : m_atB;
	const Vec3 &p = from[e.vertex[0]], &q = from[e.vertex[1]];
	double deepest = 0;
	for (std::size_t i = 0; i < m_crossings.size(); ++i)
	{
		const Crossing& crossing = m_crossings[i];
		if (!crossing.isEntry && (i == 0 || !m_crossings[i - 1].isEntry))
			deepest = std::max(deepest, vertexDepth(edgesOfA, e.vertex[0]));
		if (!crossing.isEntry) continue;
		if (i + 1 < m_crossings.size() && !m_crossings[i + 1].isEntry)
			deepest = std::max(deepest, segmentDepth(edgesOfA, p, q, crossing, m_crossings[i + 1]));
		else
			deepest = std::max(deepest, vertexDepth(edgesOfA, e.vertex[1]));
	}
	return deepest;
}

double Overlap::segmentDepth(bool edgesOfA, const Vec3& p, const Vec3& q, const Crossing& in,
							 const Crossing& out) const
{
	const std::vector<Vec3>& normals = edgesOfA ? m_normalsB : m_normalsA;
	const Solid& pierced = edgesOfA ? m_b : m_a;
	const Transform& local = edgesOfA ? m_bFromA : m_back;
	const Vec3 from = p + in.at * (q - p), to = p + out.at * (q - p), way = to - from;
	if (lengthSquared(way) == 0) return 0;
	const Vec3 &n1 = normals[in.face], &n2 = normals[out.face];
	const double rate1 = -dot(n1, way), rate2 = dot(n2, way);
	// The shortest way out over the ridge of both planes; along u the planes are left at s rate1 / (n1.u) and
	// (1 - s) rate2 / (n2.u), and the deeper place is where both are equal.
	if (rate1 <= 0 || rate2 <= 0) return 0;
	const Vec3 middle = local * (0.5 * (from + to));
	const Solid::Nearest nearest = pierced.nearest(middle);
	if (nearest.distance > -kOnSurface * pierced.radius()) return 0;
	const Vec3 m = (1 / rate1) * n1 + (1 / rate2) * n2;
	const double size = length(m), most = pierced.radius();
	const Vec3 start = local * from, along = local.rotation * way;
	const auto wayOut = [&](const Vec3& direction, double deepest)
	{
		double depth = 0;
		for (const double s : {deepest, 0.5, 0.1, 0.9})
			depth = std::max(depth, pierced.exitDistance(start + s * along, direction, most));
		return depth;
	};
	double least = most;
	if (size * length(way) > 1e-3)
	{
		const Vec3 u = (1 / size) * m;
		const double c1 = dot(n1, u) / rate1, c2 = dot(n2, u) / rate2;
		least = std::min(1 / size, wayOut(local.rotation * u, c1 > 0 && c2 > 0 ? c1 / (c1 + c2) : 0.5));
	}
	const Vec3 shortest = nearest.point - middle;
	const Vec3 across = shortest - dot(shortest, along) / lengthSquared(along) * along;
	if (lengthSquared(across) > 0.01 * lengthSquared(shortest))
		least = std::min(least, wayOut(normalized(across), 0.5));
	return least;
}

double Overlap::vertexDepth(bool ofA, std::uint32_t vertex)
{
	std::uint32_t& seen = (ofA ? m_seenA : m_seenB)[vertex];
	if (seen == m_call) return 0;
	seen = m_call;
	const double distance =
		ofA ? m_b.signedDistance(m_bFromA * m_atA[vertex]) : m_a.signedDistance(m_back * m_atB[vertex]);
	return std::max(0.0, -distance);
}

bool Overlap::isApart()
{
	if (isAny({})) return false;
	for (const std::uint32_t v : m_a.seeds())
		if (m_b.signedDistance(m_bFromA * m_a.mesh().vertices[v]) < 0) return false;
	for (const std::uint32_t v : m_b.seeds())
		if (m_a.signedDistance(m_atB[v]) < 0) return false;
	return true;
}
}  // namespace clod::oracle
