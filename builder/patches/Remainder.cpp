// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/patches/Remainder.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clod::builder
{
namespace
{
// By a side of `by` that all of the polygon lies to the right of.
bool isApart(const std::vector<Point2>& polygon, const std::vector<Point2>& by)
{
	for (std::size_t i = 0; i < by.size(); ++i)
	{
		const Point2 &a = by[i], &b = by[(i + 1) % by.size()];
		if (std::all_of(polygon.begin(), polygon.end(), [&](const Point2& p) { return cross2(a, b, p) <= 0; }))
			return true;
	}
	return false;
}
}  // namespace

std::vector<Point2> cutRight(std::vector<Point2>& polygon, const Point2& a, const Point2& b)
{
	std::vector<Point2> left, right;
	for (std::size_t i = 0; i < polygon.size(); ++i)
	{
		const Point2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
		const double hp = cross2(a, b, p), hq = cross2(a, b, q);
		if (hp >= 0) left.push_back(p);
		if (hp <= 0) right.push_back(p);
		if (!((hp > 0 && hq < 0) || (hp < 0 && hq > 0))) continue;
		const double share = hp / (hp - hq);
		left.push_back({p.x + share * (q.x - p.x), p.y + share * (q.y - p.y)});
		right.push_back(left.back());
	}
	polygon = std::move(left);
	return right;
}

Remainder::Remainder(const std::vector<Point2>& outline, double width, double least) : m_least(least)
{
	std::vector<Point2> inner = outline;
	for (std::size_t i = 0; i < outline.size(); ++i)
	{
		const Point2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
		const double dx = b.x - a.x, dy = b.y - a.y, shift = width / std::sqrt(dx * dx + dy * dy);
		cutRight(inner, {a.x - shift * dy, a.y + shift * dx}, {b.x - shift * dy, b.y + shift * dx});
	}
	add(std::move(inner), 0);
}

std::vector<std::vector<Point2>> Remainder::open() const
{
	std::vector<std::vector<Point2>> polygons;
	for (const Piece& piece : m_pieces)
		if (piece.depth <= 0) polygons.push_back(piece.polygon);
	return polygons;
}

double Remainder::openArea() const
{
	double sum = 0;
	for (const Piece& piece : m_pieces)
		if (piece.depth <= 0) sum += areaOf(piece.polygon);
	return sum;
}

void Remainder::add(std::vector<Point2>&& polygon, int depth)
{
	if (polygon.size() >= 3 && areaOf(polygon) > m_least) m_pieces.push_back({std::move(polygon), depth});
}

void Remainder::split(std::vector<Point2>&& by, int change)
{
	const double area = areaOf(by);
	if (area == 0) return;
	if (area < 0) std::reverse(by.begin(), by.end());
	m_before.swap(m_pieces);
	m_pieces.clear();
	for (Piece& piece : m_before)
	{
		if (isApart(piece.polygon, by))
		{
			m_pieces.push_back(std::move(piece));
			continue;
		}
		for (std::size_t i = 0; i < by.size() && piece.polygon.size() >= 3; ++i)
			add(cutRight(piece.polygon, by[i], by[(i + 1) % by.size()]), piece.depth);
		if (change != 0) add(std::move(piece.polygon), piece.depth + change);
	}
}
}  // namespace clod::builder
