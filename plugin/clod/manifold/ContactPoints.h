// SPDX-License-Identifier: Zlib
// The contact points of a pair of bodies, and what they are made for: the motion of a step, and the points of the step
// before, which they continue. Knows no engine.
//
// Frames and signs: everything in body A's frame; normals point from B to A; heights are signed, negative is
// penetration. Unit: the hierarchies' own.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "clod/Export.h"
#include "clod/collide/RelativeMotion.h"
#include "clod/collide/Vector.h"
#include "clod/hierarchy/Layout.h"

namespace clod
{
// Where B has no hierarchy nodeB is the part and faceB the index its owner gave.
struct ContactPoint
{
	Vec3 pointOnA, pointOnB;  // on the surfaces, those of round bodies: apart along the normal
	Vec3 normal;              // unit, from B to A
	double height = 0;        // signed distance of the surfaces grown by the margin; negative is penetration
	double bend = 0;  // height at the end of the step, less what the first order of the motion makes of this one
	double slowOverlap = 0;  // the part of a penetration that came with a change of level: it is left at switchSpeed()
	double idle = 0;         // seconds since it carried last, of a point that goes on
	std::uint64_t feature = 0;  // the two features that make it, hashed
	bool goesOn = false;   // its level is no longer asked for: it lets the bodies down at switchSpeed()
	bool rebounds = true;  // false: as far as this pair knows no surface is met there, so nothing may bounce
	std::uint32_t nodeA = 0, nodeB = 0;
	std::uint32_t faceA = kNone, faceB = kNone;  // global face indices; kNone where there is none (a plane)
};

// A body as a solver sees it: in frame A at its present pose, in the hierarchies' unit.
struct PairBody
{
	double inverseMass = 0;  // 0: contacts do not move it
	Mat3 inverseInertia = {{{}, {}, {}}};
	Vec3 center;           // of mass
	Vec3 linear, angular;  // velocity as the solver starts from it: forces of the coming step included
	Vec3 force;            // what they add to the linear velocity
	bool isPoint = false;  // its centre, grown by a radius: as it turns, nothing of it moves
	Vec3 turning() const { return isPoint ? Vec3{} : angular; }
	// Of its material at a place.
	Vec3 velocityAt(const Vec3& place) const { return linear + cross(turning(), place - center); }
};
inline PairBody withoutForces(PairBody body)
{
	body.linear -= body.force;
	return body;
}
// Of A's geometry relative to B's.
inline RelativeMotion motionBetween(const PairBody& a, const PairBody& b, double timeStep)
{
	const Vec3 turnA = a.turning(), turnB = b.turning();
	return {a.linear - cross(turnA, a.center) - b.linear + cross(turnB, b.center), turnA - turnB, timeStep};
}

// The pose of B in A's frame once both have moved for `time`; the frame moves with A.
Transform aFromBAfter(const PairBody& a, const PairBody& b, const Transform& aFromB, double timeStep);

inline constexpr double kHolds = 0.25;  // sine of the least slope that may hold a body against a force

struct PointRules
{
	double length = 1;   // the smaller bounding radius of the pair: tolerances are shares of it
	double resting = 0;  // points up to this height are contacts whatever the motion
	double margin = 0;   // surfaces touch at this height: both radii, and the skin that bodies shall stay apart
	double radiusA = 0, radiusB = 0;  // bodies are grown by these, which rounds their corners and edges
	bool nearest = false;  // the nearest points are wanted although the bodies are apart, between corners and edges, too
	PairBody a, b;
	double friction = 0;  // Coulomb's coefficient
	double timeStep = 0;  // seconds; 0: nothing is looked ahead for
	// How far contacts are looked for on the way of one body alone, in case a third body holds the other still: the
	// bodies of a stack that falls do not approach each other until the lowest meets the floor.
	double heldReach = 0;
	// How far off its way third bodies that close in on it may carry one of the two in the step.
	double shove = 0;
	// One of the two lies on the other, which does not move, and carries nothing else. Few points are enough for it, as
	// a solver takes the longer the more rows it has; a body that carries others gets more.
	bool liesAlone = false;
	// Contacts are found once in a step, not again as other bodies lead them: of many, what these soon lead to comes first.
	bool foundOnce = true;
	RelativeMotion motion() const { return motionBetween(a, b, timeStep); }
	// May a facet with this normal hold the bodies against the forces on them? A steeper one is a wall.
	bool holds(const Vec3& normal) const
	{
		const Vec3 pull = a.force - b.force;
		return dot(pull, normal) < -kHolds * clod::length(pull);
	}
};

inline constexpr double kRestingShare = 0.001;  // default resting height, share of PointRules::length
// Bodies of a simulation rest this share of the length apart (the skin), so that full meshes do not intersect: a step
// over a curved surface overshoots by about as much (0.03 mm in the spoon-cup scene at 0.1 m/s). An adapter adds it to
// the margins.
inline constexpr double kSkinShare = 0.0005;
// Contacts are looked for this many times the displacement of the step ahead, as they may turn the motion.
inline constexpr double kPathReach = 1.35;

// Where at most so many pairs of nodes are near, contacts are looked for farther from the predicted way. It costs
// little there, and helps most: if a third body or another contact turns the motion, nothing else holds the bodies
// apart.
inline constexpr std::size_t kFewPairs = 8;

inline constexpr double kHeldShare = 0.1;  // of the length: the most that PointRules::heldReach and shove are

// Points go to a solver in groups of a manifold's size.
inline constexpr int kMaxClusters = 32;
inline constexpr int kClusterPoints = 4;

struct HeldPoint
{
	ContactPoint point;
	std::uint32_t previous = kNone;  // cluster * kClusterPoints + index in the previous set; kNone = a new point
	double impulse = 0;              // set by the owner before the next reduction: strong points are remembered first
};
struct ContactCluster
{
	int count = 0;  // 0: the slot is free
	std::array<HeldPoint, kClusterPoints> points{};
};

// Up to the last one that was asked for, to write it: most pairs have few of them.
class ClusterSlots
{
public:
	ContactCluster& operator[](std::size_t i)
	{
		for (; m_size <= i; ++m_size) m_all[m_size].count = 0;
		return m_all[i];
	}
	const ContactCluster& operator[](std::size_t i) const { return m_all[i]; }
	std::size_t size() const { return m_size; }
	const ContactCluster* begin() const { return m_all.data(); }
	const ContactCluster* end() const { return m_all.data() + m_size; }
	void clear() { m_size = 0; }

private:
	std::size_t m_size = 0;
	std::array<ContactCluster, kMaxClusters> m_all{};
};

// A point that goes on keeps its slot, so that one slot can be one manifold.
struct CLOD_API ClusterSet
{
	ClusterSlots slots;
	// Of a set of the last step, frame A: how B's material has moved since. A corner of B that slides over A is the
	// same point although it moves in A's frame.
	Transform motionOfB;
	int pointCount() const;
};

// What a pair keeps of a set: its points, one cluster after the other, and no room for more.
class CLOD_API HeldClusters
{
public:
	bool isEmpty() const { return m_points.empty(); }
	const std::vector<HeldPoint>& points() const { return m_points; }
	std::size_t slots() const { return m_slots; }  // up to the last that has a point
	std::uint32_t count(std::size_t slot) const { return slot < m_slots ? m_counts[slot] : 0; }
	HeldPoint& at(std::size_t slot, std::size_t i) { return m_points[firstOf(slot) + i]; }
	void hold(const ClusterSet& set);
	void copyTo(ClusterSet& set) const;
	// Every point continues the one in its place.
	void linkToThemselves();

private:
	std::size_t firstOf(std::size_t slot) const;
	std::vector<HeldPoint> m_points;
	std::size_t m_slots = 0;
	std::array<std::uint8_t, kMaxClusters> m_counts{};
};
}  // namespace clod
