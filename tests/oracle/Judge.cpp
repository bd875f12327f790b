// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Judge.h"

#include <algorithm>
#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;
// The largest way that a point of the body goes.
double sizeOf(const RelativeMotion& motion, const Solid& a)
{
	return motion.timeStep * (length(motion.velocity(a.center())) + length(motion.angular) * a.radius());
}

class Court
{
public:
	Court(const Solid& a, const Solid& b, const Case& which, const Answer& answer, double skin, const JudgeRules& rules,
		  Random& random)
		: m_a(a),
		  m_case(which),
		  m_rules(rules),
		  m_random(random),
		  m_radius(std::min(a.radius(), b.radius())),
		  m_skin(skin),
		  m_space(a, b, which.aFromB),
		  m_samples(sample()),
		  m_overlap(a, b, which.aFromB, m_reach)
	{
		const double dt = which.motion.timeStep;
		for (const Constraint& c : answer.constraints)
			m_set.push_back({dt * m_space.gradient(c.point, c.normal), c.distance + c.secondOrder});
		m_verdict.constraints = m_set.size();
		judgePose(answer);
	}

	Verdict run()
	{
		if (m_verdict.startDepth > m_rules.deep) return m_verdict;
		for (const Sample& sample : m_samples) tryOut(sample);
		for (const Kind kind : {Kind::near5, Kind::near30})
			tally(kind).bestHalfSpace +=
				bestHalfSpaceFaults(m_labels[std::size_t(kind)], m_rules.change, m_random);
		return m_verdict;
	}

private:
	struct Sample
	{
		Kind kind;
		Vec6 y;
		RelativeMotion motion;
	};
	std::vector<Sample> sample()
	{
		std::vector<Sample> samples;
		const Vec6 predicted = m_space.coordinates(m_case.motion);
		const double size = sizeOf(m_case.motion, m_a);
		if (size == 0) return samples;
		const auto add = [&](Kind kind, double angle, double scale)
		{
			const Vec6 y = withinCone(m_random, predicted, angle * kDegree, scale);
			samples.push_back({kind, y, m_space.motion(y, m_case.motion.timeStep)});
			m_reach = std::max(m_reach, sizeOf(samples.back().motion, m_a));
		};
		const double small = m_case.gap > 0 ? m_case.gap : m_rules.small * m_radius;
		for (int i = 0; i < m_rules.samples; ++i)
		{
			add(Kind::near5, 5, uniform(m_random, 0.7, 1.3));
			add(Kind::near30, 30, uniform(m_random, 0.7, 1.3));
			if (i % 2 == 0) add(Kind::small, 180, std::min(1.0, small * uniform(m_random, 0.5, 2) / size));
		}
		return samples;
	}
	Tally& tally(Kind kind) { return m_verdict.kinds[std::size_t(kind)]; }

	void judgePose(const Answer& answer)
	{
		m_verdict.isApart = m_overlap.isApart();
		if (!m_verdict.isApart) m_verdict.startDepth = m_overlap.depth({}) / m_radius;
		double deepest = 0;
		for (const Constraint& c : answer.constraints) deepest = std::max(deepest, -c.distance / m_radius);
		if (m_verdict.isApart)
			m_verdict.claim = deepest;
		else if (m_verdict.startDepth > m_rules.claim)
			m_verdict.isAnswered = deepest > 0.1 * m_rules.claim;
	}

	bool overlapsAtPose() const { return m_verdict.startDepth > m_rules.untouched; }

	// How deep the bodies get; stops at `enough`. Bodies that overlap at the pose are led out: until the end they may be
	// as deep as they are there, and what counts before is how much deeper they get.
	struct Depths
	{
		double atEnd = 0, before = 0;
		double deepest() const { return std::max(atEnd, before); }
	};
	Depths depthsOf(const RelativeMotion& motion, double enough)
	{
		const double size = sizeOf(motion, m_a);
		const double already = overlapsAtPose() ? m_verdict.startDepth * m_radius : 0;
		const int steps = std::clamp(int(std::ceil(size / (m_rules.pathStep * m_radius))), 3, 32);
		const auto depthAt = [&](double t) { return m_overlap.depth(displacement(motion, m_a.center(), t), t * size); };
		Depths depths;
		depths.atEnd = depthAt(1);
		for (int i = steps - 1; i > 0 && depths.deepest() <= enough; --i)
			depths.before = std::max(depths.before, depthAt(double(i) / steps) - already);
		return depths;
	}

