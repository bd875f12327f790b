// SPDX-License-Identifier: GPL-3.0-or-later
// What is left of a convex polygon when others are taken away from it, as convex pieces; pieces under a solid's faces
// are counted instead, up and down.
// Source: clipping against one line after the other (Sutherland & Hodgman 1974), both sides kept.
#pragma once
#include <vector>

#include "builder/patches/Clip.h"

namespace clod::builder
{
class Remainder
{
public:
	// Of the counter-clockwise polygon, but for a border of the width; pieces smaller than `least` are dropped.
	Remainder(const std::vector<Point2>& outline, double width, double least);
	// What lies in the convex polygon, wound either way, is gone; or its depth in the solid changes.
	void take(std::vector<Point2> polygon) { split(std::move(polygon), 0); }
	void count(std::vector<Point2> polygon, int change) { split(std::move(polygon), change); }

	// What is left and not inside the solid.
	std::vector<std::vector<Point2>> open() const;
	double openArea() const;

private:
	struct Piece
	{
		std::vector<Point2> polygon;
		int depth;  // inside where positive
	};
	void add(std::vector<Point2>&& polygon, int depth);
	void split(std::vector<Point2>&& by, int change);
	std::vector<Piece> m_pieces, m_before;
	const double m_least;
};

// The part to the right of the line from a to b; the rest stays.
std::vector<Point2> cutRight(std::vector<Point2>& polygon, const Point2& a, const Point2& b);
}  // namespace clod::builder
