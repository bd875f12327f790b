// SPDX-License-Identifier: Zlib
#include "demos/trial/Recommendation.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "demos/runner/Replay.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
constexpr double kTwoPi = 6.28318530717958647692;
constexpr double kDeepest = 0.2;     // of the tolerance: how far bodies overlap at most
constexpr std::size_t kTumble = 10;  // rows before B starts anew: what they cost is alike
constexpr double kTurn = 0.035;      // radians a row at most: what a rolling body does in a step
constexpr double kRetreat = 0.08;    // of the radius: clears what turning by kTurn can bring into the other
constexpr int kMostAdvances = 60, kMostStarts = 1000;
constexpr std::int64_t kApart = 1000;  // steps before B is elsewhere: no velocity comes of it
constexpr double kRounding = 1e-6;  // of the radius: hierarchies store floats
constexpr double kExact = 1e-4;     // of the radius: what rounding and pieces that are convex up to it come to at most

// Uniform numbers that are the same with every standard library.
class Chance
{
public:
	explicit Chance(std::uint64_t seed) : m_generator(seed) {}
	double between(double low, double high) { return low + (high - low) * double(m_generator() >> 11) * 0x1p-53; }
	Vec3 direction()
	{
		const double z = between(-1, 1), angle = between(0, kTwoPi), r = std::sqrt(1 - z * z);
		return {r * std::cos(angle), r * std::sin(angle), z};
	}

private:
	std::mt19937_64 m_generator;
};

Mat3 turned(const Vec3& axis, double angle)
{
	const double s = std::sin(angle / 2);
	return rotationFromQuaternion(s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2));
}

Vec3 sphereCenter(const Hierarchy& h)
{
	const Asset& asset = h.asset();
	return {double(asset.sphereCenter[0]), double(asset.sphereCenter[1]), double(asset.sphereCenter[2])};
}

// The unit quaternion of a rotation, by its largest component.
void toQuaternion(const Mat3& m, double (&q)[4])
{
	const double trace = m.row[0].x + m.row[1].y + m.row[2].z;
	const double squares[4] = {1 + 2 * m.row[0].x - trace, 1 + 2 * m.row[1].y - trace, 1 + 2 * m.row[2].z - trace,
							   1 + trace};
	const int largest = int(std::max_element(squares, squares + 4) - squares);
	const double four = 2 * std::sqrt(squares[largest]);
	const double minus[3] = {m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y};
	if (largest == 3)
	{
		for (int i = 0; i < 3; ++i) q[i] = minus[i] / four;
		q[3] = four / 4;
		return;
	}
	const int j = (largest + 1) % 3, k = (largest + 2) % 3;
	q[largest] = four / 4;
	q[j] = (m.row[largest][j] + m.row[j][largest]) / four;
	q[k] = (m.row[largest][k] + m.row[k][largest]) / four;
	q[3] = minus[largest] / four;
}

// B as it tumbles over A, which stays. Body frames.
class Tumbler
{
public:
	Tumbler(const Hierarchy& a, const Hierarchy& b, double tolerance, std::uint64_t seed)
		: m_a(a), m_b(b), m_radius(smallerRadius(a, b)), m_chance(seed)
	{
		m_settings.metric.exact = true;
		m_settings.tolerance = tolerance;
		m_settings.distance = true;
	}
	// False where B passes by A.
	bool start()
	{
		m_cache.clear();
		m_aim = m_chance.direction();
		m_rotation = turn(kTwoPi);
		const Vec3 aside = m_chance.direction();
		const double far = double(m_a.asset().radius) + double(m_b.asset().radius) + m_settings.tolerance;
		m_center = sphereCenter(m_a) + far * m_aim +
				   m_chance.between(0, 0.7 * std::max(m_a.asset().radius, m_b.asset().radius)) *
					   (aside - dot(aside, m_aim) * m_aim);
		return advance(2 * far);
	}
	bool tumble()
	{
		m_rotation = turn(kTurn) * m_rotation;
		const Vec3 way = m_chance.direction();
		m_center += m_chance.between(0, kTurn) * m_radius * way + kRetreat * m_radius * m_aim;
		return advance(kMostAdvances * kRetreat * m_radius);
	}
	PoseRow row(std::int64_t step) const
	{
		PoseRow row;
		row.step = step;
		toQuaternion(m_rotation, row.b.quaternion);
		// Mesh frames: A's is where its file has it.
		row.b.position = m_center + meshFromBody(m_a) - m_rotation * (sphereCenter(m_b) + meshFromBody(m_b));
		return row;
	}
	// As near as it can be known.
	GapResult gap()
	{
		GapSettings settings = m_settings;
		settings.gapError = 0;
		return measure(settings);
	}

private:
	Mat3 turn(double most)
	{
		const double angle = m_chance.between(0, most);
		return turned(m_chance.direction(), angle);
	}
	const GapResult& measure(const GapSettings& settings)
	{
		signedGap(m_a, m_b, relativePose(row(0), meshFromBody(m_a), meshFromBody(m_b)), settings, m_cache, m_result);
		return m_result;
	}
	// Moves B towards A until a gap drawn by chance is left.
	bool advance(double most)
	{
		const double wanted = m_chance.between(-kDeepest, 1) * m_settings.tolerance;
		double way = 0;
		for (int i = 0; i < kMostAdvances && way < most; ++i)
		{
			const double gap = measure(m_settings).minDistance;
			if (gap <= wanted + 0.1 * m_settings.tolerance) return gap >= -kDeepest * m_settings.tolerance;
			const double step = gap - std::min(wanted, 0.5 * gap);  // nothing is met before the gap is used up
			m_center -= step * m_aim;
			way += step;
		}
		return false;
	}

