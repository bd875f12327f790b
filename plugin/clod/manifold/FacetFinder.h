// SPDX-License-Identifier: Zlib
// Finds the facets (Facet.h) of pairs of nodes within reach, and why each counts (FacetRecord::Reach). Facets of
// vertices over edges and vertices are looked for where a body is round; they never overlap.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "clod/manifold/MovedNode.h"

namespace clod
{
// Holds buffers only.
class FacetFinder
{
public:
	// Appends the facets of node pairs within reach. Each comes once; those that are there stay.
	void find(const FacetQuestion& question, const std::vector<Contact>& contacts, std::vector<Facet>& facets);
	// Up to this distance from the predicted way all facets were looked for. Infinity, unless both bodies are detailed
	// and move so fast that looking for all would cost too much (kRoamGrains).
	double sought() const { return m_sought; }

private:
	struct Pair
	{
		const ContactSurface *a, *b;
		MovedNode *movedA, *movedB;
		bool mayOverlap;
		double roam = 0;     // how far off the middle of the predicted way facets are looked for
		double deepest = 0;  // overlaps beyond are not looked for
		double reach = 0;    // how far apart features may be
	};
	struct Through
	{
		bool isOfB;
		SurfaceFace face;
	};
	void noteThrough();
	bool mayEnter(const ContactSurface& surface, const MovedCorner& vertex, const Vec3& up, const SurfaceFace& face,
				  bool faceIsOfB) const;
	// FacetPairs.cpp
	double borderApart(const std::vector<Contact>& contacts);
	double depthOf(const Contact& contact, const ContactSurface& b) const;
	Pair pairOf(const Contact& contact);
	Box placesNearA() const;
	void findPair(const Pair& pair);
	void gather(MovedNode& nodeA, MovedNode& nodeB, bool mayOverlap);
	// Calls each(of one body, of the other) for what was not asked yet in another pair of nodes that share the two.
	template <class One, class Other, class Each>
	static void forEachNew(const One& ofOne, const Other& ofOther, const Each& each)
	{
		for (const auto& one : ofOne)
			for (const auto& other : ofOther)
				if ((one.nodes & other.nodes) == 0) each(*one, *other);
	}
	void verticesOverFaces();
	void edgesOverEdges(bool mayOverlap);
	// FacetFinder.cpp
	double highest(double closing) const;
	Transform poseAt(double share);
	struct Features;
	struct VertexOverFace;
	struct EdgeOverEdge;
	template <class Kind>
	class Meeting;
	double endOf(double now, double then) const;
	bool isInReach(double now, double then) const;
	double mostBeside(const MovedCorner& vertex, double now) const;
	void vertexOverFace(const MovedCorner& vertex, const MovedPolygon& moved, bool vertexIsOfA);
	void edgeOverEdge(const MovedEdge& still, const MovedEdge& moved);
	// RoundFacets.cpp, frame A.
	struct Approach
	{
		Facet::Reach reach;
		double share;  // of the way ahead, where it counts
		Vec3 between;  // there
	};
	std::optional<Approach> approach(const Vec3& now, const Vec3& then, const Vec3& unforced) const;
	void bend(const FacetRecord& facet, const Vec3& now, const Vec3& forced, Approach& met);
	void findRound();
	void vertexOverEdge(const MovedCorner& vertex, const MovedEdge& moved, bool vertexIsOfA);
	void vertexOverVertex(const MovedCorner& ofA, const MovedCorner& ofB);
	// MiddleFacets.cpp
	struct Middle
	{
		double height = 0;  // the least height of the body's hull about its middle; 0: not asked for
		double radius = 0;  // of a sphere about its middle that holds the body
		Vec3 own, now, then;    // in its own frame; the others in the other body's, see FacetQuestion
	};
	void placeMiddles();
	void middleOverFace(const Middle& middle, std::uint32_t polygon, bool middleIsOfA);
	Vec3 intoB(const Approach& met, const Vec3& direction);
	double coneSlack() const;
	bool isInCone(const ContactSurface& surface, const MovedCorner& vertex, const Vec3& away) const;
	void addRound(Facet& facet, const Approach& approach, const Vec3& now, const Vec3& then, const Vec3& normal,
				  const Vec3& place);
	std::size_t slotOf(std::uint64_t feature) const;
	void add(Facet& facet);
	void tabulate(std::size_t size);

	static constexpr int kArcParts = 8;  // a power of two: arcs are looked at there first

	const FacetQuestion* m_question = nullptr;
	std::vector<Facet>* m_facets = nullptr;
	Transform m_bFromA;
	RelativeMotion m_motion;  // of A's material relative to B's
	double m_sagitta = 0;     // of the arc of a point's way over its chord, as a share of the chord
	double m_bend = 0;        // the same of a way in frame A, which turns itself, at most
	double m_turn = 0;  // radians: the most that contacts may turn B relative to A in the step
	std::array<std::optional<Transform>, kArcParts + 1> m_poses;
	Middle m_middleA, m_middleB;
	std::vector<Through> m_through;
	double m_roamShare = 0;
	double m_sought = 0;
	double m_borderApart = 0;
	std::vector<Pair> m_pairs;
	Pair m_pair{};
	MovedNodes m_nodesA, m_nodesB;
	// The features of the pair's nodes that come near the other node.
	template <class Moved>
	struct Gathered
	{
		const Moved* feature;
		std::uint64_t nodes;  // 64 of the other body's or of its own, see gather()
		const Moved& operator*() const { return *feature; }
		const Moved* operator->() const { return feature; }
	};
	template <class Moved>
	using List = std::vector<Gathered<Moved>>;
	List<MovedCorner> m_cornersA, m_cornersB;
	List<MovedEdge> m_edgesA, m_edgesB;
	List<MovedPolygon> m_polygonsA, m_polygonsB;
	std::vector<std::uint32_t> m_table;  // open hash table of facets by their features; its size is a power of two
};
}  // namespace clod
