// SPDX-License-Identifier: Zlib
#include "clod/bullet/StepReport.h"

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>

#include "clod/bullet/BodyState.h"
#include "clod/collide/Room.h"
#include "clod/distance/SignedGap.h"

namespace clod
{
namespace
{
// Three stops of viridis (Smith & van der Walt 2015).
constexpr Vec3 kFinest = {0.283, 0.141, 0.458}, kMiddle = {0.154, 0.680, 0.504}, kCoarsest = {0.993, 0.906, 0.144};

template <class WorldFromNode>
void drawEdges(const Hierarchy& hierarchy, const Node& node, const WorldFromNode& world, btIDebugDraw& drawer)
{
	const btVector3 color = colorOf(node.level, hierarchy);
	const HullView hull = hierarchy.hull(node);
	const Span<Face> faces = hierarchy.faces(node);
	for (std::uint32_t f = 0; f < faces.size; ++f)
		for (std::size_t e = 0; e < 3; ++e)
		{
			const std::uint32_t other = faces[f].neighbour[e] - node.firstFace;
			if (other < f) continue;  // drawn with that face
			const std::uint32_t from = faces[f].vertex[e], to = faces[f].vertex[(e + 1) % 3];
			drawer.drawLine(world(hull.vertex(from)), world(hull.vertex(to)), color);
		}
}
}  // namespace

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

btVector3 colorOf(std::uint32_t level, const Hierarchy& hierarchy)
{
	const double share = double(level) / std::max(1.0, double(hierarchy.coarsestClodLevel()));
	const Vec3 &from = share < 0.5 ? kFinest : kMiddle, &to = share < 0.5 ? kMiddle : kCoarsest;
	const double part = std::min(1.0, 2 * share - (share < 0.5 ? 0 : 1));
	return toBullet(from + part * (to - from));
}

void drawLevels(const PairReport& pair, btIDebugDraw& drawer)
{
	if (!pair.result) return;
	const auto draw = [&](const Hierarchy* hierarchy, const Transform& aFromNode, std::uint32_t AcceptedPair::*node)
	{
		if (!hierarchy) return;
		std::vector<std::uint32_t> nodes;
		for (const AcceptedPair& accepted : pair.result->pairs) nodes.push_back(accepted.*node);
		std::sort(nodes.begin(), nodes.end());
		nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
		const auto world = [&](const Vec3& place)
		{ return toBullet(pair.worldFromA * (pair.unit * (aFromNode * place))); };
		for (const std::uint32_t index : nodes) drawEdges(*hierarchy, hierarchy->node(index), world, drawer);
	};
	draw(pair.hierarchyA, Transform{}, &AcceptedPair::nodeA);
	draw(pair.hierarchyB, pair.aFromB, &AcceptedPair::nodeB);
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
