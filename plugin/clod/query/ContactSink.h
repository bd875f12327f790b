// SPDX-License-Identifier: Zlib
// Turns accepted pairs into contacts, and keeps what the certificate needs of the pairs that are no contacts.
#pragma once
#include <limits>
#include <vector>

#include "clod/Export.h"
#include "clod/query/HullCull.h"

namespace clod
{
// In the order of their nodes, whatever the walk that found them.
CLOD_API void sortByNodes(std::vector<Contact>& contacts);

// A pair is a contact iff the lower bound of its hull distance, evaluated from the canonical start, is within the
// tolerance. Cached values reject a pair only where they exceed the tolerance by more than the accuracy of that
// evaluation.
class ContactSink
{
public:
	// What becomes of covers.
	enum class Covers
	{
		kBounded,  // without the sink's help: there are base levels (StopRule.h)
		kWanted,   // largestCover() is
		kUnwanted  // no gap is asked for
	};
	ContactSink(const QueryContext& context, double tolerance, Covers covers, std::vector<Contact>& contacts,
				QueryStats& stats)
		: m_context(context),
		  m_tolerance(tolerance),
		  m_farForAll(tolerance + kEvaluationRoom * (context.size + tolerance + context.longestMove) +
					  4 * context.pose.rounding),
		  m_covers(covers),
		  m_contacts(contacts),
		  m_stats(stats),
		  m_hulls(context, stats)
	{
	}

	// One that leaves the pairs to those who list them: it evaluates nothing.
	static ContactSink ofLists(const QueryContext& context, double tolerance, std::vector<Contact>& none,
							   QueryStats& stats)
	{
		ContactSink sink(context, tolerance, Covers::kUnwanted, none, stats);
		sink.m_onlyLists = true;
		return sink;
	}

	// Of contacts only whether their hulls overlap. Precondition: covers are not wanted.
	void leaveOutDistances() { m_signsOnly = true; }

	// An accepted pair of hulls that are so far apart at least needs nothing: one that is no contact leaves no trace.
	bool skips(double lower) const
	{
		return m_covers == Covers::kBounded && lower > m_farForAll;
	}

	// An accepted pair within the tolerance by its culling volumes. known: what is evaluated is added.
	void answer(std::uint32_t a, std::uint32_t b, CachedSeparation& cached, HullEvaluations& known);

	double tolerance() const { return m_tolerance; }  // a front may be made for more

	// max over the pairs that are near by their boxes, but no contacts, of cover_a + cover_b; not of those whose hulls
	// are farther apart than that and the tolerance: their surfaces are beyond it.
	double largestCover() const { return m_largestCover; }
	// min over the contacts of a certified bound of their distance less cover_a + cover_b.
	double leastApart() const { return m_leastApart; }

private:
	HullDistance distanceAtRest(std::uint32_t a, std::uint32_t b, double limit, const HullEvaluations& known);
	void noContact(std::uint32_t a, std::uint32_t b);
	void add(std::uint32_t a, std::uint32_t b, const HullDistance& distance);
	double separationAtRest(std::uint32_t a, std::uint32_t b, const Vec3& axis);
	bool isDecided(std::uint32_t a, std::uint32_t b, CachedSeparation& cached, HullEvaluations& known);

	const QueryContext& m_context;
	const double m_tolerance;
	const double m_farForAll;  // beyond the tolerance by the room of any pair
	const Covers m_covers;
	std::vector<Contact>& m_contacts;
	QueryStats& m_stats;
	HullCull m_hulls;
	double m_largestCover = 0;
	double m_leastApart = std::numeric_limits<double>::infinity();
	bool m_onlyLists = false, m_signsOnly = false;
};

}  // namespace clod
