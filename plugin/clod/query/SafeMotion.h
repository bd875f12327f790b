// SPDX-License-Identifier: Zlib
// By how much two bodies that are apart may move before they have to be looked at again. Finding that costs about as much
// as looking, so where it was used up after few queries it is not sought again at once.
//
// Based on: conservative advancement (Mirtich 1996).
#pragma once
#include "clod/query/BackOff.h"
#include "clod/query/Constants.h"

namespace clod
{
class SafeMotion
{
public:
	bool isKnown() const { return m_isKnown; }
	bool allows(double motion) const { return m_isKnown && motion < m_motion; }
	void use() { ++m_uses; }
	// Where it does not hold: is another to be sought?
	bool isToBeSought()
	{
		if (m_isKnown) m_uses < kWorthwhile ? m_backOff.fail() : m_backOff.succeed();
		m_isKnown = false;
		m_uses = 0;
		return m_backOff.isOver();
	}
	void set(double motion)
	{
		m_motion = motion;
		m_isKnown = true;
	}

private:
	bool m_isKnown = false;
	double m_motion = 0;
	std::uint32_t m_uses = 0;
	BackOff m_backOff{kSearchBackOff};
};
}  // namespace clod
