// SPDX-License-Identifier: GPL-3.0-or-later
// What the selection of contacts reads in a node, computed again by other formulas: mean normal, cone, curvature and
// contact area.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/check/Rounding.h"
#include "builder/check/Subject.h"

namespace clod::check
{
namespace
{
constexpr double kDouble = 4e-16;    // of a unit vector, for a few roundings in double
constexpr double kRoundedUnit = 2e-7;  // of a unit vector's length, stored in floats
constexpr double kConeRoom = 1e-7;   // what a cone is wider than its faces need
constexpr double kAreaShare = 1e-6;  // of a contact area, for rounding at the ends of its bracket
constexpr double kScaledArea = 2;
constexpr double kCapRadius = 1e-5;  // the stored radius may exceed the one that caps were cut at
constexpr double kFacing = 0.2;      // faces turned farther from the contact normal end a contact area
constexpr double kCapShare = 0.25;   // of the radius
constexpr std::size_t kSides = 64;   // of the polygons that stand for discs here
const double kPi = std::acos(-1.0);

Vec3 areaVector(const Triangle& t)
{
	return 0.5 * cross(t[1] - t[0], t[2] - t[0]);
}

// What rounding in double may move a triangle's unit normal by: slivers have hardly any.
double noiseOf(const Triangle& t)
{
	const double area = 2 * length(areaVector(t));
	double longest = 0;
	for (std::size_t e = 0; e < 3; ++e) longest = std::max(longest, length(t[(e + 1) % 3] - t[e]));
	return kDouble * (1 + (area > 0 ? longest * longest / area : 0));
}

// Along `inward` from every face, where the hull is thickened.
bool leadsInside(const Subject& s, std::uint32_t i)
{
	const Node& n = s.h.node(i);
	const Vec3 inward = toVec3(n.inward);
	bool leads = std::abs(length(inward) - 1) < kRoundedUnit;
	for (std::uint32_t f = n.firstFace; n.thickness > 0 && f < n.firstFace + n.faceCount; ++f)
		leads = leads && dot(areaVector(s.triangle(f)), inward) < 0;
	return leads;
}

void directions(const Subject& s, std::uint32_t i, Tally& tally)
{
	const Node& n = s.h.node(i);
	Vec3 sum;
	double total = 0, noise = 0;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		sum += areaVector(s.triangle(f));
		total += length(areaVector(s.triangle(f)));
		noise = std::max(noise, noiseOf(s.triangle(f)));
	}
	const Vec3 mean = normalized(sum);
	const double meanNoise = 10 * kDouble * (1 + total / std::max(length(sum), 1e-300));
	bool sound = length(sum) > 1e-6 * total;
	for (int k = 0; k < 3; ++k) sound = sound && isNearestOf(n.meanNormal[k], mean[k], meanNoise);
	sound = sound && (s.h.isScaled() ? leadsInside(s, i) : -toVec3(n.inward) == toVec3(n.meanNormal));
	if (length(sum) <= 1e-6 * total) return tally.undecided();
	double narrowest = 1;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
		narrowest = std::min(narrowest, dot(normalized(areaVector(s.triangle(f))), mean));
	const double cone = std::max(-1.0, narrowest - kConeRoom);
	sound = sound && (isNextBelow(n.coneCosine, cone, noise + meanNoise) || (cone == -1 && n.coneCosine == -1));
	tally.add(i, sound ? 0 : 1, fmt::format("node {}: mean normal, inward or cone is not that of its faces", i));
}

// Between unit vectors, by chords: of the supplement where they point apart, as the chord's own arc is rough there.
double angleBetween(const Vec3& a, const Vec3& b)
{
	const bool isWide = dot(a, b) < 0;
	const double arc = 2 * std::asin(std::min(1.0, 0.5 * length(isWide ? a + b : a - b)));
	return isWide ? kPi - arc : arc;
}

// Whether the other face falls below this one's plane; where it lies in the plane, folded over, that is a rim, too.
bool fallsBelow(const Triangle& t, const Triangle& other)
{
	using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
	const auto point = [](const Vec3& p) { return Point(p.x, p.y, p.z); };
	const auto isAbove = [&](const Vec3& p)
	{ return CGAL::orientation(point(t[0]), point(t[1]), point(t[2]), point(p)) == CGAL::POSITIVE; };
	return std::none_of(other.begin(), other.end(), isAbove);
}

// Signed dihedral angles.
void curvature(const Subject& s, std::uint32_t i, Tally& tally)
{
	const Node& n = s.h.node(i);
	double sum = 0, noise = 0, area = 0;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		const Triangle t = s.triangle(f);
		const Vec3 normal = normalized(areaVector(t));
		area += length(areaVector(t));
		for (std::size_t e = 0; e < 3; ++e)
		{
			const std::uint32_t other = s.h.faces()[f].neighbour[e];
			if (other < f || s.ownerOfFace[other] != i) continue;
			const Triangle u = s.triangle(other);
			const double term = 0.5 * length(t[(e + 1) % 3] - t[e]) * angleBetween(normalized(areaVector(u)), normal);
			sum += fallsBelow(t, u) ? term : -term;
			noise += 0.5 * length(t[(e + 1) % 3] - t[e]) * (noiseOf(t) + noiseOf(u));
		}
	}
	if (area <= 0) return tally.undecided();
	const bool sound = isNearestOf(n.curvature, sum / area, 10 * noise / area);
	tally.add(i, sound ? 0 : 1, fmt::format("node {}: curvature {:.9g} is {:.9g}", i, double(n.curvature), sum / area));
}

