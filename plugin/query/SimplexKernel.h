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

#include "clod/query/SupportKernel.h"

// Below this share of the product of its sides an area or volume is rounding noise of the corners.
constexpr double kDegenerate = 1e-13;
constexpr double kResidual = 1e-14;  // of an enclosure, relative to the farthest corner

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
CLOD_INLINED void shuffled(const Points& a, const Indices& lanes, Points& r)
{
	r.x = __builtin_shuffle(a.x, lanes), r.y = __builtin_shuffle(a.y, lanes), r.z = __builtin_shuffle(a.z, lanes);
}

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
	Vec3 nearest;           // of the simplex to the origin
	double weight[4] = {};  // nearest = sum of weight * corner; all >= 0, sum 1
	bool inside = false;    // a tetrahedron that encloses the origin; nearest is then the rounding residual
};

CLOD_INLINED Vec3 pointOf(const Points& points, int i)
{
	return {points.x[i], points.y[i], points.z[i]};
}

CLOD_INLINED void closestOnSegment(const Points& corner, SimplexPoint& result)
{
	const Vec3 p = pointOf(corner, 0), q = pointOf(corner, 1), edge = q - p;
	const double along = -dot(p, edge), squared = lengthSquared(edge);
	const double ofQ = along <= 0 ? 0 : along >= squared ? 1 : along / squared;
	result.nearest = ofQ <= 0.5 ? p + ofQ * edge : q - (1 - ofQ) * edge;
	result.weight[0] = 1 - ofQ;
	result.weight[1] = ofQ;
}

// Weights that reproduce the origin to rounding prove that a tetrahedron encloses it. gradient[i] is that of weight i.
// Those of a sliver are noise at first: two steps of iterative refinement. Negative weights left: not enclosed.
CLOD_INLINED void enclosure(const Points& corner, const Points& gradient, SimplexPoint& first)
{
	for (int step = 0; step < 3; ++step)
	{
		first.nearest = Vec3{};
		for (int i = 0; i < 4; ++i) first.nearest += first.weight[i] * pointOf(corner, i);
		if (step == 2) break;
		double sum = 0;
		for (int i = 0; i < 4; ++i)
		{
			first.weight[i] = std::max(0.0, first.weight[i] - dot(pointOf(gradient, i), first.nearest));
			sum += first.weight[i];
		}
		for (double& weight : first.weight) weight /= sum;
	}
	double size = 0;
	for (int i = 0; i < 4; ++i) size = std::max(size, lengthSquared(pointOf(corner, i)));
	first.inside = lengthSquared(first.nearest) <= kResidual * kResidual * size;
}

// Corner of the face in each lane: the first, second, third; the lane's own is opposite.
constexpr Indices kFaceA{1, 0, 0, 0}, kFaceB{2, 3, 1, 2}, kFaceC{3, 2, 3, 1};

CLOD_INLINED void closestOnTetrahedron(const Points& corner, SimplexPoint& result)
{
	Points a, b, c, ab, ac, toOpposite, normal, gradient;
	shuffled(corner, kFaceA, a);
	shuffled(corner, kFaceB, b);
	shuffled(corner, kFaceC, c);
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
	bool enclosed = true;
	for (int i = 0; i < 4; ++i) enclosed = enclosed && within[i] != 0;
	Indices allowed = ~within;
	if (enclosed)
	{
		const Values share = 1.0 / ofOpposite;
		gradient.x = share * normal.x, gradient.y = share * normal.y, gradient.z = share * normal.z;
		for (int i = 0; i < 4; ++i) result.weight[i] = weight[i];
		enclosure(corner, gradient, result);
		if (result.inside) return;
		allowed = Indices{-1, -1, -1, -1};
	}
	NearestOnTriangles faces;
	nearestOnTriangles(a, b, c, faces);
	int best = -1;
	for (int i = 0; i < 4; ++i)
		if (allowed[i] != 0 && (best < 0 || faces.squared[i] < faces.squared[best])) best = i;
	result.nearest = pointOf(faces.at, best);
	result.weight[best] = 0;
	result.weight[kFaceA[best]] = faces.weight[0][best];
	result.weight[kFaceB[best]] = faces.weight[1][best];
	result.weight[kFaceC[best]] = faces.weight[2][best];
}

// Nearest point of the hull of the first `count` corners, 1 <= count <= 4, to the origin.
CLOD_INLINED void closestToOrigin(const Points& corner, int count, SimplexPoint& result)
{
	if (count == 1)
	{
		result.nearest = pointOf(corner, 0);
		result.weight[0] = 1;
	}
	else if (count == 2)
		closestOnSegment(corner, result);
	else if (count == 3)
	{
		Points a, b, c;
		shuffled(corner, Indices{0, 0, 0, 0}, a);
		shuffled(corner, Indices{1, 1, 1, 1}, b);
		shuffled(corner, Indices{2, 2, 2, 2}, c);
		NearestOnTriangles face;
		nearestOnTriangles(a, b, c, face);
		result.nearest = pointOf(face.at, 0);
		for (int i = 0; i < 3; ++i) result.weight[i] = face.weight[i][0];
	}
	else
		closestOnTetrahedron(corner, result);
}
