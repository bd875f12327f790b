// SPDX-License-Identifier: GPL-3.0-or-later
// The cover rule of Validity.h, by areas: what a front lacks must be no more than the strips between its border and its
// outline, and a strip is nowhere wider than the rule allows. A notch, however narrow, is deeper than that.
#include <algorithm>
#include <utility>

#include "builder/patches/Remainder.h"
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
	const Plane plane;
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
	// Areas that are nothing.
	double rounding() const
	{
		const double perimeter = perimeterOf(outline);
		return 1e-13 * perimeter * perimeter + blind * blind;
	}
	double width() const { return length(box.high - box.low); }
	// Where faces up to this height are, and a little lower ones.
	Box below(double height) const
	{
		Box all = box;
		all.include(Box{box.low + height * plane.normal, box.high + height * plane.normal});
		return all.grownBy(blind);
	}
	Vec3 onPlane(const Point2& p) const
	{
		const Vec3 at = frame.origin + p.x * frame.e1 + p.y * frame.e2;
		return at - plane.height(at) * plane.normal;
	}
	std::array<Point2, 3> project(const TrianglePoints& t) const { return {frame(t[0]), frame(t[1]), frame(t[2])}; }
	// What of a face is within these heights.
	std::vector<Point2> slice(const TrianglePoints& t, double above, double below) const
	{
		static thread_local std::vector<Vec3> polygon, scratch;
		polygon.assign(t.begin(), t.end());
		clipBelow(polygon, {-plane.normal, -plane.offset}, above, scratch);
		clipBelow(polygon, plane, -below, scratch);
		std::vector<Point2> projected;
		for (const Vec3& p : polygon) projected.push_back(frame(p));
		return projected;
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
	return !isExact || depthUnderMean() > kBlind * tolerance || frontIsCovered(m_meanPlane, m_points[0]);
}

// A patch of slightly turned faces may show each of them a part of its points only, and be thin as a whole: then all
// points are the front of its mean plane. A closed surface has none, and shows its largest face.
double Validity::depthUnderMean()
{
	Vec3 sum, largest;
	double total = 0;
	for (const TrianglePoints& t : m_facePoints)
	{
		const Vec3 area = cross(t[1] - t[0], t[2] - t[0]);
		sum += area;
		total += length(area);
		if (lengthSquared(area) > lengthSquared(largest)) largest = area;
	}
	m_meanPlane = {normalized(length(sum) > 1e-6 * total ? sum : largest), -1e300};
	double lowest = 1e300;
	for (const Vec3& p : m_points)
	{
		const double height = dot(m_meanPlane.normal, p);
		m_meanPlane.offset = std::max(m_meanPlane.offset, height);
		lowest = std::min(lowest, height);
	}
	return m_meanPlane.offset - lowest;
}

bool Validity::coversItself(const std::vector<std::uint32_t>& faces)
{
	load(faces);
	return isCovered() && !spansNotch();
}

bool Validity::spansNotch(std::uint32_t patch)
{
	load(m_mesh.patches[patch].faces);
	return spansNotch();
}

// Of what the patch, halfway down, leaves open: whether a point is farther from the surface than twice the rule's
// depth. Pieces are halved until one face is near all of them, or none is.
bool Validity::spansNotch()
{
	const double depth = depthUnderMean();
	if (depth > 2 * kBlind * tolerance) return false;
	const auto found = frontOf({m_meanPlane.normal, m_meanPlane.offset - 0.5 * depth}, m_points[0]);
	if (!found) return false;
	const Front& front = *found;
	const double least = 0.5 * tolerance, most = 2 * front.blind - 2 * least;
	std::vector<std::vector<Point2>> open = remainderOf(front, least, most, true).open();
	while (!open.empty())
	{
		std::vector<Point2> piece = std::move(open.back());
		open.pop_back();
		if (piece.size() < 3) continue;
		Point2 middle, way;
		for (const Point2& p : piece) middle.x += p.x / double(piece.size()), middle.y += p.y / double(piece.size());
		for (const Point2& p : piece)
			if (std::hypot(p.x - middle.x, p.y - middle.y) > std::hypot(way.x, way.y))
				way = {p.x - middle.x, p.y - middle.y};
		const std::uint32_t face = nearestFace(front.onPlane(middle), most);
		if (face == kNone) return true;
		const TrianglePoints t = m_mesh.points(face);
		const auto isNear = [&](const Point2& p) { return squaredDistance(front.onPlane(p), t) <= most * most; };
		if (std::hypot(way.x, way.y) <= least || std::all_of(piece.begin(), piece.end(), isNear)) continue;
		open.push_back(cutRight(piece, middle, {middle.x - way.y, middle.y + way.x}));
		open.push_back(std::move(piece));
	}
	return false;
}

// kNone if none is within the limit.
std::uint32_t Validity::nearestFace(const Vec3& p, double limit) const
{
	std::uint32_t nearest = kNone;
	double least = limit * limit;
	m_mesh.faceTree.nearestSquared(p, least,
								   [&](std::uint32_t face)
								   {
									   const double squared = squaredDistance(p, m_mesh.points(face));
									   if (squared < least) least = squared, nearest = face;
									   return squared;
								   });
	return nearest;
}