// Cosine and sine of the directions of the sides.
std::array<std::pair<double, double>, kSides> sideDirections()
{
	std::array<std::pair<double, double>, kSides> sides;
	for (std::size_t k = 0; k < kSides; ++k)
		sides[k] = {std::cos(2 * kPi * double(k) / kSides), std::sin(2 * kPi * double(k) / kSides)};
	return sides;
}

// Area along the face's normal of the surface that hangs together with it in a slab, delta to either side of the point,
// and a polygon round the point whose sides lie `side` away.
double touchedArea(const Subject& s, std::uint32_t start, const Vec3& origin, double delta, double side)
{
	static const auto sides = sideDirections();
	const Vec3 normal = normalized(areaVector(s.triangle(start)));
	const Vec3 u = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1}));
	const Vec3 v = cross(normal, u);
	std::vector<std::uint32_t> open = {start}, seen = {start};
	double sum = 0;
	for (std::size_t next = 0; next < open.size(); ++next)
	{
		const Triangle t = s.triangle(open[next]);
		std::vector<Vec3> polygon = {t[0] - origin, t[1] - origin, t[2] - origin};
		keepBelow(polygon, normal, delta);
		keepBelow(polygon, -normal, delta);
		double farthest = 0;
		for (const Vec3& p : polygon) farthest = std::max(farthest, length(p));
		for (std::size_t k = 0; k < kSides && farthest > side && !polygon.empty(); ++k)
			keepBelow(polygon, sides[k].first * u + sides[k].second * v, side);
		if (polygon.empty()) continue;
		Vec3 area;
		for (std::size_t k = 2; k < polygon.size(); ++k)
			area += 0.5 * cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
		sum += std::max(0.0, dot(area, normal));
		for (const std::uint32_t other : s.h.faces()[open[next]].neighbour)
		{
			const auto at = std::lower_bound(seen.begin(), seen.end(), other);
			if (at != seen.end() && *at == other) continue;
			if (dot(normalized(areaVector(s.triangle(other))), normal) <= kFacing) continue;
			seen.insert(at, other);
			open.push_back(other);
		}
	}
	return std::max(sum, 4 * delta * delta);
}

struct Range
{
	double low = 0, high = 0;
};

