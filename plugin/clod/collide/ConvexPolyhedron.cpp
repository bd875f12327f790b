// SPDX-License-Identifier: Zlib
#include "clod/collide/ConvexPolyhedron.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace clod
{
namespace
{
constexpr double kFlat = 1e-6;      // of the size: extents below are none
constexpr double kVisible = 1e-9;   // of the size: how far above a face a point is outside, beyond rounding
constexpr double kExact = 2e-7;     // of the size: vertices are floats
constexpr double kAbove = 1e-12;    // of the size: points less far above a face, by rounding or not, never count again
constexpr std::uint32_t kNobody = 0xFFFFFFFFu;

struct HullFace
{
	std::array<std::uint32_t, 3> vertex;
	std::array<std::uint32_t, 3> neighbour;  // across edge (vertex[i], vertex[i + 1])
	Vec3 normal;
	double offset = 0;
	Vec3 beyond;           // the body's farthest point along the normal,
	double error = 0;      // and how far outside it is
	std::vector<std::uint32_t> above;  // of points: those that are outside, in order
	bool isAlive = true;
};

// An edge between faces that a point is outside of and others: its ends, the face that goes, the one that stays, and
// its edge there.
struct HorizonEdge
{
	std::uint32_t from, to, inside, outside, edge;
	bool operator<(const HorizonEdge& other) const { return from < other.from; }
};
using Horizon = std::vector<HorizonEdge>;  // in order, no two from one vertex

class Hull
{
public:
	// points: what the support function is of, if it is of points.
	Hull(const Support& support, const std::vector<Vec3>& points, double accuracy, std::size_t mostVertices)
		: m_support(support), m_points(points), m_accuracy(accuracy), m_mostVertices(mostVertices)
	{
	}
	ConvexPolyhedron make();

private:
	Vec3 farthest(const Vec3& direction) const { return toVec3(toFloat3(m_support(direction))); }
	bool findSimplex();
	void makeFlat(const Vec3& normal);
	std::uint32_t addFace(std::uint32_t a, std::uint32_t b, std::uint32_t c, const std::vector<std::uint32_t>& near);
	Vec3 farthestAbove(HullFace& face, const std::vector<std::uint32_t>& near);
	void measure(HullFace& face) const;
	bool isOutward(const HullFace& face) const
	{
		return face.normal != Vec3{} && dot(face.normal, m_inside) < face.offset;
	}
	void makeSimplex();
	void refine();
	std::vector<std::uint32_t> facesBelow(std::uint32_t from, const Vec3& point);
	Horizon horizonOf(const std::vector<std::uint32_t>& visible) const;
	bool isConvexRing(const Horizon& horizon, const Vec3& point) const;
	bool insert(std::uint32_t from, const Vec3& point);
	ConvexPolyhedron result() const;

	const Support& m_support;
	const std::vector<Vec3>& m_points;
	const double m_accuracy;
	const std::size_t m_mostVertices;
	double m_size = 0;
	std::vector<Vec3> m_vertices;
	std::vector<HullFace> m_faces;
	std::priority_queue<std::pair<double, std::uint32_t>> m_byError;  // of faces that have one, by ~index
	std::vector<std::uint32_t> m_below;  // by face: the last search of facesBelow that found it
	std::uint32_t m_search = 0;
	std::vector<std::uint32_t> m_all, m_near, m_above;  // of points: all; of a face that is made, those
	std::vector<std::array<std::uint32_t, 3>> m_flat;
	Vec3 m_inside;
	double m_error = 0;
};

Vec3 acrossOf(const Vec3& v)
{
	return normalized(cross(v, std::abs(v.x) <= std::abs(v.y) && std::abs(v.x) <= std::abs(v.z) ? Vec3{1, 0, 0}
							   : std::abs(v.y) <= std::abs(v.z)                                 ? Vec3{0, 1, 0}
																								: Vec3{0, 0, 1}));
}

// The first points, as many as the body has dimensions and one. True: it is solid.
bool Hull::findSimplex()
{
	std::vector<Vec3> points;
	for (int x = -1; x <= 1; ++x)
		for (int y = -1; y <= 1; ++y)
			for (int z = -1; z <= 1; ++z)
				if (x != 0 || y != 0 || z != 0) points.push_back(farthest({double(x), double(y), double(z)}));
	double widest = -1, largest = 0;
	Vec3 a, b;
	for (const Vec3& p : points)
		for (const Vec3& q : points)
			if (lengthSquared(p - q) > widest)
			{
				widest = lengthSquared(p - q);
				a = p;
				b = q;
			}
	for (const Vec3& p : points) largest = std::max(largest, length(p));
	m_size = std::sqrt(widest);
	m_vertices = {a};
	if (m_size <= kExact * largest) return false;
	m_vertices.push_back(b);
	const Vec3 along = normalized(b - a), across = acrossOf(along), third = cross(along, across);
	Vec3 c, d;
	double far = 0;
	for (const Vec3& direction : {across, -across, third, -third, across + third, across - third})
	{
		const Vec3 p = farthest(direction);
		const double off = length(cross(p - a, along));
		if (off > far)
		{
			far = off;
			c = p;
		}
	}
	if (far <= kFlat * m_size) return false;
	const Vec3 normal = normalized(cross(b - a, c - a));
	far = 0;
	for (const Vec3& direction : {normal, -normal})
	{
		const Vec3 p = farthest(direction);
		if (std::abs(dot(p - a, normal)) <= far) continue;
		far = std::abs(dot(p - a, normal));
		d = p;
	}
	if (far <= kFlat * m_size)
	{
		m_vertices.push_back(c);
		makeFlat(normal);
		return false;
	}
	if (dot(normal, d - a) > 0) std::swap(b, c);
	m_vertices = {a, b, c, d};
	m_inside = 0.25 * (a + b + c + d);
	return true;
}

// A polygon, refined edge by edge in its plane.
void Hull::makeFlat(const Vec3& normal)
{
	std::vector<Vec3> ring = m_vertices;
	for (;;)
	{
		double worst = std::max(m_accuracy, kExact * m_size);
		std::size_t at = ring.size();
		Vec3 beyond;
		m_error = 0;
		for (std::size_t i = 0; i < ring.size(); ++i)
		{
			const Vec3 out = normalized(cross(ring[(i + 1) % ring.size()] - ring[i], normal));
			const Vec3 p = farthest(out);
			const double error = dot(out, p - ring[i]);
			m_error = std::max(m_error, error);
			if (error <= worst) continue;
			worst = error;
			at = i;
			beyond = p;
		}
		if (at == ring.size() || ring.size() >= m_mostVertices) break;
		ring.insert(ring.begin() + std::ptrdiff_t(at) + 1, beyond);
	}
	m_vertices = ring;
	for (std::uint32_t i = 2; i < ring.size(); ++i)
	{
		m_flat.push_back({0, i - 1, i});
		m_flat.push_back({0, i, i - 1});
	}
}

void Hull::measure(HullFace& face) const
{
	const Vec3 &a = m_vertices[face.vertex[0]], &b = m_vertices[face.vertex[1]], &c = m_vertices[face.vertex[2]];
	face.normal = normalized(cross(b - a, c - a));
	face.offset = std::max({dot(face.normal, a), dot(face.normal, b), dot(face.normal, c)});
}

// Of points, of those near the face; lists in it what is above it.
Vec3 Hull::farthestAbove(HullFace& face, const std::vector<std::uint32_t>& near)
{
	if (m_points.empty()) return farthest(face.normal);
	const double above = face.offset + kAbove * m_size;
	double most = face.offset;
	Vec3 beyond = m_vertices[face.vertex[0]];
	m_above.clear();
	for (const std::uint32_t i : near)
	{
		const double far = dot(m_points[i], face.normal);
		if (!(far > above)) continue;
		m_above.push_back(i);
		if (far <= most) continue;
		most = far;
		beyond = m_points[i];
	}
	face.above = m_above;
	return toVec3(toFloat3(beyond));
}

std::uint32_t Hull::addFace(std::uint32_t a, std::uint32_t b, std::uint32_t c, const std::vector<std::uint32_t>& near)
{
	HullFace face;
	face.vertex = {a, b, c};
	face.neighbour = {kNobody, kNobody, kNobody};
	measure(face);
	face.beyond = farthestAbove(face, near);
	face.error = dot(face.normal, face.beyond) - face.offset;
	const std::uint32_t index = std::uint32_t(m_faces.size());
	m_faces.push_back(std::move(face));
	m_below.push_back(0);
	if (m_faces[index].error > 0) m_byError.push({m_faces[index].error, ~index});
	return index;
}

void Hull::makeSimplex()
{
	m_all.resize(m_points.size());
	std::iota(m_all.begin(), m_all.end(), 0u);
	addFace(0, 1, 2, m_all);
	addFace(0, 3, 1, m_all);
	addFace(1, 3, 2, m_all);
	addFace(2, 3, 0, m_all);
	m_faces[0].neighbour = {1, 2, 3};
	m_faces[1].neighbour = {3, 2, 0};
	m_faces[2].neighbour = {1, 3, 0};
	m_faces[3].neighbour = {2, 1, 0};
}

// The faces that the point is outside of, from one of them on.
std::vector<std::uint32_t> Hull::facesBelow(std::uint32_t from, const Vec3& point)
{
	std::vector<std::uint32_t> visible(1, from);
	m_below[from] = ++m_search;
	for (std::size_t i = 0; i < visible.size(); ++i)
		for (const std::uint32_t next : m_faces[visible[i]].neighbour)
		{
			const HullFace& other = m_faces[next];
			if (m_below[next] == m_search || !(dot(other.normal, point) - other.offset > kVisible * m_size)) continue;
			m_below[next] = m_search;
			visible.push_back(next);
		}
	return visible;
}

// The edges round the faces; none where two of them start at one vertex.
Horizon Hull::horizonOf(const std::vector<std::uint32_t>& visible) const
{
	Horizon horizon;
	for (const std::uint32_t f : visible)
		for (std::size_t e = 0; e < 3; ++e)
		{
			const HullFace& face = m_faces[f];
			const std::uint32_t outside = face.neighbour[e], to = face.vertex[(e + 1) % 3];
			if (m_below[outside] == m_search) continue;
			std::uint32_t back = 0;
			while (m_faces[outside].neighbour[back] != f || m_faces[outside].vertex[back] != to) ++back;
			horizon.push_back({face.vertex[e], to, f, outside, back});
		}
	std::sort(horizon.begin(), horizon.end());
	for (std::size_t i = 1; i < horizon.size(); ++i)
		if (horizon[i].from == horizon[i - 1].from) return {};
	return horizon;
}

// The edge that starts where another ends.
const HorizonEdge* edgeFrom(const Horizon& horizon, std::uint32_t vertex)
{
	const auto found = std::lower_bound(horizon.begin(), horizon.end(), HorizonEdge{vertex, 0, 0, 0, 0});
	return found != horizon.end() && found->from == vertex ? &*found : nullptr;
}

// Is the horizon one ring, and does each of its edges make a face with the point that has the inside below it?
bool Hull::isConvexRing(const Horizon& horizon, const Vec3& point) const
{
	if (horizon.empty()) return false;
	const HorizonEdge* at = &horizon.front();
	std::size_t length = 0;
	do
	{
		if (++length > horizon.size()) return false;
		HullFace face;
		face.vertex = {at->from, at->to, 0};
		const Vec3 &a = m_vertices[at->from], &b = m_vertices[at->to];
		face.normal = normalized(cross(b - a, point - a));
		face.offset = dot(face.normal, a);
		if (!isOutward(face)) return false;
		at = edgeFrom(horizon, at->to);
		if (!at) return false;
	} while (at != &horizon.front());
	return length == horizon.size();
}

// Faces below the point go, those round them are joined to it. False: rounding forbids it, and nothing has changed.
bool Hull::insert(std::uint32_t from, const Vec3& point)
{
	const std::vector<std::uint32_t> visible = facesBelow(from, point);
	const Horizon horizon = horizonOf(visible);
	if (!isConvexRing(horizon, point)) return false;

	for (const std::uint32_t f : visible) m_faces[f].isAlive = false;
	const std::uint32_t apex = std::uint32_t(m_vertices.size());
	m_vertices.push_back(point);
	std::uint32_t first = kNobody, last = kNobody;
	const HorizonEdge* at = &horizon.front();
	do
	{
		// Where the point is not above the face that stays, the plane of the new one lies between those of the two
		// that meet at the edge: what is above it is above one of them. Else it is a little steeper, and far from a
		// short face anything may be above it, corners of the one that stays, too.
		const HullFace &inside = m_faces[at->inside], &outside = m_faces[at->outside];
		m_near.clear();
		if (dot(outside.normal, m_vertices[apex]) > outside.offset)
			m_near = m_all;
		else
			std::set_union(inside.above.begin(), inside.above.end(), outside.above.begin(), outside.above.end(),
						   std::back_inserter(m_near));
		const std::uint32_t face = addFace(at->from, at->to, apex, m_near);
		m_faces[face].neighbour[0] = at->outside;
		m_faces[at->outside].neighbour[at->edge] = face;
		if (last != kNobody)
		{
			m_faces[face].neighbour[2] = last;
			m_faces[last].neighbour[1] = face;
		}
		else
			first = face;
		last = face;
		at = edgeFrom(horizon, at->to);
	} while (at != &horizon.front());
	m_faces[first].neighbour[2] = last;
	m_faces[last].neighbour[1] = first;
	for (const std::uint32_t f : visible) std::vector<std::uint32_t>().swap(m_faces[f].above);
	return true;
}

void Hull::refine()
{
	const double accuracy = std::max(m_accuracy, kExact * m_size);
	double refused = 0;
	for (;;)
	{
		while (!m_byError.empty() && !m_faces[~m_byError.top().second].isAlive) m_byError.pop();
		m_error = m_byError.empty() ? 0 : m_byError.top().first;
		if (m_error <= accuracy || m_vertices.size() >= m_mostVertices) break;
		const std::uint32_t worst = ~m_byError.top().second;
		m_byError.pop();
		if (!insert(worst, m_faces[worst].beyond)) refused = std::max(refused, m_error);
	}
	m_error = std::max(m_error, refused);
}

ConvexPolyhedron Hull::result() const
{
	ConvexPolyhedron polyhedron;
	polyhedron.error = m_error;
	if (m_faces.empty())
	{
		polyhedron.vertices = m_vertices;
		polyhedron.triangles = m_flat;
		return polyhedron;
	}
	std::vector<std::uint32_t> place(m_vertices.size(), kNobody);
	for (const HullFace& face : m_faces)
	{
		if (!face.isAlive) continue;
		std::array<std::uint32_t, 3> triangle;
		for (std::size_t i = 0; i < 3; ++i)
		{
			std::uint32_t& at = place[face.vertex[i]];
			if (at == kNobody)
			{
				at = std::uint32_t(polyhedron.vertices.size());
				polyhedron.vertices.push_back(m_vertices[face.vertex[i]]);
			}
			triangle[i] = at;
		}
		polyhedron.triangles.push_back(triangle);
	}
	return polyhedron;
}

ConvexPolyhedron Hull::make()
{
	if (findSimplex())
	{
		makeSimplex();
		refine();
	}
	return result();
}
}  // namespace

ConvexPolyhedron::Plane ConvexPolyhedron::nearestPlane(const Vec3& point) const
{
	Plane best{{}, std::numeric_limits<double>::infinity()};
	for (const auto& t : triangles)
	{
		const Vec3& corner = vertices[t[0]];
		const Vec3 normal = normalized(cross(vertices[t[1]] - corner, vertices[t[2]] - corner));
		const double height = dot(normal, corner - point);
		if (normal != Vec3{} && height < best.height) best = {normal, height};
	}
	return best;
}

ConvexPolyhedron convexPolyhedron(const Support& support, double accuracy, std::size_t mostVertices)
{
	return Hull(support, {}, accuracy, std::max<std::size_t>(4, mostVertices)).make();
}

ConvexPolyhedron convexPolyhedron(const std::vector<Vec3>& points, std::size_t mostVertices)
{
	const Support farthest = [&points](const Vec3& direction)
	{
		const auto isLess = [&](const Vec3& l, const Vec3& r) { return dot(l, direction) < dot(r, direction); };
		return points.empty() ? Vec3{} : *std::max_element(points.begin(), points.end(), isLess);
	};
	return Hull(farthest, points, 0, std::max<std::size_t>(4, mostVertices)).make();
}
}  // namespace clod