	// What the turning of a body adds to its linear path.
	double secondOrder(const RelativeMotion& motion) const
	{
		return 0.5 * lengthSquared(motion.angular) * motion.timeStep * motion.timeStep * m_a.radius();
	}

	void tryOut(const Sample& sample)
	{
		const Kind kind = sample.kind;
		const Vec6& y = sample.y;
		const RelativeMotion& motion = sample.motion;
		Tally& sum = tally(kind);
		++sum.motions;
		const bool isAdmitted = admits(m_set, y, 1e-9 * m_radius);
		const double allowed = m_skin + secondOrder(motion);
		const double untouched = std::min(m_rules.untouched * m_radius, m_rules.untouchedShare * sizeOf(motion, m_a));
		const double enough = isAdmitted                                 ? 1e300
							  : kind == Kind::small && !overlapsAtPose() ? untouched
							                                             : allowed;
		const Depths depths = depthsOf(motion, enough);
		const double depth = depths.deepest();
		const bool isFree = depths.atEnd <= untouched && depths.before <= (overlapsAtPose() ? allowed : untouched);
		m_labels[std::size_t(kind)].push_back({y, isFree, depth > allowed});
		if (isFree)
		{
			const double change = isAdmitted ? 0 : changeOf(y, secondOrder(motion));
			++sum.free;
			sum.changes.push_back(float(change));
			sum.changed += change > m_rules.change;
			if (kind == Kind::near5) m_verdict.worstOf[0] = std::max(m_verdict.worstOf[0], change);
		}
		if (isAdmitted) addAdmitted(sum, kind, depth, allowed);
		if (kind == Kind::near5 && !isAdmitted) solve(y);
	}

	// Of a motion that is free, as a share of it; constraints are linear, so what turning adds is granted.
	double changeOf(const Vec6& y, double granted) const
	{
		std::vector<HalfSpace> set = m_set;
		for (HalfSpace& half : set) half.offset += granted;
		return length(leastChange(set, y) + (-1.0) * y) / length(y);
	}

	void addAdmitted(Tally& sum, Kind kind, double depth, double allowed)
	{
		const double beyond = std::max(0.0, depth - (allowed - m_skin)) / m_radius;
		++sum.admitted;
		sum.depths.push_back(float(beyond));
		sum.pierced += depth > allowed;
		if (kind == Kind::near5) m_verdict.worstOf[1] = std::max(m_verdict.worstOf[1], beyond);
	}

	void solve(const Vec6& y)
	{
		const Vec6 solved = leastChange(m_set, y);
		const RelativeMotion motion = m_space.motion(solved, m_case.motion.timeStep);
		if (sizeOf(motion, m_a) > m_reach) return;  // where paths are not looked at
		Tally& sum = tally(Kind::solved);
		++sum.motions;
		addAdmitted(sum, Kind::solved, depthsOf(motion, 1e300).deepest(), m_skin + secondOrder(motion));
	}

	const Solid& m_a;
	const Case& m_case;
	const JudgeRules& m_rules;
	Random& m_random;
	double m_radius, m_skin, m_reach = 0;
	MotionSpace m_space;
	std::vector<Sample> m_samples;
	Overlap m_overlap;
	std::vector<HalfSpace> m_set;
	std::vector<Labelled> m_labels[std::size_t(Kind::count)];
	Verdict m_verdict;
};
}  // namespace

void Tally::add(const Tally& other)
{
	motions += other.motions;
	free += other.free;
	admitted += other.admitted;
	changed += other.changed;
	pierced += other.pierced;
	bestHalfSpace += other.bestHalfSpace;
	changes.insert(changes.end(), other.changes.begin(), other.changes.end());
	depths.insert(depths.end(), other.depths.begin(), other.depths.end());
}

double Verdict::worst() const
{
	const double unanswered = isAnswered ? 0 : 1 + startDepth;
	return std::max({worstOf[0], 20 * worstOf[1], 20 * claim, unanswered});
}

const Solid& SolidCache::of(const TriangleMesh& mesh)
{
	std::unique_ptr<Solid>& solid = m_solids[&mesh];
	if (!solid) solid = std::make_unique<Solid>(mesh);
	return *solid;
}

Verdict judge(const Solid& a, const Solid& b, const Case& which, const Answer& answer, double skin,
			  const JudgeRules& rules, Random& random)
{
	return Court(a, b, which, answer, skin, rules, random).run();
}
}  // namespace clod::oracle