// A leaf's own area: at its face nearest to its middle; every face as near, to rounding, may have been taken. The
// builder's cap is a polygon of 16 sides and of the disc's area, turned anyhow: it contains its inscribed disc and lies
// in its circumscribed one, and a larger cap never touches less, nor does a thicker slab. Where the surface leaves cap
// or slab and comes back, the areas of two that are nearly equal differ by whole pieces. The slab's stored half-width
// is rounded up, so that of the builder lies in a bracket too.
Range leafArea(const Subject& s, std::uint32_t i)
{
	const Node& n = s.h.node(i);
	Vec3 middle;
	double total = 0, least = 1e300;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		const Triangle t = s.triangle(f);
		const double area = length(areaVector(t));
		middle += (area / 3) * (t[0] + t[1] + t[2]);
		total += area;
	}
	middle = (1 / total) * middle;
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
		least = std::min(least, distance(s.triangle(f), middle));
	const double delta = double(s.h.asset().areaTolerance), thinnest = delta * (1 - kStored);
	const double circumscribed = kCapShare * s.radius * std::sqrt(kPi / (16 * std::tan(kPi / 16))) / std::cos(kPi / 16);
	const double inscribed = circumscribed * std::cos(kPi / 16) * std::cos(kPi / kSides) * (1 - kCapRadius);
	Range range{1e300, 0};
	for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
	{
		if (distance(s.triangle(f), middle) > least + 1e-7 * s.radius) continue;
		const Vec3 origin = nearestOn(s.triangle(f), middle);
		range = {std::min(range.low, touchedArea(s, f, origin, thinnest, inscribed)),
				 std::max(range.high, touchedArea(s, f, origin, delta, circumscribed))};
	}
	return range;
}

// Of a scaled body, whose areas only choose and were not measured anew, none exceeds the recipe's by much. Above the
// leaves: 1 / D is the root mean square of theirs, weighted by surface (with paper: the least of the children's), and
// nothing is below a parent's.
Invariant contactAreas(const Subject& s)
{
	Tally tally("contact-areas");
	std::vector<Range> own(s.h.nodes().size), inverse(s.h.nodes().size);
	std::vector<double> surface(s.h.nodes().size, 0);
	s.forEach("contact-areas", s.h.levels()[0].nodeCount,
			  [&](std::size_t i) { own[i] = leafArea(s, std::uint32_t(i)); });
	for (std::uint32_t i = 0; i < s.h.nodes().size; ++i)
	{
		const Node& n = s.h.node(i);
		if (!s.isContact(i)) continue;
		if (n.level == 0)
		{
			for (std::uint32_t f = n.firstFace; f < n.firstFace + n.faceCount; ++f)
				surface[i] += length(areaVector(s.triangle(f)));
			inverse[i] = {surface[i] / (own[i].high * own[i].high), surface[i] / (own[i].low * own[i].low)};
		}
		for (std::uint32_t k = 0; k < n.primaryChildCount; ++k)
		{
			const std::uint32_t c = s.h.children(n)[k];
			surface[i] += surface[c];
			inverse[i] = {inverse[i].low + inverse[c].low, inverse[i].high + inverse[c].high};
		}
		if (n.level > 0) own[i] = {std::sqrt(surface[i] / inverse[i].high), std::sqrt(surface[i] / inverse[i].low)};
		double ofParents = 0, ofChildren = 1e300;
		if (!s.h.isPaperBuild())
			for (const std::uint32_t p : s.parents[i]) ofParents = std::max(ofParents, double(s.h.node(p).contactArea));
		for (const std::uint32_t c : s.h.children(n))
			ofChildren = std::min(ofChildren, double(s.h.node(c).contactArea));
		if (s.h.isPaperBuild() && n.level > 0) own[i] = {ofChildren, ofChildren};
		const double stored = double(n.contactArea);
		const double low = s.h.isScaled() ? ofParents : std::max(ofParents, (1 - kStored - kAreaShare) * own[i].low);
		const double high = std::max(ofParents, (s.h.isScaled() ? kScaledArea : 1 + kAreaShare) * own[i].high);
		tally.add(i, std::max(low - stored, stored - high),
				  fmt::format("node {}: contact area {:.6g} is not within [{:.6g}, {:.6g}]", i, stored, low, high));
	}
	return tally.result();
}
}  // namespace

Invariants checkLocalNumbers(const Subject& s)
{
	Tally direction("normals-and-cones"), bend("curvature");
	s.forEach("curvature", s.h.nodes().size,
			  [&](std::size_t i)
			  {
				  if (!s.isContact(std::uint32_t(i))) return;
				  directions(s, std::uint32_t(i), direction);
				  curvature(s, std::uint32_t(i), bend);
			  });
	return {direction.result(), bend.result(), contactAreas(s)};
}
}  // namespace clod::check
