// SPDX-License-Identifier: Zlib
// A curve in the half plane (radius, height) of lines and circular arcs, by arc length: what a surface of revolution is
// turned from.
#pragma once
#include <vector>

namespace clod::demo
{
struct ProfilePoint
{
	double radius = 0, height = 0;
};

class Profile
{
public:
	void line(ProfilePoint from, ProfilePoint to);
	// Angles in radians, 0 along +radius, counter-clockwise where `to` > `from`.
	void arc(ProfilePoint centre, double arcRadius, double from, double to);
	double length() const { return m_length; }
	ProfilePoint at(double s) const;
	double curvature(double s) const;  // absolute, 0 on lines

private:
	struct Piece
	{
		ProfilePoint from, to;  // of a line; of an arc `from` is the centre
		double arcRadius, angleFrom, angleTo;
		double start, length;
	};
	const Piece& piece(double s) const;
	std::vector<Piece> m_pieces;
	double m_length = 0;
};
}  // namespace clod::demo
