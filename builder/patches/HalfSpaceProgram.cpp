// SPDX-License-Identifier: GPL-3.0-or-later
// Source: see HalfSpaceProgram.h.
#include "builder/patches/HalfSpaceProgram.h"

#include <utility>

namespace clod::builder
{
namespace
{
struct Programme
{
	Vec3 target;
	const std::vector<Plane>& rows;
	double tolerance;

	bool violated(const Plane& row, const Vec3& x) const { return dot(row.normal, x) < row.offset - tolerance; }

	// Projection of the target on the planes of up to three rows; empty where they are nearly dependent.
	std::optional<Vec3> projection(const Plane* const tight[3], int count) const
	{
		if (count == 0) return target;
		const Plane& a = *tight[0];
		if (count == 1) return target + (a.offset - dot(a.normal, target)) * a.normal;
		const Plane& b = *tight[1];
		const Vec3 line = cross(a.normal, b.normal);
		const double sine = lengthSquared(line);
		if (sine < 1e-16) return {};
		if (count == 2)
		{
			const double ra = a.offset - dot(a.normal, target), rb = b.offset - dot(b.normal, target);
			const double c = dot(a.normal, b.normal);
			return target + ((ra - c * rb) / sine) * a.normal + ((rb - c * ra) / sine) * b.normal;
		}
		const Plane& d = *tight[2];
		const double volume = dot(line, d.normal);
		if (volume * volume < 1e-16 * sine) return {};
		return (1 / volume) *
			   (a.offset * cross(b.normal, d.normal) + b.offset * cross(d.normal, a.normal) + d.offset * line);
	}

	std::optional<Vec3> solve(std::size_t rowCount, const Plane* (&tight)[3], int count) const
	{
		std::optional<Vec3> x = projection(tight, count);
		for (std::size_t i = 0; x && i < rowCount; ++i)
		{
			if (!violated(rows[i], *x)) continue;
			if (count == 3) return {};
			tight[count] = &rows[i];
			x = solve(i, tight, count + 1);
		}
		return x;
	}
};
}  // namespace

std::optional<Vec3> nearestInside(const Vec3& target, std::vector<Plane> rows, double tolerance, std::uint64_t seed)
{
	std::uint64_t state = seed;
	for (std::size_t i = rows.size(); i > 1; --i)
	{
		state = state * 6364136223846793005ull + 1442695040888963407ull;
		std::swap(rows[i - 1], rows[std::size_t((state >> 33) % i)]);
	}
	const Plane* tight[3] = {};
	return Programme{target, rows, tolerance}.solve(rows.size(), tight, 0);
}
}  // namespace clod::builder
