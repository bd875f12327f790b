// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/intake/Soup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace clod::builder
{
const char* name(Reason reason)
{
	switch (reason)
	{
		case Reason::unreadable:
			return "unreadable";
		case Reason::noSuchPart:
			return "no such part";
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

std::string placeOf(const Vec3& point)
{
	return fmt::format("({:.6g}, {:.6g}, {:.6g})", point.x, point.y, point.z);
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

void Soup::endPart(const std::string& name)
{
	constexpr std::size_t kLongest = 100;
	std::string plain = name.substr(0, kLongest);
	for (char& c : plain)
	{
		const unsigned char byte = static_cast<unsigned char>(c);
		if (byte < 0x80 && std::isalnum(byte) == 0 && c != '.' && c != '-' && c != '_') c = '_';
	}
	if (plain.empty()) plain = "part";
	if (plain[0] == '.' || plain[0] == '-') plain[0] = '_';
	std::string unique = plain;
	const auto isTaken = [&](const Part& part) { return part.name == unique; };
	for (int i = 2; std::any_of(parts.begin(), parts.end(), isTaken); ++i) unique = fmt::format("{}_{}", plain, i);
	parts.push_back({unique, vertices.size(), polygonCount()});
}

Soup partOf(const Soup& soup, const std::string& name)
{
	std::size_t vertex = 0, polygon = 0;
	for (const Part& part : soup.parts)
	{
		if (part.name == name)
		{
			Soup piece;
			piece.vertices.assign(soup.vertices.begin() + std::ptrdiff_t(vertex),
								  soup.vertices.begin() + std::ptrdiff_t(part.vertexEnd));
			for (; polygon < part.polygonEnd; ++polygon)
			{
				for (std::size_t i = soup.polygonBegin(polygon); i < soup.polygonEnd[polygon]; ++i)
					piece.corners.push_back(std::uint32_t(soup.corners[i] - vertex));
				piece.endPolygon();
			}
			piece.endPart(name);
			return piece;
		}
		vertex = part.vertexEnd;
		polygon = part.polygonEnd;
	}
	throw Refused(Reason::noSuchPart, fmt::format("'{}' is none of the file's {} parts", name, soup.parts.size()));
}

std::uint32_t checkedIndex(long long index, const std::string& place)
{
	if (index < 0 || index >= kMostVertices)
		throw Refused(Reason::indexOutOfRange, fmt::format("{}: vertex index {}", place, index));
	return std::uint32_t(index);
}
}  // namespace clod::builder
