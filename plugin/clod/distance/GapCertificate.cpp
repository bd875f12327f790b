// SPDX-License-Identifier: Zlib
// Signed gap and error bound, as proved in the header.
#include "clod/distance/GapCertificate.h"

#include <algorithm>
#include <limits>

#include "clod/distance/Constants.h"

namespace clod
{
namespace
{
double sum(float x, float y)
{
	return double(x) + double(y);
}

Gap bracketed(double value, double low, double high)
{
	return {value, kSumUp * std::max(value - low, high - value), false};
}
}  // namespace

double highFromWitnesses(const QueryContext& context, const std::vector<Contact>& contacts)
{
	double high = std::numeric_limits<double>::infinity();
	for (const Contact& contact : contacts)
	{
		const Node &a = context.a.node(contact.nodeA), &b = context.b.node(contact.nodeB);
		high = std::min(high, contact.upper + sum(a.protrude, b.protrude));
	}
	return high;
}

Gap gapOfSurfaces(const SurfaceDistance& distance)
{
	return bracketed(distance.value, distance.low, distance.high);
}

Gap gapBetween(double low, double high)
{
	return bracketed(0.5 * (low + high), low, high);
}

Gap gapApart(const QueryContext& context, const std::vector<Contact>& contacts, double tolerance, double largestCover)
{
	double low = tolerance - largestCover, value = std::numeric_limits<double>::infinity();
	for (const Contact& contact : contacts)
	{
		const Node &a = context.a.node(contact.nodeA), &b = context.b.node(contact.nodeB);
		low = std::min(low, contact.lower - sum(a.cover, b.cover));
		value = std::min(value, contact.upper);
	}
	return bracketed(value, low, highFromWitnesses(context, contacts));
}
}  // namespace clod
