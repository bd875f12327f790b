// SPDX-License-Identifier: GPL-3.0-or-later
// The cover rule of Validity.h, by areas: what a front lacks must be no more than the strips between its border and its
// outline, and a strip is nowhere wider than the rule allows. A notch, however narrow, is deeper than that.
#include <algorithm>

#include "builder/patches/Validity.h"

namespace clod::builder
{
namespace
{
// Two axes of the plane's own coordinates.
struct PlaneFrame
{
	Vec3 origin, e1, e2;
	PlaneFrame(const Plane& plane, const Vec3& at) : origin(at)
	{
		const Vec3& n = plane.normal;
		const Vec3 axis = std::fabs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
		e1 = normalized(cross(axis, n));
		e2 = cross(n, e1);
	}
	Point2 operator()(const Vec3& p) const { return {dot(p - origin, e1), dot(p - origin, e2)}; }
};

// Area between a segment and the side of the outline it runs along, where it is within `width` of one; negative where
// it runs backwards, so that a border's segments add up to what it leaves out. Zero where it is near no side.
double stripArea(const Point2& p, const Point2& q, const std::vector<Point2>& outline, double width)
{
	double nearest = width, area = 0;
	for (std::size_t i = 0; i < outline.size(); ++i)
	{
		const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
		const double dx = b.x - a.x, dy = b.y - a.y, along = std::sqrt(dx * dx + dy * dy);
		const double ofP = (dx * (p.y - a.y) - dy * (p.x - a.x)) / along;
		const double ofQ = (dx * (q.y - a.y) - dy * (q.x - a.x)) / along;
		const double farther = std::max(ofP, ofQ);
		if (farther > nearest) continue;
		nearest = farther;
		area = 0.5 * (ofP + ofQ) * (dx * (q.x - p.x) + dy * (q.y - p.y)) / along;
	}
	return area;
}
}  // namespace

// What a patch shows on the outer side of the plane of one of its faces, in the plane's coordinates.
struct Validity::Front
{
	const Plane& plane;
	const double blind;  // lower points are not of the front
	const PlaneFrame frame;
	std::vector<Point2> outline;
	Box box;
	Point2 low{}, high{};  // of the outline

