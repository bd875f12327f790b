// SPDX-License-Identifier: GPL-3.0-or-later
// How much area a body touches a plane with when it is pressed to the depth delta at one place: the slab flood fill.
#pragma once
#include "builder/assemble/Draft.h"
#include "builder/assemble/TriangleTree.h"

namespace clod::builder
{
class ContactArea
{
public:
	// delta: contact tolerance; areas count within `cap` of the start.
	ContactArea(const Mesh& mesh, double delta, double cap);
	// Sum over the faces connected to `start` within the slab |(x - origin) . normal| <= delta of their area projected
	// along normal; at least (2 delta)^2.
	double at(std::uint32_t start, const Vec3& origin, const Vec3& normal) const;

private:
	// Some connected faces, met as one where all of them are in reach.
	struct Cluster
	{
		std::vector<Vec3> vertices;
		std::vector<std::uint32_t> faces;
		std::vector<std::uint32_t> border;  // faces of other clusters next to it
		Vec3 area;                          // sum over the faces
		Vec3 axis;                          // every normal is within a cone round it
		double coneCosine = 1, coneSine = 0;
	};
	struct Region;
	void cluster(std::uint32_t seed);
	bool isInRegion(const Cluster& cluster, const Vec3& origin, const Region& region) const;
	double areaOf(std::uint32_t face, const Vec3& origin, const Region& region) const;

	const Mesh& m_mesh;
	double m_delta, m_cap;
	std::vector<std::array<std::uint32_t, 3>> m_neighbours;
	std::vector<Vec3> m_areas, m_normals;  // of each face: half the cross product of two edges; that of unit length
	std::vector<Cluster> m_clusters;
	std::vector<std::uint32_t> m_clusterOf;  // of each face
};

// D of every contact node above level 0 from its leaves': 1 / D is the root mean square of theirs, weighted by surface.
// Then raised where a parent has more, so that D never rises towards the root. The first `levels` levels are contact
// levels; those of level 0 are set.
void averageContactAreas(HierarchyDraft& draft, std::size_t levels);
}  // namespace clod::builder
