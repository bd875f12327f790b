// SPDX-License-Identifier: Zlib
// What a step costs at each notch of coarsening, learned from what steps did cost. Costs of all notches go up and down
// together as bodies meet and part (the condition); beside it each notch has a share of its own, that lasts. All are
// logarithms: a notch costs so many times as much as another.
#pragma once
#include <array>

#include "clod/Export.h"

namespace clod
{
class CLOD_API CostCurve
{
public:
	static constexpr int kNotches = 81;
	static constexpr double kNotchesAnOctave = 4;  // of the factor: levels of a hierarchy differ by about one

	CostCurve() { m_share.fill(kUnknown); }
	bool isKnown() const { return m_isKnown; }
	// Of the next step: what it most likely costs, and by how much more it often does.
	double expected(int notch) const { return m_condition + shareOf(notch); }
	double spread() const;

	// How often was it too dear lately?
	int failures(int notch) const { return m_failures[std::size_t(notch)]; }

	// A step cost so much; or it would have cost more than it was let.
	void observe(int notch, double cost);
	void exceed(int notch, double cost);

private:
	static constexpr double kUnknown = -1e300;
	bool isKnown(int notch) const { return m_share[std::size_t(notch)] > kUnknown; }
	double shareOf(int notch) const;
	void correct(int notch, double surprise);
	// Those of other notches, by what is known of this one: finer ones cost no less.
	void order(int notch, double forgotten);

	std::array<double, kNotches> m_share;
	std::array<unsigned char, kNotches> m_failures{};  // lately
	int m_last = 0, m_fits = 0;  // the last notch, and steps at it that were not too dear
	double m_condition = 0;
	double m_variance = 0.01;  // of what steps cost about what was expected
	bool m_isKnown = false;
};
}  // namespace clod
