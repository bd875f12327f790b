// SPDX-License-Identifier: Zlib
#include "clod/schedule/CostCurve.h"

#include <algorithm>
#include <cmath>

namespace clod
{
namespace
{
constexpr double kOctave = 0.6931471805599453;  // log 2
// Where nothing is known cost goes with the factor to the power of minus this.
constexpr double kExponent = 1;
// Of a surprise: what is taken for a change of the condition, what for one of the notch's share, and of the variance.
constexpr double kOfCondition = 0.4, kOfShare = 0.15, kOfVariance = 0.05;
constexpr double kLeastVariance = 4e-4, kMostSurprise = 0.5;
// What was too dear is thought to be dearer still by so much, twice as much with each failure; and becomes cheaper by
// so little a step: so it is tried again, later and later.
constexpr double kFailure = 0.2, kForgotten = 0.004;
constexpr int kMostFailures = 4;
constexpr int kTrial = 20;  // steps that must fit in until a failure is forgotten
}  // namespace

double CostCurve::spread() const
{
	return std::sqrt(m_variance);
}

double CostCurve::shareOf(int notch) const
{
	if (isKnown(notch)) return m_share[std::size_t(notch)];
	int finer = notch, coarser = notch;
	while (finer >= 0 && !isKnown(finer)) --finer;
	while (coarser < kNotches && !isKnown(coarser)) ++coarser;
	constexpr double slope = kExponent * kOctave / kNotchesAnOctave;
	if (coarser == kNotches) return finer < 0 ? 0 : m_share[std::size_t(finer)] - slope * (notch - finer);
	const double least = m_share[std::size_t(coarser)];
	if (finer < 0) return least + slope * (coarser - notch);
	return least + (m_share[std::size_t(finer)] - least) * (coarser - notch) / (coarser - finer);
}

void CostCurve::observe(int notch, double cost)
{
	const double now = std::log(std::max(cost, 1.0));
	if (!m_isKnown) m_condition = now;
	const double surprise = now - expected(notch);
	m_variance += kOfVariance * (std::min(surprise * surprise, kMostSurprise * kMostSurprise) - m_variance);
	m_variance = std::max(m_variance, kLeastVariance);
	correct(notch, surprise);
	m_fits = notch == m_last ? m_fits + 1 : 1;
	m_last = notch;
	if (m_fits >= kTrial) m_failures[std::size_t(notch)] = 0;
	order(notch, kForgotten);
}

void CostCurve::exceed(int notch, double cost)
{
	const double least = std::log(std::max(cost, 1.0));
	if (!m_isKnown) m_condition = least;
	unsigned char& failures = m_failures[std::size_t(notch)];
	const double surprise = std::max(0.0, least - expected(notch));
	if (isKnown(notch) && failures == 0)
		correct(notch, surprise);  // a single one changes little
	else
		m_share[std::size_t(notch)] = shareOf(notch) + surprise + kFailure * std::exp2(failures);
	if (failures < kMostFailures) ++failures;
	m_fits = 0;
	m_isKnown = true;
	order(notch, 0);
}

void CostCurve::correct(int notch, double surprise)
{
	double& share = m_share[std::size_t(notch)];
	if (isKnown(notch))
	{
		m_condition += kOfCondition * surprise;
		share += kOfShare * surprise;
	}
	else
		share = shareOf(notch) + surprise;
	m_isKnown = true;
}

void CostCurve::order(int notch, double forgotten)
{
	const double share = m_share[std::size_t(notch)];
	for (int i = 0; i < kNotches; ++i)
	{
		double& other = m_share[std::size_t(i)];
		if (i == notch || !isKnown(i)) continue;
		other = i < notch ? std::max(other - forgotten, share) : std::min(other, share);
	}
}
}  // namespace clod
