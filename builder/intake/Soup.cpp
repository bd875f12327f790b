// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/Soup.h"

#include <fmt/format.h>

namespace clod::builder
{
const char* name(Reason reason)
{
	switch (reason)
	{
		case Reason::unreadable:
			return "unreadable";
		case Reason::syntax:
			return "syntax";
		case Reason::empty:
			return "empty";
		case Reason::limit:
			return "limit";
		case Reason::notFinite:
			return "not finite";
		case Reason::indexOutOfRange:
			return "index out of range";
		case Reason::degenerate:
			return "degenerate face";
		case Reason::duplicate:
			return "duplicate face";
		case Reason::nonManifoldEdge:
			return "non-manifold edge";
		case Reason::nonManifoldVertex:
			return "non-manifold vertex";
		case Reason::openBoundary:
			return "open boundary";
		case Reason::orientation:
			return "inconsistent orientation";
		case Reason::inverted:
			return "inverted";
		case Reason::zeroVolume:
			return "zero volume";
		case Reason::rounding:
			return "rounding";
		case Reason::selfIntersection:
			return "self-intersection";
	}
	return "unknown";
}

std::string sentence(const std::vector<Defect>& defects)
{
	std::string text;
	for (const Defect& defect : defects)
	{
		text += fmt::format("{}{}: {}", text.empty() ? "" : "; also ", name(defect.reason), defect.first);
		if (defect.count > 1) text += fmt::format(" ({} such)", defect.count);
	}
	return text;
}

std::uint32_t checkedIndex(long long index, const std::string& place)
{
	if (index < 0 || index >= 0xFFFFFFFFll)
		throw Refused(Reason::indexOutOfRange, fmt::format("{}: vertex index {}", place, index));
	return std::uint32_t(index);
}
}  // namespace clod::builder
