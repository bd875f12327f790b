// SPDX-License-Identifier: Zlib
// The corners, edges and polygons of a node, each with a box round its way through the coming step; and, of those that
// are asked for, where they are and where the step carries them. A node is near many others, so what is computed for
// it is kept for the whole dispatch.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "clod/manifold/Facet.h"
#include "clod/query/Query.h"

namespace clod
{
// To a box, if there is one: along the axes, and in a straight line. What is in it may be deep inside a node and far
// from its faces. Faces alone meet nothing but corners.
class Near
{
public:
	Near() = default;
	Near(const Box& box, double reach, double straight, bool mayBeInside, bool ofCornersOnly)
		: m_box(&box),
		  m_straight(straight),
		  m_mayBeInside(mayBeInside),
		  m_ofCornersOnly(ofCornersOnly),
		  m_grown{box.low - Vec3{reach, reach, reach}, box.high + Vec3{reach, reach, reach}}
	{
	}
	bool mayBeInside() const { return m_mayBeInside; }
	bool isOfCornersOnly() const { return m_ofCornersOnly; }
	bool holds(const Box& other) const
	{
		if (m_box == nullptr) return true;
		return other.meets(m_grown) && (std::isinf(m_straight) || other.squaredTo(*m_box) <= m_straight * m_straight);
	}

private:
	const Box* m_box = nullptr;
	double m_straight = 0;
	bool m_mayBeInside = false, m_ofCornersOnly = false;
	Box m_grown{};
};

// Boxes are in frame A, over the step as far ahead as contacts are looked for (kPathReach).
struct MovedFeature
{
	Box box;  // of a polygon, of what the node has of it
	std::uint32_t index;
	std::uint32_t number;  // see FeatureNumbers
};
struct MovedCorner : MovedFeature
{
	bool isPlaced = false;
	Vec3 now{}, then{}, unforced{};  // in the other body's frame, if placed; see FacetQuestion
};
struct MovedEdge : MovedFeature
{
	bool isPlaced = false;
	// In frame A, if placed; not of A's, which stand still.
	Vec3 start{}, direction{}, thenStart{}, thenDirection{}, unforcedStart{};
	std::array<Vec3, 2> inward{};
};
struct MovedPolygon : MovedFeature
{
	Vec3 up;  // its normal, in the other body's frame
};
struct MovedNode
{
	std::uint32_t node = kNone, level = 0;
	std::uint32_t place = 0;  // among the nodes of its body that the dispatch looks at
	double displaced = 0;  // the farthest that one of its points goes in the step, as predicted; of B's
	Box box;  // of A's, of what is listed, or of all of the node if the other may be inside it
	std::vector<MovedCorner> corners;
	std::vector<MovedEdge> edges;
	std::vector<MovedPolygon> polygons;
};

// A corner or an edge has one number in a dispatch, in whichever node it is met: neighbours share their borders, and
// what one of them was asked need not be asked of the other. So that it costs next to nothing this is a table without
// search: what finds its place taken by another feature goes on under several numbers. Polygons have one in each node.
class FeatureNumbers
{
public:
	void start();
	std::uint32_t next() { return m_count++; }
	std::uint32_t of(std::uint32_t level, bool isEdge, std::uint32_t index);

private:
	struct Entry
	{
		std::uint64_t feature;
		std::uint32_t dispatch = 0, number;
	};
	std::vector<Entry> m_entries;
	std::uint32_t m_dispatch = 0, m_count = 0;
};

// The nodes of one body that a dispatch looks at.
class MovedNodes
{
public:
	// The nodes on side A or B of the contacts.
	void start(const FacetQuestion& question, const std::vector<Contact>& contacts, bool isA);
	// Is there one alone?
	bool isOne() const { return m_nodes.size() == 1; }
	// Precondition: one of them. What of A comes nowhere so near is left out. Of B's one node no features, see listNear().
	MovedNode& of(std::uint32_t node, const Near& near = {});
	// Lists of B's one node, which was asked for last, what meets that box.
	void listNear(MovedNode& moved, const Box& places);
	// Nodes are told apart 64 at a time, in order; here as bits of those round one of them. Those met so far that have
	// the corner or edge of this number,
	std::uint64_t sharing(std::uint32_t number, std::uint32_t place) const
	{
		return m_blocks == 0 ? 0 : m_sharing[std::size_t(number) * m_blocks + place / 64];
	}
	// or of which a point goes at least so far.
	std::uint64_t displaced(double least, std::uint32_t place);
	std::uint32_t blocks() const { return m_blocks; }
	// Notes that this feature is near a node of the other body, which has so many blocks. Returns those noted before.
	std::uint64_t noteNear(std::uint32_t number, std::uint32_t otherBlocks, std::uint32_t otherPlace);
	// Precondition: of such a node, on `surface`; an edge of B's.
	void place(const ContactSurface& surface, MovedCorner& corner) const;
	void place(const ContactSurface& surface, MovedEdge& edge) const;

private:
	MovedCorner placed(const ContactSurface& surface, std::uint32_t vertex) const;
	Vec3 upOf(const ContactSurface& surface, std::uint32_t polygon) const;
	std::uint32_t numberOf(const MovedNode& moved, bool isEdge, std::uint32_t index);
	void listStill(MovedNode& moved, const ContactSurface& surface, const Near& near);
	void move(MovedNode& moved, const ContactSurface& surface);
	void listMoved(MovedNode& moved, const ContactSurface& surface, const Box& places);

	const FacetQuestion* m_question = nullptr;
	bool m_isA = false;
	Transform m_otherFromThis, m_otherFromThisThen, m_otherFromThisUnforced;
	std::vector<std::uint32_t> m_nodes;  // sorted, each once
	std::vector<MovedNode> m_moved;      // as many, or more; buffers are kept
	std::vector<MovedCorner> m_corners;  // of a node: all vertices, placed,
	std::vector<std::uint8_t> m_beyond;  // and the sides of the box looked at that each is beyond
	FeatureNumbers m_numbers;
	std::vector<std::uint64_t> m_sharing, m_near;
	struct Wide
	{
		double least = 0;         // displaced() was asked last of this,
		std::uint64_t nodes = 0;  // as bits
	};
	std::vector<Wide> m_wide;    // of 64 nodes each
	std::uint32_t m_blocks = 0;  // of 64 nodes, as many as hold all; 0: too many, none are told apart
};
}  // namespace clod
