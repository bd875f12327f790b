// SPDX-License-Identifier: Zlib
#include "clod/bullet/StepReport.h"

#include <algorithm>

#include "clod/collide/Room.h"
#include "clod/distance/SignedGap.h"

namespace clod
{
void HeldResult::hold(const GapResult& result)
{
	static_cast<ContactSummary&>(*this) = static_cast<const ContactSummary&>(result);
	minDistance = result.minDistance;
	errorBound = result.errorBound;
	pairs.clear();
	shrinkRoom(pairs, result.contacts.size());
	pairs.reserve(result.contacts.size());
	for (const Contact& contact : result.contacts) pairs.push_back({contact.nodeA, contact.nodeB});
}

void contactsOf(const PairReport& pair, std::vector<Contact>& contacts)
{
	contacts.clear();
	if (!pair.result) return;
	for (const AcceptedPair& accepted : pair.result->pairs)
		contacts.push_back({accepted.nodeA, accepted.nodeB, 0, 0, {}, {}, {}});
	if (pair.hierarchyA && pair.hierarchyB) evaluate(*pair.hierarchyA, *pair.hierarchyB, pair.aFromB, contacts);
}

GapResult resultOf(const PairReport& pair)
{
	GapResult result;
	if (!pair.result) return result;
	static_cast<ContactSummary&>(result) = static_cast<const ContactSummary&>(*pair.result);
	result.minDistance = pair.result->minDistance;
	result.errorBound = pair.result->errorBound;
	contactsOf(pair, result.contacts);
	return result;
}

void addTo(StepReport& sum, const PairReport& pair)
{
	const bool isWarned =
		pair.deep || pair.fast || pair.loose || !pair.notFinite.empty() || !pair.metricError.empty();
	if (isWarned)
		sum.warned.push_back({sum.pairs, pair.deep, pair.fast, pair.loose, pair.notFinite, pair.metricError});
	++sum.pairs;
	sum.pairsInContact += pair.points > 0 ? 1 : 0;
	sum.candidates += pair.candidates;
	sum.points += pair.points;
	sum.clusters += pair.clusterCount;
	if (pair.result)
	{
		sum.nodePairs += std::uint32_t(pair.result->pairs.size());
		sum.front += pair.result->stats.front;
		sum.hullTests += pair.result->stats.hullTests + pair.vainTests;
		sum.pending += pair.result->stats.pending;
		sum.excess = std::max(sum.excess, pair.result->excess);
		sum.boxTests += pair.result->stats.boxTests;
	}
	sum.queryMicroseconds += pair.queryMicroseconds;
	sum.contactMicroseconds += pair.contactMicroseconds;
	sum.keptPairs += pair.kept ? 1 : 0;
	sum.deepPairs += pair.deep ? 1 : 0;
	sum.fastPairs += pair.fast ? 1 : 0;
	sum.loosePairs += pair.loose ? 1 : 0;
}

std::vector<std::string> StepReport::warnings() const
{
	std::vector<std::string> sentences;
	for (const Warned& pair : warned)
	{
		const std::string name = "pair " + std::to_string(pair.pair);
		if (!pair.notFinite.empty()) sentences.push_back(name + ": no contacts, as " + pair.notFinite);
		if (!pair.metricError.empty()) sentences.push_back(name + ": exact, as " + pair.metricError);
		if (pair.deep) sentences.push_back(name + ": penetration deeper than the contacts can prove");
		if (pair.fast) sentences.push_back(name + ": one step moves farther than the thinnest wall");
		if (pair.loose) sentences.push_back(name + ": the error bound exceeds the thinnest wall");
	}
	return sentences;
}
}  // namespace clod
