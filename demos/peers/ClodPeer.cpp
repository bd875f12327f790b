// SPDX-License-Identifier: Zlib
// Our query as one of the methods, and as the measure of all of them.
#include "demos/peers/ClodPeer.h"

#include <algorithm>

#include "demos/runner/Replay.h"

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
			const GapSettings settings = settingsOf(m_options, *m_a, *m_b, row.poses, {});
			const Transform aFromB = relativePose(row.poses, meshFromBody(*m_a), meshFromBody(*m_b));
			const double start = threadMicroseconds();
			if (m_isOfContacts)
				contacts(*m_a, *m_b, aFromB, settings, cache.pair, result);
			else
				signedGap(*m_a, *m_b, aFromB, settings, cache, result);
			const double time = threadMicroseconds() - start;
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
	sample.dt = rules.dt;
	sample.tolerance = rules.tolerance;
	for (std::size_t i = 0; i < poses.size(); ++i)
		if (use[i] > 0) sample.rows.push_back({poses[i], use[i] == 2});
	return sample;
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
	const std::vector<double> speeds = relativeSpeeds(*a, *b, poses, rules.dt);
	std::vector<std::size_t> candidates;
	for (std::size_t i = 0; i < poses.size(); ++i)
		if (rules.resting || classify(speeds[i]) == Motion::moving) candidates.push_back(i);
	const std::size_t stride =
		rules.stride > 0 ? std::size_t(rules.stride)
						 : (candidates.size() + std::size_t(rules.mostRows) - 1) / std::size_t(rules.mostRows);
	ExactQuery exact(*a, *b, kReach * rules.tolerance);
	ExactSample result;
	std::vector<std::size_t> measured;
	// Of every `stride` moving rows the first that touches.
	for (std::size_t k = 0; k < candidates.size();)
	{
		progress(double(k + 1) / double(candidates.size()));
		ExactRow row = exact.at(poses[candidates[k]]);
		const bool touches = row.gap <= rules.tolerance;
		if (touches)
		{
			measured.push_back(candidates[k]);
			result.exact.push_back(std::move(row));
		}
		k = touches ? (k / stride + 1) * stride : k + 1;
	}
	result.sample = sampleOf(poses, measured, rules);
	return result;
}
}  // namespace clod::demo