	double lowest(const TrianglePoints& t) const
	{
		return std::min({plane.height(t[0]), plane.height(t[1]), plane.height(t[2])});
	}
	bool shows(const Plane& face, const TrianglePoints& t) const
	{
		return dot(face.normal, plane.normal) > 0 && lowest(t) >= -blind;
	}
	void enclose()
	{
		low = high = outline[0];
		for (const Point2& p : outline)
		{
			low = {std::min(low.x, p.x), std::min(low.y, p.y)};
			high = {std::max(high.x, p.x), std::max(high.y, p.y)};
		}
	}
	bool isBeside(const std::array<Point2, 3>& t) const
	{
		return std::max({t[0].x, t[1].x, t[2].x}) <= low.x || std::min({t[0].x, t[1].x, t[2].x}) >= high.x ||
			   std::max({t[0].y, t[1].y, t[2].y}) <= low.y || std::min({t[0].y, t[1].y, t[2].y}) >= high.y;
	}
};

bool Validity::isCovered()
{
	m_covered.assign(m_faces.size(), 0);
	m_supports.clear();
	for (std::size_t i = 0; i < m_faces.size(); ++i)
		if (!m_covered[i] && !frontIsCovered(m_facePlanes[i], m_facePoints[i][0])) return false;
	return !coversMeanPlane || !isFlat() || frontIsCovered(m_meanPlane, m_points[0]);
}

// A patch of slightly turned faces may show each of them a part of its points only, and be thin as a whole: then all
// points are the front of its mean plane.
bool Validity::isFlat()
{
	Vec3 sum;
	for (const TrianglePoints& t : m_facePoints) sum += cross(t[1] - t[0], t[2] - t[0]);
	m_meanPlane = {normalized(sum), -1e300};
	double lowest = 1e300;
	for (const Vec3& p : m_points)
	{
		const double height = dot(m_meanPlane.normal, p);
		m_meanPlane.offset = std::max(m_meanPlane.offset, height);
		lowest = std::min(lowest, height);
	}
	return m_meanPlane.offset - lowest <= kBlind * tolerance;
}

bool Validity::frontIsCovered(const Plane& plane, const Vec3& origin)
{
	const double blind = kBlind * tolerance;
	static thread_local std::vector<Vec3> shown;
	shown.clear();
	for (const Vec3& p : m_points)
		if (plane.height(p) >= -blind) shown.push_back(p);
	if (shown.size() <= 3) return true;
	Front front{plane, blind, PlaneFrame(plane, origin), {}, {}, {}, {}};
	std::vector<Point2> points;
	for (const Vec3& p : shown)
	{
		points.push_back(front.frame(p));
		front.box.include(p);
	}
	front.outline = convexHull(std::move(points));
	front.enclose();
	const double perimeter = perimeterOf(front.outline);
	const double rounding = 1e-13 * perimeter * perimeter + front.blind * front.blind;
	double lacking = areaOf(front.outline) - rounding - shownCover(front);
	if (lacking > 0) lacking -= strips(front);
	if (lacking > 0) lacking -= dippingCover(front);
	return lacking <= 0 || lacking <= foreignCover(front);
}

// By the faces that show.
double Validity::shownCover(const Front& front)
{
	double covered = 0;
	for (std::size_t i = 0; i < m_faces.size(); ++i)
	{
		const TrianglePoints& t = m_facePoints[i];
		if (!front.shows(m_facePlanes[i], t)) continue;
		covered += 0.5 * dot(m_facePlanes[i].normal, front.plane.normal) * length(cross(t[1] - t[0], t[2] - t[0]));
		if (front.lowest(t) >= -2 * tolerance) m_covered[i] = 1;
	}
	return covered;
}

// By faces of the patch that turn the same way and reach below the front.
double Validity::dippingCover(const Front& front) const
{
	double covered = 0;
	for (std::size_t i = 0; i < m_faces.size(); ++i)
	{
		const TrianglePoints& t = m_facePoints[i];
		if (dot(m_facePlanes[i].normal, front.plane.normal) <= 0 || front.lowest(t) >= -front.blind) continue;
		covered += areaOf(clipped({front.frame(t[0]), front.frame(t[1]), front.frame(t[2])}, front.outline));
	}
	return covered;
}

// Between the border of the faces that show and the outline.
double Validity::strips(const Front& front) const
{
	double area = 0;
	for (std::size_t i = 0; i < m_faces.size(); ++i)
	{
		const TrianglePoints& t = m_facePoints[i];
		if (!front.shows(m_facePlanes[i], t)) continue;
		for (int k = 0; k < 3; ++k)
		{
			const std::uint32_t next = neighbour(m_faces[i], k);
			if (next != kNone && contains(next))
			{
				const TrianglePoints other = points(next);
				const Plane plane = isMoved(next) ? planeOf(other[0], other[1], other[2]) : m_mesh.planes[next];
				if (front.shows(plane, other)) continue;
			}
			area += stripArea(front.frame(t[std::size_t(k)]), front.frame(t[std::size_t((k + 1) % 3)]), front.outline,
							  front.blind);
		}
	}
	return area;
}

// Area of the front that lies inside the solid or just outside: over such a point one more face leaves the solid than
// enters it. Faces higher than the front is wide are left out, which can only make the result smaller.
double Validity::foreignCover(const Front& front)
{
	const Plane& plane = front.plane;
	const double slab = front.blind;
	const double height = slab + length(front.box.high - front.box.low);
	Box searched = front.box;
	searched.include(Box{front.box.low + height * plane.normal, front.box.high + height * plane.normal});
	double covered = 0;
	searchForeign(searched.grownBy(slab),
				  [&](std::uint32_t face, const TrianglePoints& t)
				  {
					  const bool leaves = dot(cross(t[1] - t[0], t[2] - t[0]), plane.normal) > 0;
					  const auto heights = std::minmax({plane.height(t[0]), plane.height(t[1]), plane.height(t[2])});
					  if (heights.second <= (leaves ? -slab : 0) || heights.first >= height) return true;
					  if (front.isBeside({front.frame(t[0]), front.frame(t[1]), front.frame(t[2])})) return true;
					  static thread_local std::vector<Vec3> polygon, scratch;
					  polygon.assign(t.begin(), t.end());
					  clipBelow(polygon, {-plane.normal, -plane.offset}, leaves ? -slab : 0, scratch);
					  clipBelow(polygon, plane, -height, scratch);
					  if (polygon.empty()) return true;
					  std::vector<Point2> projected;
					  for (const Vec3& p : polygon) projected.push_back(front.frame(p));
					  const double area = areaOf(clipped(std::move(projected), front.outline));
					  covered += area;
					  if (area != 0) m_supports.push_back(face);
					  return true;
				  });
	return covered;
}
}  // namespace clod::builder