	const Hierarchy &m_a, &m_b;
	double m_radius;
	Chance m_chance;
	GapSettings m_settings;
	GapCache m_cache;
	GapResult m_result;
	Vec3 m_aim, m_center;
	Mat3 m_rotation;
};

template <class Row, class Value>
double over(const std::vector<Row>& rows, double p, const Value& value)
{
	std::vector<double> values;
	for (const Row& row : rows) values.push_back(value(row));
	return quantile(std::move(values), p);
}

// Of the gap that a row reports; a row that reports none says that the gap is larger than the tolerance less its bound.
double errorOf(const ReplayRow& row, double gap, double tolerance)
{
	if (std::isfinite(row.minDistance)) return std::fabs(row.minDistance - gap);
	return std::max(0.0, tolerance - gap);
}
}  // namespace

TouchingPoses touchingPoses(const Hierarchy& a, const Hierarchy& b, double tolerance, std::size_t count,
							std::uint64_t seed, const std::function<void(double)>& progress)
{
	TouchingPoses poses;
	Tumbler tumbler(a, b, tolerance, seed);
	int starts = 0;
	std::int64_t step = 0;
	while (poses.rows.size() < count && starts < kMostStarts)
	{
		bool touches = tumbler.start();
		++starts;
		step += kApart;
		for (std::size_t i = 0; touches && i < kTumble && poses.rows.size() < count; ++i)
		{
			poses.rows.push_back(tumbler.row(step++));
			const GapResult gap = tumbler.gap();
			poses.gaps.push_back(gap.minDistance);
			poses.bounds.push_back(gap.errorBound);
			progress(double(poses.rows.size()) / double(count));
			touches = tumbler.tumble();
			starts = 0;
		}
	}
	return poses;
}

ContactMetric limitMetric(double share)
{
	return share > 0 ? ContactMetric::errorShare(share) : ContactMetric::exactly();
}

LimitRow measureLimit(const Hierarchy& a, const Hierarchy& b, double share, double tolerance,
					  const TouchingPoses& poses)
{
	ReplayOptions options;
	options.metric = limitMetric(share);
	options.tolerance.value = tolerance;
	if (share == 0) options.gapError = cli::Length{0, false, "0"};  // as a certified limit asks for the gap, too
	PairQueries queries({&a, &b}, options);
	std::vector<ReplayRow> rows;
	LimitRow limit;
	limit.share = share;
	const double radius = smallerRadius(a, b);
	for (std::size_t i = 0; i < poses.rows.size(); ++i)
	{
		rows.push_back(queries.at(poses.rows[i]));
		limit.certified = std::max(limit.certified, rows.back().errorBound / radius);
		const double error = errorOf(rows.back(), poses.gaps[i], tolerance);
		limit.error = std::max(limit.error, error / radius);
		limit.broken += error > rows.back().errorBound + poses.bounds[i] + kRounding * radius;
	}
	limit.tests = over(rows, 0.5, [](const ReplayRow& row) { return double(row.tests()); });
	limit.contacts = over(rows, 0.5, [](const ReplayRow& row) { return double(row.contacts); });
	return limit;
}

void timeLimit(LimitRow& limit, Peer& dispatch, double tolerance, const TouchingPoses& poses, const RowClock& clock)
{
	PoseSample sample;
	sample.dt = clock.dt;
	sample.tolerance = tolerance;
	for (std::size_t i = 0; i < poses.rows.size(); ++i) sample.rows.push_back(recordedRow(poses.rows, i, clock));
	const std::vector<PeerAnswer> answers = dispatch.pass(sample);
	const auto time = [](const PeerAnswer& answer) { return answer.microseconds; };
	limit.microseconds = over(answers, 0.5, time);
	limit.p95 = over(answers, 0.95, time);
}

std::vector<double> limitShares(double own)
{
	std::vector<double> shares = {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 0};
	const auto isOwn = [&](double share) { return std::fabs(share - own) <= 1e-9 * own; };
	shares.erase(std::remove_if(shares.begin(), shares.end(), isOwn), shares.end());
	shares.push_back(own);
	std::sort(shares.begin(), shares.end(), std::greater<double>());
	return shares;
}

bool Recommendation::keepsAccuracy() const
{
	if (fresh.broken > 0 || !(fresh.certified <= std::max(accuracy, kExact) + kRounding)) return false;
	return chosen.share > 0 ? fresh.certified <= chosen.share + kRounding : fresh.error <= kExact;
}

bool Recommendation::keepsCost() const
{
	return std::fabs(fresh.tests - chosen.tests) <= kCostSlack * chosen.tests;
}

const LimitRow* cheapestWithin(const std::vector<LimitRow>& limits, double share)
{
	const LimitRow* best = nullptr;
	for (const LimitRow& limit : limits)
		if (limit.share <= share && (!best || limit.tests <= best->tests)) best = &limit;  // finer ones come later
	return best;
}

const LimitRow* mostAccurateWithin(const std::vector<LimitRow>& limits, double microseconds)
{
	const LimitRow* best = nullptr;
	for (const LimitRow& limit : limits)
		if (limit.microseconds <= microseconds && (!best || limit.share < best->share)) best = &limit;
	return best;
}
}  // namespace clod::demo
