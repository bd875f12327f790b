// SPDX-License-Identifier: Zlib
// Our query as one of the methods, and as the measure of all of them.
#include "demos/peers/ClodPeer.h"

#include <algorithm>

#include "demos/runner/Replay.h"
#include "demos/scenes/Stopwatch.h"

namespace clod::demo
{
namespace
{
constexpr std::size_t kWarmRows = 2;  // recorded rows before each measured one that only warm caches and manifolds
constexpr double kDepthShare = 2e-5;  // of the radius: how exactly an overlap's depth is known

PeerContact contactOf(const Hierarchy& a, const Hierarchy& b, const Contact& contact)
{
	const Node &nodeA = a.node(contact.nodeA), &nodeB = b.node(contact.nodeB);
	const double cover = double(nodeA.cover) + double(nodeB.cover),
				 protrude = double(nodeA.protrude) + double(nodeB.protrude);
	return {meshFromBody(a) + 0.5 * (contact.pointOnA + contact.pointOnB), contact.normal, contact.upper,
			std::max(cover, protrude)};
}

// The smallest distance that a contact list tells: of none infinite, where hulls overlap not a number.
double nearestHulls(const std::vector<Contact>& contacts)
{
	double nearest = std::numeric_limits<double>::infinity();
	for (const Contact& contact : contacts) nearest = std::min(nearest, contact.upper);
	return nearest > 0 ? nearest : std::numeric_limits<double>::quiet_NaN();
}

class ClodQueryPeer : public Peer
{
public:
	ClodQueryPeer(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b, const Threshold& threshold,
				  ClodQuestion question)
		: Peer(std::move(info)), m_a(a), m_b(b), m_isOfContacts(question == ClodQuestion::contacts)
	{
		m_options.metric = threshold.metric;
		m_options.camera = threshold.camera;
		m_options.budget = threshold.budget;
		if (threshold.gapError < kOff) m_options.gapError = cli::Length{threshold.gapError, false, ""};
		m_info.bytes = a->bytes().size() + b->bytes().size();
		m_info.sizeA = a->asset().triangleCount;
		m_info.sizeB = b->asset().triangleCount;
	}
	std::vector<PeerAnswer> pass(const PoseSample& sample) override
	{
		std::vector<PeerAnswer> answers;
		m_options.tolerance.value = sample.tolerance;
		GapCache cache;
		GapResult result;
		for (const PoseSample::Row& row : sample.rows)
		{
			RelativeMotion motion = relativeMotion(*m_a, *m_b, row.before, row.poses, row.seconds);
			motion.timeStep = sample.dt;
			const GapSettings settings = settingsOf(m_options, *m_a, *m_b, row.poses, motion);
			const Transform aFromB = relativePose(row.poses, meshFromBody(*m_a), meshFromBody(*m_b));
			const Stopwatch watch(TimedBy::thread);
			if (m_isOfContacts)
				contacts(*m_a, *m_b, aFromB, settings, cache.pair, result);
			else
				signedGap(*m_a, *m_b, aFromB, settings, cache, result);
			const double time = watch.microseconds();
			if (!row.measured) continue;
			PeerAnswer answer;
			answer.microseconds = time;
			answer.gap = m_isOfContacts ? nearestHulls(result.contacts) : result.minDistance;
			for (const Contact& contact : result.contacts) answer.contacts.push_back(contactOf(*m_a, *m_b, contact));
			answers.push_back(std::move(answer));
		}
		return answers;
	}

private:
	HierarchyPointer m_a, m_b;
	bool m_isOfContacts;
	ReplayOptions m_options;
};

// Exact mode with the signed gap.
class ExactQuery
{
public:
	ExactQuery(const Hierarchy& a, const Hierarchy& b, double tolerance) : m_a(a), m_b(b)
	{
		m_settings.metric.exact = true;
		m_settings.metric.maxError = kDepthShare * smallerRadius(a, b);  // of a depth that is searched
		m_settings.tolerance = tolerance;
	}
	ExactRow at(const PoseRow& poses)
	{
		signedGap(m_a, m_b, relativePose(poses, meshFromBody(m_a), meshFromBody(m_b)), m_settings, m_cache, m_result);
		ExactRow row;
		row.gap = m_result.minDistance;
		for (const Contact& contact : m_result.contacts) row.contacts.push_back(contactOf(m_a, m_b, contact));
		return row;
	}

private:
	const Hierarchy &m_a, &m_b;
	GapSettings m_settings;
	GapCache m_cache;
	GapResult m_result;
};

// Marks the rows to measure and the rows that warm up for them.
PoseSample sampleOf(const std::vector<PoseRow>& poses, const std::vector<std::size_t>& measured,
					const SampleRules& rules)
{
	std::vector<int> use(poses.size(), 0);
	for (const std::size_t i : measured)
	{
		for (std::size_t k = 1; k <= std::min(kWarmRows, i); ++k) use[i - k] = std::max(use[i - k], 1);
		use[i] = 2;
	}
	PoseSample sample;
	sample.dt = rules.clock.dt;
	sample.tolerance = rules.tolerance;
	for (std::size_t i = 0; i < poses.size(); ++i)
	{
		if (use[i] == 0) continue;
		sample.rows.push_back(recordedRow(poses, i, rules.clock));
		sample.rows.back().measured = use[i] == 2;
	}
	return sample;
}

// Every `stride`-th, or `mostRows` of them, evenly.
std::vector<std::size_t> chosenOf(const std::vector<std::size_t>& rows, const SampleRules& rules)
{
	const std::size_t count = rules.stride > 0
								  ? (rows.size() + std::size_t(rules.stride) - 1) / std::size_t(rules.stride)
								  : std::min(rows.size(), std::size_t(rules.mostRows));
	std::vector<std::size_t> chosen;
	for (std::size_t k = 0; k < count; ++k)
		chosen.push_back(rows[rules.stride > 0 ? k * std::size_t(rules.stride) : k * rows.size() / count]);
	return chosen;
}
}  // namespace

PeerPointer clodQuery(PeerInfo info, const HierarchyPointer& a, const HierarchyPointer& b, const Threshold& threshold,
					  ClodQuestion question)
{
	return std::make_unique<ClodQueryPeer>(std::move(info), a, b, threshold, question);
}

ExactSample takeSample(const HierarchyPointer& a, const HierarchyPointer& b, const std::vector<PoseRow>& poses,
					   const SampleRules& rules, const std::function<void(double)>& progress)
{
	const std::vector<double> speeds = relativeSpeeds(*a, *b, poses, rules.clock);
	ExactQuery near(*a, *b, rules.tolerance);
	std::vector<std::size_t> touching;
	for (std::size_t i = 0; i < poses.size(); ++i)
	{
		progress(double(i + 1) / double(poses.size()));
		if (!rules.resting && classify(speeds[i]) != Motion::moving) continue;
		if (near.at(poses[i]).gap <= rules.tolerance) touching.push_back(i);
	}
	const std::vector<std::size_t> measured = chosenOf(touching, rules);
	ExactQuery exact(*a, *b, kExactRange * rules.tolerance);
	ExactSample result;
	for (const std::size_t i : measured) result.exact.push_back(exact.at(poses[i]));
	result.sample = sampleOf(poses, measured, rules);
	return result;
}
}  // namespace clod::demo