std::optional<Validity::Front> Validity::frontOf(const Plane& plane, const Vec3& origin) const
{
	const double blind = kBlind * tolerance;
	static thread_local std::vector<Vec3> shown;
	shown.clear();
	for (const Vec3& p : m_points)
		if (plane.height(p) >= -blind) shown.push_back(p);
	if (shown.size() <= 3) return {};
	Front front{plane, blind, PlaneFrame(plane, origin), {}, {}, {}, {}};
	std::vector<Point2> points;
	for (const Vec3& p : shown)
	{
		points.push_back(front.frame(p));
		front.box.include(p);
	}
	front.outline = convexHull(std::move(points));
	front.enclose();
	return front;
}

bool Validity::frontIsCovered(const Plane& plane, const Vec3& origin)
{
	const std::optional<Front> found = frontOf(plane, origin);
	if (!found) return true;
	const Front& front = *found;
	const double rounding = front.rounding(), whole = areaOf(front.outline), shown = shownCover(front);
	double lacking = whole - rounding - shown;
	if (lacking > 0) lacking -= strips(front);
	if (lacking > 0) lacking -= dippingCover(front);
	const auto isExactlyCovered = [&]
	{ return remainderOf(front, front.blind, front.blind, false).openArea() <= rounding; };
	if (lacking <= 0) return !isExact || shown <= whole + rounding + 1e-9 * whole || isExactlyCovered();
	const double foreign = foreignCover(front);
	if (lacking > foreign) return false;
	return !isExact || whole - rounding - shown <= foreign - doubleCover(front) || isExactlyCovered();
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
	const double slab = front.blind, height = slab + front.width();
	double covered = 0;
	searchForeign(front.below(height),
				  [&](std::uint32_t face, const TrianglePoints& t)
				  {
					  const bool leaves = dot(cross(t[1] - t[0], t[2] - t[0]), plane.normal) > 0;
					  const auto heights = std::minmax({plane.height(t[0]), plane.height(t[1]), plane.height(t[2])});
					  if (heights.second <= (leaves ? -slab : 0) || heights.first >= height) return true;
					  if (front.isBeside(front.project(t))) return true;
					  const double area = areaOf(clipped(front.slice(t, leaves ? -slab : 0, height), front.outline));
					  covered += area;
					  if (area != 0) m_supports.push_back(face);
					  return true;
				  });
	return covered;
}

// At least what the areas above count more than once: of two sheets within the rule's depth, the patch's or the
// solid's, the lower has a face above it that enters the solid.
double Validity::doubleCover(const Front& front) const
{
	double twice = 0;
	const auto addEntering = [&](const TrianglePoints& t)
	{
		if (dot(cross(t[1] - t[0], t[2] - t[0]), front.plane.normal) < 0)
			twice -= areaOf(clipped(front.slice(t, -front.blind, front.blind), front.outline));
		return true;
	};
	for (const TrianglePoints& t : m_facePoints) addEntering(t);
	searchForeign(front.below(0), [&](std::uint32_t, const TrianglePoints& t) { return addEntering(t); });
	return twice;
}

// Of the front, but for a border, what is neither inside the solid nor has the patch or a face that leaves the solid
// (or any face) within the depth.
Remainder Validity::remainderOf(const Front& front, double border, double depth, bool byAny) const
{
	const double above = 4 * m_mesh.radius;
	Remainder open(front.outline, border, 1e-3 * border * border);
	const auto leaves = [&](const TrianglePoints& t)
	{ return dot(cross(t[1] - t[0], t[2] - t[0]), front.plane.normal) > 0; };
	for (const TrianglePoints& t : m_facePoints)
		if (byAny || leaves(t)) open.take(byAny ? front.slice(t, -depth, depth) : front.slice(t, -above, above));
	searchForeign(front.below(0),
				  [&](std::uint32_t, const TrianglePoints& t)
				  {
					  if (byAny || leaves(t)) open.take(front.slice(t, -depth, depth));
					  return true;
				  });
	if (open.openArea() <= front.rounding()) return open;
	std::vector<std::pair<std::vector<Point2>, int>> counted;
	const auto countAbove = [&](const TrianglePoints& t)
	{
		const bool isUp = leaves(t);
		if (!front.isBeside(front.project(t)))
			counted.push_back({front.slice(t, isUp && !byAny ? depth : 0, above), isUp ? 1 : -1});
		return true;
	};
	searchForeign(front.below(above), [&](std::uint32_t, const TrianglePoints& t) { return countAbove(t); });
	// Of a closed patch both sides are its own.
	for (const TrianglePoints& t : m_facePoints)
		if (byAny) countAbove(t);
	for (auto& [polygon, change] : counted) open.count(std::move(polygon), change);
	return open;
}
}  // namespace clod::builder
