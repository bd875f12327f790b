// SPDX-License-Identifier: Zlib
#include "demos/models/Profile.h"

#include <cmath>

namespace clod::demo
{
void Profile::line(ProfilePoint from, ProfilePoint to)
{
	const double l = std::hypot(to.radius - from.radius, to.height - from.height);
	m_pieces.push_back({from, to, 0, 0, 0, m_length, l});
	m_length += l;
}

void Profile::arc(ProfilePoint centre, double arcRadius, double from, double to)
{
	const double l = arcRadius * std::fabs(to - from);
	m_pieces.push_back({centre, {}, arcRadius, from, to, m_length, l});
	m_length += l;
}

const Profile::Piece& Profile::piece(double s) const
{
	size_t i = 0;
	while (i + 1 < m_pieces.size() && s > m_pieces[i + 1].start) ++i;
	return m_pieces[i];
}

ProfilePoint Profile::at(double s) const
{
	const Piece& p = piece(s);
	const double t = (s - p.start) / p.length;
	if (p.arcRadius == 0)
		return {p.from.radius + t * (p.to.radius - p.from.radius), p.from.height + t * (p.to.height - p.from.height)};
	const double angle = p.angleFrom + t * (p.angleTo - p.angleFrom);
	return {p.from.radius + p.arcRadius * std::cos(angle), p.from.height + p.arcRadius * std::sin(angle)};
}

double Profile::curvature(double s) const
{
	const Piece& p = piece(s);
	return p.arcRadius == 0 ? 0 : 1 / p.arcRadius;
}
}  // namespace clod::demo
