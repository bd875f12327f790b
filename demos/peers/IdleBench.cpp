// SPDX-License-Identifier: Zlib
// Poses at which nothing happens, and what dispatches cost there.
#include "demos/peers/IdleBench.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "demos/runner/InputSurface.h"
#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
constexpr int kSettling = 16;                         // dispatches at a new pose before those measured
constexpr double kStepShare = 0.0005;                 // of the radius: motion between two dispatches
constexpr int kStride = 8;                            // steps out, then as many back
constexpr double kHullGapShare = 0.1;                 // of the radius; Bullet keeps points up to some 2 % apart
constexpr double kFirstShift = 0.02, kLastShift = 2;  // of the radius

bool touches(const Hierarchy& a, const Hierarchy& b, const PoseRow& poses, double tolerance,
			 const ContactMetric& metric, PairCache& cache)
{
	ReplayOptions options;
	options.metric = metric;
	options.tolerance.value = tolerance;
	const GapSettings settings = settingsOf(options, a, b, poses, {});
	ContactResult result;
	contacts(a, b, relativePose(poses, meshFromBody(a), meshFromBody(b)), settings, cache, result);
	return !result.contacts.empty();
}

struct Box
{
	Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
};
Box boxOf(const ModelMesh& mesh, const Pose& pose)
{
	const Transform worldFromMesh = toTransform(pose);
	Box box;
	for (const Vec3& vertex : mesh.vertices)
	{
		const Vec3 v = worldFromMesh * vertex;
		for (int i = 0; i < 3; ++i)
		{
			box.low[i] = std::min(box.low[i], v[i]);
			box.high[i] = std::max(box.high[i], v[i]);
		}
	}
	return box;
}
bool overlap(const Box& l, const Box& r)
{
	for (int i = 0; i < 3; ++i)
		if (l.low[i] > r.high[i] || r.low[i] > l.high[i]) return false;
	return true;
}

Pose moved(Pose pose, const Vec3& by)
{
	pose.position += by;
	return pose;
}

class PoseFinder
{
public:
	PoseFinder(const HierarchyPointer& a, const HierarchyPointer& b, double tolerance,
			   const std::vector<Threshold>& thresholds)
		: m_a(*a),
		  m_b(*b),
		  m_meshA(inputSurface(*a)),
		  m_meshB(inputSurface(*b)),
		  m_tolerance(tolerance),
		  m_thresholds(thresholds)
	{
		m_radius = smallerRadius(*a, *b);
	}
	std::vector<PoseRow> touching(const std::vector<PoseRow>& poses, int count) const
	{
		std::vector<PoseRow> all, found;
		PairCache cache;
		for (const PoseRow& row : poses)
			if (touches(m_a, m_b, row, m_tolerance, ContactMetric::exactly(), cache)) all.push_back(row);
		const std::size_t wanted = std::min(all.size(), std::size_t(count));
		for (std::size_t k = 0; k < wanted; ++k) found.push_back(all[(2 * k + 1) * all.size() / (2 * wanted)]);
		return found;
	}
	// B moved from each, along an axis or diagonal of the world, until no threshold finds anything near; rows from
	// which the boxes come apart first are dropped.
	std::vector<PoseRow> apart(const std::vector<PoseRow>& touching) const
	{
		std::vector<PoseRow> found;
		for (const PoseRow& row : touching)
			if (PoseRow away = row; clear(away)) found.push_back(away);
		return found;
	}
	// Steps out and back, so that no dispatch sees the transform of the one before.
	double step() const { return kStepShare * m_radius; }

private:
	bool clear(PoseRow& row) const
	{
		const double room = m_tolerance + 2 * kStride * step();
		const Box boxA = boxOf(m_meshA, row.a), boxB = boxOf(m_meshB, row.b);
		for (double share = kFirstShift; share <= kLastShift; share *= 2)
			for (int code = 0; code < 27; ++code)
			{
				const Vec3 direction{double(code % 3 - 1), double(code / 3 % 3 - 1), double(code / 9 - 1)};
				const Vec3 shift = (share * m_radius) * direction;
				PoseRow away = row;
				away.b = moved(row.b, shift);
				if (!overlap(boxA, {boxB.low + shift, boxB.high + shift})) continue;
				const auto isNear = [&](const Threshold& threshold)
				{
					PairCache cache;
					return touches(m_a, m_b, away, room, threshold.metric, cache);
				};
				if (std::any_of(m_thresholds.begin(), m_thresholds.end(), isNear)) continue;
				row = away;
				return true;
			}
		return false;
	}
	const Hierarchy &m_a, &m_b;
	ModelMesh m_meshA, m_meshB;
	double m_tolerance, m_radius;
	const std::vector<Threshold>& m_thresholds;
};

