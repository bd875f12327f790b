// SPDX-License-Identifier: Zlib
// The point of a simplex nearest to the origin, the inner step of GJK, by descending to the faces that the origin is
// outside of. The faces of a tetrahedron are examined side by side, a face a lane. For InstructionSets.h: no include
// guard.
//
// Every decision is a comparison of products of the same dimension, so the result does not depend on the unit. The
// vector to a triangle is taken along its normal, not as a combination of its corners: the direction then keeps its
// accuracy when the triangle is long and thin and the origin close to it, and with it the lower bound GJK certifies.
//
// Based on: Ericson, Real-Time Collision Detection, sec. 5.1 and 9.5; Montanari et al., "Improving the GJK algorithm
// for faster and more reliable distance queries", 2017 (signed volumes).

#include "clod/collide/SupportKernel.h"

// Four points or vectors.
struct Points
{
	Values x{}, y{}, z{};
};
CLOD_INLINED void difference(const Points& a, const Points& b, Points& r)
{
	r.x = a.x - b.x, r.y = a.y - b.y, r.z = a.z - b.z;
}
CLOD_INLINED void product(const Points& a, const Points& b, Values& r)
{
	r = a.x * b.x + a.y * b.y + a.z * b.z;
}
CLOD_INLINED void product(const Points& a, const Points& b, Points& r)
{
	r.x = a.y * b.z - a.z * b.y, r.y = a.z * b.x - a.x * b.z, r.z = a.x * b.y - a.y * b.x;
}
template <const int (&lanes)[4]>
CLOD_INLINED void shuffled(const Points& a, Points& r)
{
	r.x = __builtin_shufflevector(a.x, a.x, lanes[0], lanes[1], lanes[2], lanes[3]);
	r.y = __builtin_shufflevector(a.y, a.y, lanes[0], lanes[1], lanes[2], lanes[3]);
	r.z = __builtin_shufflevector(a.z, a.z, lanes[0], lanes[1], lanes[2], lanes[3]);
}
CLOD_INLINED Vec3 pointOf(const Points& points, int i)
{
	return {points.x[i], points.y[i], points.z[i]};
}

