// SPDX-License-Identifier: Zlib
// Finds the facets (Facet.h) of pairs of nodes within reach.
//
// A facet is near when it is within the resting height now (vertex locally lowest, edges' arcs crossing, foot on the
// facet), on the way when the chord of the coming step meets it, and overlapping when its distance is negative.
#pragma once
#include <cstdint>
#include <vector>

#include "clod/manifold/Facet.h"
#include "clod/query/Query.h"

namespace clod
{
// Holds buffers only.
class FacetFinder
{
public:
	// Appends the facets of node pairs within reach. Each comes once.
	void find(const FacetQuestion& question, const std::vector<Contact>& contacts, std::vector<Facet>& facets);

private:
	struct MovedVertex
	{
		Vec3 now, then;
		std::uint32_t index;
	};
	struct MovedEdge
	{
		Vec3 start, direction, thenStart, thenDirection, low, high;
		std::uint32_t index;
	};
	struct Pair
	{
		const ContactSurface *a, *b;
		std::uint32_t nodeA, nodeB, levelA, levelB;
		double roam;     // half of what the step's motion displaces at most: so far from its middle contacts may lead
		double deepest;  // overlaps beyond are not looked for
		double beneath;  // how far beneath their faces what is inside may be
	};
	void findPair(const Contact& contact);
	void gather(const Contact& contact);
	double highest(double closing) const;
	void verticesOverFaces(bool vertexIsOfA);
	void vertexOverFace(const MovedVertex& vertex, std::uint32_t face, bool vertexIsOfA);
	void edgesOverEdges();
	void edgeOverEdge(const SurfaceEdge& edge, const MovedEdge& moved);
	std::size_t slotOf(const Facet& facet) const;
	void add(Facet& facet);

	const FacetQuestion* m_question = nullptr;
	std::vector<Facet>* m_facets = nullptr;
	Transform m_bFromA, m_bFromAThen;
	RelativeMotion m_motion;  // of A's material relative to B's
	double m_turn = 0;  // of B relative to A in the step
	Pair m_pair{};
	std::vector<MovedVertex> m_verticesA, m_verticesB;  // in the other's frame
	std::vector<std::uint32_t> m_facesA, m_facesB, m_edgesA;
	std::vector<MovedEdge> m_edgesB;
	std::vector<std::uint32_t> m_table;  // of the facets, by what makes them; open, a power of two
};
}  // namespace clod
