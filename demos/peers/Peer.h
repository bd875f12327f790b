// SPDX-License-Identifier: Zlib
// One way of answering "where do these two bodies touch?": ours at one threshold, or a peer's at one of its settings.
// All are asked at the same poses.
//
// Frame: that of mesh A (the file's vertices). Normals point from B to A, distances are negative inside. Unit: the
// meshes' own. Times are of the thread that asks (CLOCK_THREAD_CPUTIME_ID), so that a busy machine does not count.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "demos/runner/Replay.h"

namespace clod::demo
{
// What a time stands for: a query up to its contact list, or a whole collision dispatch of Bullet with manifolds.
enum class Timed
{
	query,
	dispatch
};
inline const char* name(Timed timed)
{
	return timed == Timed::query ? "query" : "dispatch";
}

struct PeerInfo
{
	std::string family;   // "clod", "gimpact", ...: points of one trade-off curve
	std::string setting;  // "exact", "64 hulls", "12.3 % x 8.1 %", ...
	Timed timed = Timed::query;
	std::size_t sizeA = 0, sizeB = 0;                                // triangles, or hulls of a convex decomposition
	double buildSeconds = std::numeric_limits<double>::quiet_NaN();  // both bodies; NaN: not known (cached)
	std::size_t bytes = 0;                                           // of what a query reads, both bodies
};

struct PeerContact
{
	Vec3 point;                                               // between the two surfaces
	Vec3 normal;                                              // zero where the method gives none
	double distance = 0;                                      // signed
	double bound = std::numeric_limits<double>::quiet_NaN();  // promised error of the distance; NaN: no promise
};

struct PeerAnswer
{
	double microseconds = 0;
	double bytes = std::numeric_limits<double>::quiet_NaN();  // that the pair holds after a dispatch, shapes not counted
	// Smallest distance reported; inf: nothing within the tolerance; NaN: in touch, the gap is left open.
	double gap = std::numeric_limits<double>::infinity();
	std::vector<PeerContact> contacts;
};

// Recorded rows in order. Rows that are not measured bring caches and manifolds into the state that a simulation would
// have them in.
struct PoseSample
{
	struct Row
	{
		PoseRow poses;
		PoseRow before;  // `seconds` ago: what velocities come from
		double seconds = 1;
		bool measured = true;
	};
	std::vector<Row> rows;
	double dt = 1.0 / 240;
	double tolerance = 0;  // contacts are asked for up to this distance
	bool isCold = false;   // every row is a new pair's first, with none of it in the processor's caches
	std::size_t measured() const;
	// The same poses, no body moving.
	PoseSample atRest() const;
	// The measured rows alone.
	PoseSample cold() const;
};
// One row as recorded: the bodies come from the row before it, the first from where they are.
PoseSample::Row recordedRow(const std::vector<PoseRow>& poses, std::size_t row, const RowClock& clock);

class Peer
{
public:
	explicit Peer(PeerInfo info) : m_info(std::move(info)) {}
	virtual ~Peer() = default;
	Peer(const Peer&) = delete;
	Peer& operator=(const Peer&) = delete;
	const PeerInfo& info() const { return m_info; }
	// One pass over all rows with fresh caches; an answer a measured row. Throws cli::Failure where it cannot answer.
	virtual std::vector<PeerAnswer> pass(const PoseSample& sample) = 0;

protected:
	PeerInfo m_info;
};
using PeerPointer = std::unique_ptr<Peer>;
}  // namespace clod::demo