// The sum, the largest of all lanes.
CLOD_INLINED double sumOf(const Values& values)
{
	const Values halves = values + __builtin_shufflevector(values, values, 2, 3, 0, 1);
	return halves[0] + halves[1];
}
CLOD_INLINED double largestOf(const Values& values)
{
	const Values other = __builtin_shufflevector(values, values, 2, 3, 0, 1);
	const Values halves = values > other ? values : other;
	return halves[0] > halves[1] ? halves[0] : halves[1];
}
// Bit i: lane i of a comparison.
CLOD_INLINED unsigned bitsOf(const Indices& mask)
{
#ifdef CLOD_WIDE
	return unsigned(_mm256_movemask_pd((__m256d)mask));
#else
	unsigned bits = 0;
	for (int i = 0; i < 4; ++i) bits |= mask[i] != 0 ? 1U << i : 0;
	return bits;
#endif
}
// The first lane with the smallest value.
CLOD_INLINED int smallestLane(const Values& values)
{
	Values least = __builtin_shufflevector(values, values, 2, 3, 0, 1);
	least = values < least ? values : least;
	const Values other = __builtin_shufflevector(least, least, 1, 0, 3, 2);
	least = least < other ? least : other;
	return __builtin_ctz(bitsOf(values == least) | 16) & 3;
}
constexpr Values kUnit[4]{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

// Nearest points of four triangles to the origin.
struct NearestOnTriangles
{
	Points at;
	Values weight[3]{};  // of the corners a, b, c
	Values squared{};
};
CLOD_INLINED void consider(NearestOnTriangles& best, const Indices& allowed, const Points& at, const Values& ofA,
						   const Values& ofB, const Values& ofC)
{
	Values squared;
	product(at, at, squared);
	const Indices take = allowed & (squared < best.squared);
	best.at.x = take ? at.x : best.at.x;
	best.at.y = take ? at.y : best.at.y;
	best.at.z = take ? at.z : best.at.z;
	best.weight[0] = take ? ofA : best.weight[0];
	best.weight[1] = take ? ofB : best.weight[1];
	best.weight[2] = take ? ofC : best.weight[2];
	best.squared = take ? squared : best.squared;
}
// `ofQ`: the weight of the edge's end.
CLOD_INLINED void nearestOnEdges(const Points& p, const Points& q, const Points& edge, Values& ofQ, Points& at)
{
	const Values zero{}, one = zero + 1.0;
	Values along, squared;
	product(p, edge, along);
	product(edge, edge, squared);
	along = -along;
	ofQ = along <= zero ? zero : along >= squared ? one : along / squared;
	// From the nearer end: less cancellation.
	const Indices first = ofQ <= 0.5;
	const Values step = first ? ofQ : ofQ - one;
	at.x = (first ? p.x : q.x) + step * edge.x;
	at.y = (first ? p.y : q.y) + step * edge.y;
	at.z = (first ? p.z : q.z) + step * edge.z;
}
CLOD_INLINED void nearestOnTriangles(const Points& a, const Points& b, const Points& c, NearestOnTriangles& best)
{
	const Values zero{}, one = zero + 1.0;
	Points ab, ac, bc, normal, sideA, sideB, sideC, at;
	difference(b, a, ab);
	difference(c, a, ac);
	difference(c, b, bc);
	product(ab, ac, normal);
	product(a, ab, sideC);
	product(ac, a, sideB);
	product(b, bc, sideA);
	// Barycentric coordinates of the projection; a negative one names an edge that the origin is outside of.
	Values ofA, ofB, ofC, area, squaredB, squaredC, height;
	product(sideA, normal, ofA);
	product(sideB, normal, ofB);
	product(sideC, normal, ofC);
	product(normal, normal, area);
	product(ab, ab, squaredB);
	product(ac, ac, squaredC);
	product(a, normal, height);
	best.squared = zero + std::numeric_limits<double>::infinity();
	const Indices proper = area > kDegenerate * kDegenerate * (squaredB * squaredC);
	const Indices inside = proper & (ofA > zero) & (ofB > zero) & (ofC > zero);
	const Values share = one / (ofA + ofB + ofC);
	height /= area;
	at.x = height * normal.x, at.y = height * normal.y, at.z = height * normal.z;
	consider(best, inside, at, ofA * share, ofB * share, ofC * share);
	Values ofEnd;
	nearestOnEdges(a, b, ab, ofEnd, at);
	consider(best, ~inside & (~proper | (ofC <= zero)), at, one - ofEnd, ofEnd, zero);
	nearestOnEdges(a, c, ac, ofEnd, at);
	consider(best, ~inside & (~proper | (ofB <= zero)), at, one - ofEnd, zero, ofEnd);
	nearestOnEdges(b, c, bc, ofEnd, at);
	consider(best, ~inside & (~proper | (ofA <= zero)), at, zero, one - ofEnd, ofEnd);
}

struct SimplexPoint
{
	Vec3 nearest;         // of the simplex to the origin
	Values weight{};      // nearest = sum of weight * corner; all >= 0, sum 1
	bool inside = false;  // a tetrahedron that encloses the origin; nearest is then the rounding residual
};
CLOD_INLINED Vec3 combined(const Values& weight, const Points& points)
{
	return {sumOf(weight * points.x), sumOf(weight * points.y), sumOf(weight * points.z)};
}

CLOD_INLINED void closestOnSegment(const Points& corner, SimplexPoint& result)
{
	const Vec3 p = pointOf(corner, 0), q = pointOf(corner, 1), edge = q - p;
	const double along = -dot(p, edge), squared = lengthSquared(edge);
	const double ofQ = along <= 0 ? 0 : along >= squared ? 1 : along / squared;
	result.nearest = ofQ <= 0.5 ? p + ofQ * edge : q - (1 - ofQ) * edge;
	result.weight = Values{1 - ofQ, ofQ, 0, 0};
}

// Edges side by side, in each corner's lane that to the next one; the first again in the last lane.
constexpr int kEdgeStart[4]{0, 1, 2, 0}, kEdgeEnd[4]{1, 2, 0, 1}, kFirst[4]{0, 0, 0, 0}, kThird[4]{2, 2, 2, 2};

CLOD_INLINED void closestOnTriangle(const Points& corner, SimplexPoint& result)
{
	const Values zero{};
	Points p, q, edge, toFirst, normal, side, at;
	shuffled<kEdgeStart>(corner, p);
	shuffled<kEdgeEnd>(corner, q);
	difference(q, p, edge);
	shuffled<kThird>(edge, toFirst);
	shuffled<kFirst>(edge, normal);
	product(toFirst, Points(normal), normal);
	product(p, edge, side);
	// Barycentric coordinates of the projection, of the corner across from the edge; a negative one names an edge that
	// the origin is outside of.
	Values across, area, squared, height, ofQ;
	product(side, normal, across);
	product(normal, normal, area);
	product(edge, edge, squared);
	product(p, normal, height);
	const bool proper = area[0] > kDegenerate * kDegenerate * (squared[0] * squared[2]);
	const Indices inner = across > zero;
	if (proper && bitsOf(inner) == 15)
	{
		const double share = 1 / (across[0] + across[1] + across[2]), step = height[0] / area[0];
		result.nearest = step * pointOf(normal, 0);
		result.weight = share * Values{across[1], across[2], across[0], 0};
		return;
	}
	nearestOnEdges(p, q, edge, ofQ, at);
	product(at, at, squared);
	const Values none = zero + std::numeric_limits<double>::infinity();
	const Values eligible = inner ? none : squared;
	const int best = smallestLane(proper ? eligible : squared);
	result.nearest = pointOf(at, best);
	result.weight = (1 - ofQ[best]) * kUnit[best] + ofQ[best] * kUnit[best == 2 ? 0 : best + 1];
}

// Weights that reproduce the origin to rounding prove that a tetrahedron encloses it. gradient[i] is that of weight i.
// Those of a sliver are noise at first: two steps of iterative refinement. Negative weights left: not enclosed.
CLOD_INLINED void enclosure(const Points& corner, const Points& gradient, SimplexPoint& first)
{
	for (int step = 0; step < 3; ++step)
	{
		first.nearest = combined(first.weight, corner);
		if (step == 2) break;
		const Vec3& residual = first.nearest;
		const Values zero{},
			refined = first.weight - (gradient.x * residual.x + gradient.y * residual.y + gradient.z * residual.z);
		first.weight = refined > zero ? refined : zero;
		first.weight /= sumOf(first.weight);
	}
	Values squared;
	product(corner, corner, squared);
	first.inside = lengthSquared(first.nearest) <= kResidual * kResidual * largestOf(squared);
}

// Corner of the face in each lane: the first, second, third; the lane's own is opposite.
constexpr int kFaceA[4]{1, 0, 0, 0}, kFaceB[4]{2, 3, 1, 2}, kFaceC[4]{3, 2, 3, 1};

CLOD_INLINED void closestOnTetrahedron(const Points& corner, SimplexPoint& result)
{
	Points a, b, c, ab, ac, toOpposite, normal, gradient;
	shuffled<kFaceA>(corner, a);
	shuffled<kFaceB>(corner, b);
	shuffled<kFaceC>(corner, c);
	difference(b, a, ab);
	difference(c, a, ac);
	difference(corner, a, toOpposite);
	product(ab, ac, normal);
	Values ofOrigin, ofOpposite, area, height;
	product(normal, a, ofOrigin);
	product(normal, toOpposite, ofOpposite);
	product(normal, normal, area);
	product(toOpposite, toOpposite, height);
	const Values weight = -ofOrigin / ofOpposite;
	const Indices within = (ofOpposite * ofOpposite > kDegenerate * kDegenerate * (area * height)) & (weight > 0.0);
	Indices allowed = ~within;
	if (bitsOf(within) == 15)
	{
		const Values share = 1.0 / ofOpposite;
		gradient.x = share * normal.x, gradient.y = share * normal.y, gradient.z = share * normal.z;
		result.weight = weight;
		enclosure(corner, gradient, result);
		if (result.inside) return;
		allowed = Indices{-1, -1, -1, -1};
	}
	NearestOnTriangles faces;
	nearestOnTriangles(a, b, c, faces);
	const Values none = Values{} + std::numeric_limits<double>::infinity();
	const int best = smallestLane(allowed ? faces.squared : none);
	result.nearest = pointOf(faces.at, best);
	result.weight = faces.weight[0][best] * kUnit[kFaceA[best]] + faces.weight[1][best] * kUnit[kFaceB[best]] +
					faces.weight[2][best] * kUnit[kFaceC[best]];
}

// Nearest point of the hull of the first `count` corners, 1 <= count <= 4, to the origin. The other corners are not
// read, their weights are 0.
CLOD_INLINED void closestToOrigin(const Points& corner, int count, SimplexPoint& result)
{
	if (count == 4)
		closestOnTetrahedron(corner, result);
	else if (count == 3)
		closestOnTriangle(corner, result);
	else if (count == 2)
		closestOnSegment(corner, result);
	else
	{
		result.nearest = pointOf(corner, 0);
		result.weight = kUnit[0];
	}
}