// The poses of one state as rows of one pass.
PoseSample sampleOf(const std::vector<PoseRow>& poses, IdleState state, double step, double tolerance, int dispatches)
{
	PoseSample sample;
	sample.tolerance = tolerance;
	for (const PoseRow& row : poses)
		for (int i = 0; i < kSettling + dispatches; ++i)
		{
			PoseSample::Row next{row, row, sample.dt, i >= kSettling};
			const int phase = i % (2 * kStride), steps = phase < kStride ? phase : 2 * kStride - phase;
			if (state == IdleState::apartMoving) next.poses.b = moved(row.b, {0, steps * step, 0});
			next.before = i > 0 ? sample.rows.back().poses : next.poses;
			sample.rows.push_back(next);
		}
	return sample;
}

IdleRow measure(Peer& peer, const PoseSample& sample, IdleState state, int dispatches)
{
	IdleRow row;
	row.state = state;
	row.who = peer.info().setting;
	const std::vector<PeerAnswer> answers = peer.pass(sample);
	std::vector<double> times;
	for (const PeerAnswer& answer : answers)
	{
		row.points += double(answer.contacts.size()) / double(answers.size());
		times.push_back(answer.microseconds);
		if (times.size() < std::size_t(dispatches)) continue;
		row.microseconds.push_back(quantile(times, 0.5));
		row.means.push_back(std::accumulate(times.begin(), times.end(), 0.0) / double(times.size()));
		times.clear();
	}
	return row;
}

// Points spread evenly over a sphere (Fibonacci's spiral).
ModelMesh roundHull(double radius)
{
	const double golden = kPi * (3 - std::sqrt(5.0));
	ModelMesh mesh;
	for (int i = 0; i < kIdleHullVertices; ++i)
	{
		const double z = 1 - (2 * i + 1.0) / kIdleHullVertices, r = std::sqrt(1 - z * z);
		mesh.vertices.push_back(radius * Vec3{r * std::cos(golden * i), r * std::sin(golden * i), z});
	}
	return mesh;
}

ModelMesh mirrored(ModelMesh mesh)
{
	for (Vec3& vertex : mesh.vertices) vertex = -vertex;
	return mesh;
}

// Two hulls, each the mirror image of the other, vertex to vertex at this gap. Along the vertex nearest to a diagonal,
// so that the boxes overlap.
PoseRow hullPoses(const ModelMesh& hull, double gap)
{
	const auto diagonal = [](const Vec3& v) { return v.x + v.y + v.z; };
	const Vec3 farthest = *std::max_element(hull.vertices.begin(), hull.vertices.end(),
											[&](const Vec3& l, const Vec3& r) { return diagonal(l) < diagonal(r); });
	PoseRow row;
	row.b.position = (2 + gap / length(farthest)) * farthest;
	return row;
}
}  // namespace

const char* name(IdleState state)
{
	constexpr const char* names[] = {"apart, moving", "apart, unchanged", "touching, unchanged"};
	return names[std::size_t(state)];
}

std::vector<IdleRow> measureIdle(const HierarchyPointer& a, const HierarchyPointer& b,
								 const std::vector<PoseRow>& poses, const std::vector<Threshold>& thresholds,
								 const PairFrame& frame, const IdleOptions& options)
{
	const PoseFinder finder(a, b, frame.tolerance, thresholds);
	const std::vector<PoseRow> touching = finder.touching(poses, options.poses), apart = finder.apart(touching);
	const ModelMesh hull = roundHull(smallerRadius(*a, *b));
	PairFrame hullFrame = frame;
	hullFrame.originA = hullFrame.originB = Vec3{};
	std::vector<IdleRow> rows;
	for (const IdleState state : {IdleState::apartMoving, IdleState::apartUnchanged, IdleState::touchingUnchanged})
	{
		const bool isTouching = state == IdleState::touchingUnchanged;
		const std::vector<PoseRow>& ours = isTouching ? touching : apart;
		if (ours.empty()) continue;
		const auto at = [&](const std::vector<PoseRow>& where)
		{ return sampleOf(where, state, finder.step(), frame.tolerance, options.dispatches); };
		for (const Threshold& threshold : thresholds)
		{
			PeerInfo info;
			info.setting = threshold.label;
			rows.push_back(measure(*clodDispatch(info, a, b, threshold, frame), at(ours), state, options.dispatches));
		}
		PeerInfo info;
		info.setting = "two hulls of " + std::to_string(kIdleHullVertices) + " vertices";
		const double gap = isTouching ? frame.tolerance / 2 : kHullGapShare * smallerRadius(*a, *b);
		const PoseRow where = hullPoses(hull, gap);
		rows.push_back(measure(*convexHulls(info, hull, mirrored(hull), hullFrame),
							   at(std::vector<PoseRow>(ours.size(), where)), state, options.dispatches));
	}
	return rows;
}
}  // namespace clod::demo
