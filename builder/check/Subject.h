// SPDX-License-Identifier: GPL-3.0-or-later
// The hierarchy under examination with what every check needs, and the tally of one invariant.
#pragma once
#include <mutex>
#include <string>
#include <vector>

#include "builder/check/Check.h"
#include "builder/check/Geometry.h"

namespace clod::check
{
// Collects one invariant from several threads; the first violation is the one of the lowest element.
class Tally
{
public:
	explicit Tally(std::string name) { m_invariant.name = std::move(name); }
	// `excess` > 0: how far the promise is exceeded.
	void add(std::uint64_t element, double excess, const std::string& what);
	void hold(std::uint64_t count = 1);
	void undecided();
	Invariant result() const { return m_invariant; }

private:
	std::mutex m_mutex;
	Invariant m_invariant;
	std::uint64_t m_firstElement = ~std::uint64_t(0);
};

struct Subject
{
	Subject(const Hierarchy& hierarchy, const Options& options);
	const Hierarchy& h;
	const Options& options;
	double radius;
	double slack;                                     // rounding of this code's own arithmetic
	std::vector<std::vector<std::uint32_t>> parents;  // of each node, primary and shared
	std::vector<std::uint32_t> primaryParent;         // kNone for the root
	std::vector<std::uint32_t> ownerOfFace;           // node of each face
	Triangle triangle(std::uint32_t face) const;
	std::vector<Triangle> levelTriangles(const Level& level) const;
	std::vector<Vec3> thickHull(std::uint32_t node) const;  // vertices, then the same moved by the thickness
	Vec3 sweep(const Node& n) const;
	bool isContact(std::uint32_t node) const { return (h.node(node).flags & kClodNode) != 0; }
	// Calls work(i) for all i < count on all threads and reports progress under this name.
	void forEach(const std::string& name, std::size_t count, const std::function<void(std::size_t)>& work) const;
};

// The invariants, in the order they are run. Each returns one or more tallies.
using Invariants = std::vector<Invariant>;
Invariants checkGraph(const Subject& subject);         // tree, levels, monotone numbers, maxima
Invariants checkSurfaces(const Subject& subject);      // closed manifold levels, connected patches, face records
Invariants checkAsset(const Subject& subject);         // bounds, mass properties
Invariants checkGiven(const Subject& subject);         // level 0 against the mesh
Invariants checkLocalNumbers(const Subject& subject);  // mean normals, cones, curvature, contact areas
Invariants checkWalls(const Subject& subject);         // thicknesses against the walls, flat hulls
Invariants checkConvexity(const Subject& subject);     // edges, G1, G2
Invariants checkCulling(const Subject& subject);       // culling boxes and Hausdorff distances down the primary tree
Invariants checkDeviation(const Subject& subject);     // surf, protrude, thickness
Invariants checkCoverage(const Subject& subject);      // chains of cover, reach and culling boxes
}  // namespace clod::check
