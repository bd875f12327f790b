// SPDX-License-Identifier: Zlib
// A mug and a dish. Both are a flat bottom, a rounded corner, a wall and a rounded rim, with the inside a parallel
// curve at the wall's thickness. The mug's wall is a shallow barrel, and a handle joins two holes in the outer grid,
// each bent to an ellipse, over fillets: genus 1.
#include <algorithm>
#include <cmath>

#include "demos/models/Profile.h"
#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;

struct Vessel
{
	double wall, cornerRadius, flatRadius;
	double cornerEnd;                // angle where the corner meets the wall
	double barrelRadius, barrelEnd;  // 0: the corner goes up to the rim
	ProfilePoint barrelCentre;
};

// From the middle of the underside, up outside, over the rim, down inside to the middle of the bottom.
Profile vesselProfile(const Vessel& v)
{
	const ProfilePoint corner = {v.flatRadius, v.cornerRadius};
	const bool barrel = v.barrelRadius > 0;
	const ProfilePoint top = barrel ? v.barrelCentre : corner;
	const double topRadius = barrel ? v.barrelRadius : v.cornerRadius;
	const double topAngle = barrel ? v.barrelEnd : v.cornerEnd;
	const double half = v.wall / 2;
	Profile profile;
	profile.line({0, 0}, {v.flatRadius, 0});
	profile.arc(corner, v.cornerRadius, -PI / 2, v.cornerEnd);
	if (barrel) profile.arc(top, topRadius, v.cornerEnd, topAngle);
	const ProfilePoint rim = {top.radius + (topRadius - half) * std::cos(topAngle),
							  top.height + (topRadius - half) * std::sin(topAngle)};
	profile.arc(rim, half, topAngle, topAngle + PI);
	if (barrel) profile.arc(top, topRadius - v.wall, topAngle, v.cornerEnd);
	profile.arc(corner, v.cornerRadius - v.wall, v.cornerEnd, -PI / 2);
	profile.line({v.flatRadius, v.wall}, {0, v.wall});
	return profile;
}

Vessel cupVessel()
{
	Vessel v = {};
	v.wall = CUP_WALL;
	v.cornerRadius = 0.012;
	v.barrelRadius = 0.5;
	v.barrelCentre = {CUP_OUTER_RADIUS - v.barrelRadius, 0.046};
	// The corner touches the barrel from inside.
	const double rise = v.cornerRadius - v.barrelCentre.height, reach = v.barrelRadius - v.cornerRadius;
	v.flatRadius = v.barrelCentre.radius + std::sqrt(reach * reach - rise * rise);
	v.cornerEnd = std::asin(rise / reach);
	v.barrelEnd = std::asin(0.0425 / v.barrelRadius);
	return v;
}

Vessel bowlVessel()
{
	Vessel v = {};
	v.wall = 0.003;
	v.cornerRadius = 0.045;
	v.flatRadius = 0.018;
	v.cornerEnd = -10 * PI / 180;
	return v;
}

// More strips where the profile bends sharply: a rim of 1.5 mm gets about three times the strips of its length.
double stripDensity(const Profile& profile, double s)
{
	return 1 + 0.003 * profile.curvature(s);
}

Vec3 turned(const ProfilePoint& p, double turn)
{
	const double angle = 2 * PI * turn;
	return {p.radius * std::cos(angle), p.height, p.radius * std::sin(angle)};
}

// The handle: an ellipse swept along half an ellipse in the plane z = 0, from the lower hole to the upper one.
constexpr double HANDLE_LOW = 0.022, HANDLE_HIGH = 0.068;  // heights of the holes' centres
constexpr double HANDLE_REACH = 0.027;                     // outward from the wall
constexpr double HANDLE_HALF_HEIGHT = 0.0035, HANDLE_HALF_WIDTH = 0.0055, HANDLE_FILLET = 0.0035;

// A hole in the outer grid: `rows` x `columns` quads whose border is bent to an ellipse.
struct Hole
{
	int row = 0;         // first strip
	double sGrid = 0;    // middle of the strips left out
	double sCentre = 0;  // wanted middle
};

struct CupGrid
{
	int capCells = 0, strips = 0, rows = 0, columns = 0, handleStrips = 0;
	size_t triangles() const
	{
		return size_t(8 * capCells * strips + 4 * capCells * capCells - 4 * rows * columns +
					  4 * (rows + columns) * handleStrips);
	}
};

constexpr double CAP_SHARE = 0.9;  // of the bottom's flat radius that the cap covers
constexpr double ZONE = 2.6;       // the bending round a hole ends at this many half holes

class CupMaker
{
public:
	explicit CupMaker(size_t triangles) : m_profile(vesselProfile(cupVessel())) { choose(triangles); }

	ModelMesh make()
	{
		if (m_size.capCells == 0) return {};
		SweepGrid grid;
		grid.capCells = m_size.capCells;
		grid.sEnd = m_profile.length();
		grid.rings = spread([this](double s) { return stripDensity(m_profile, s); }, capEdge(),
							m_profile.length() - capEdge(), m_size.strips);
		grid.turnOffset = -0.5 * m_size.columns / grid.columns();
		m_low = hole(grid, HANDLE_LOW);
		m_high = hole(grid, HANDLE_HIGH);
		m_halfRows = 0.5 * (grid.rings[size_t(m_low.row + m_size.rows)] - grid.rings[size_t(m_low.row)]);
		grid.isHole = [this](int strip, int column)
		{
			const auto in = [&](const Hole& h) { return strip >= h.row && strip < h.row + m_size.rows; };
			return column < m_size.columns && (in(m_low) || in(m_high));
		};
		ModelMesh mesh = sweep([this](double s, double turn) { return surface(s, turn); }, grid);
		addHandle(mesh, grid);
		dropUnusedVertices(mesh);
		return mesh;
	}

private:
	double capEdge() const { return CAP_SHARE * cupVessel().flatRadius; }

	// The cell counts that meet the wanted count best with cells close to square.
	void choose(size_t triangles)
	{
		const double strips = integrate([this](double s) { return stripDensity(m_profile, s); }, capEdge(),
										m_profile.length() - capEdge()) /
							  (2 * PI * CUP_OUTER_RADIUS);
		double bestError = 0, bestAspect = 0;
		for (int m = 6; 4.0 * m * m < double(triangles); ++m)
		{
			CupGrid g;
			g.capCells = m;
			g.columns = std::max(2, int(std::lround(4 * m * 10.0 / 176)));
			g.rows = std::max(2, int(std::lround(4 * m * 7.0 / 176)));
			const double idealStrips = strips * 4 * m, idealHandle = 4 * m * 90.0 / 176;
			for (int l = int(0.8 * idealHandle); l <= int(1.25 * idealHandle) + 1; ++l)
			{
				g.handleStrips = l;
				g.strips = 0;
				g.strips = int(std::lround((double(triangles) - double(g.triangles())) / (8.0 * m)));
				if (g.strips < 12) continue;
				const double aspect =
					std::fabs(std::log(g.strips / idealStrips)) + std::fabs(std::log(l / idealHandle));
				if (aspect > std::log(1.5)) continue;
				const double error = std::fabs(double(g.triangles()) - double(triangles));
				if (m_size.capCells != 0 && (error > bestError || (error == bestError && aspect >= bestAspect)))
					continue;
				m_size = g;
				bestError = error;
				bestAspect = aspect;
			}
		}
	}

	// Arc length along the outer wall at a height.
	double arcAtHeight(double height) const
	{
		double low = capEdge(), high = 0.5 * m_profile.length();
		for (int i = 0; i < 100; ++i)
		{
			const double middle = 0.5 * (low + high);
			(m_profile.at(middle).height < height ? low : high) = middle;
		}
		return low;
	}

	Hole hole(const SweepGrid& grid, double height) const
	{
		Hole best;
		best.sCentre = arcAtHeight(height);
		for (int row = 1; row + m_size.rows + 1 < int(grid.rings.size()); ++row)
		{
			const double middle = 0.5 * (grid.rings[size_t(row)] + grid.rings[size_t(row + m_size.rows)]);
			if (best.row == 0 || std::fabs(middle - best.sCentre) < std::fabs(best.sGrid - best.sCentre))
			{
				best.row = row;
				best.sGrid = middle;
			}
		}
		return best;
	}

	// The wall's point for grid coordinates: near a hole the grid is bent so that the hole's border is an ellipse.
	Vec3 surface(double s, double turn) const
	{
		const double nearest = turn - std::round(turn);
		for (const Hole& h : {m_low, m_high})
		{
			const double halfTurn = 0.5 * m_size.columns / (4.0 * m_size.capCells);
			const double a = (s - h.sGrid) / m_halfRows, b = nearest / halfTurn;
			const double q = std::max(std::fabs(a), std::fabs(b));
			if (q >= ZONE || s > 0.5 * m_profile.length()) continue;
			const double angle = squareAngle(a, b);
			const double bend = q <= 1 ? 1 : (ZONE - q) / (ZONE - 1);
			const double sRound = h.sCentre + q * (HANDLE_HALF_HEIGHT + HANDLE_FILLET) * std::cos(angle);
			const double turnRound =
				q * (HANDLE_HALF_WIDTH + HANDLE_FILLET) / (2 * PI * CUP_OUTER_RADIUS) * std::sin(angle);
			return turned(m_profile.at(s + bend * (sRound - s)), nearest + bend * (turnRound - nearest));
		}
		return turned(m_profile.at(s), turn);
	}

	// Angle of a point on a square's border, even along the border; 0 at (1, 0).
	static double squareAngle(double a, double b)
	{
		if (std::fabs(a) >= std::fabs(b)) return (a > 0 ? 0 : PI) + PI / 4 * b / a;
		return (b > 0 ? PI / 2 : -PI / 2) - PI / 4 * a / b;
	}

	// The hole's border vertices once round, from (first row, first column); the upper hole mirrored in height.
	std::vector<uint32_t> border(const SweepGrid& grid, const Hole& h, bool mirrored) const
	{
		std::vector<uint32_t> ids;
		const auto add = [&](int row, int column)
		{
			const int r = mirrored ? m_size.rows - row : row;
			ids.push_back(uint32_t((h.row + r) * grid.columns() + column));
		};
		for (int c = 0; c < m_size.columns; ++c) add(0, c);
		for (int r = 0; r < m_size.rows; ++r) add(r, m_size.columns);
		for (int c = m_size.columns; c > 0; --c) add(m_size.rows, c);
		for (int r = m_size.rows; r > 0; --r) add(r, 0);
		return ids;
	}

	void addHandle(ModelMesh& mesh, const SweepGrid& grid) const
	{
		const std::vector<uint32_t> low = border(grid, m_low, false), high = border(grid, m_high, true);
		const size_t around = low.size();
		std::vector<uint32_t> previous = low;
		// Half the handle's ellipse by its angle; the fillets at both ends take arcs of their own.
		const double fillet = PI / 2 * HANDLE_FILLET, length = curveLength();
		const double total = length - 2 * HANDLE_FILLET + 2 * fillet;
		const auto density = [&](double u) { return u < fillet || u > total - fillet ? 1.4 : 1.0; };
		const std::vector<double> stations = spread(density, 0, total, m_size.handleStrips);
		for (int k = 1; k <= m_size.handleStrips; ++k)
		{
			std::vector<uint32_t> ring = high;
			if (k < m_size.handleStrips)
				for (size_t i = 0; i < around; ++i)
				{
					ring[i] = uint32_t(mesh.vertices.size());
					mesh.vertices.push_back(
						handlePoint(stations[size_t(k)], total, mesh.vertices[low[i]], mesh.vertices[high[i]]));
				}
			for (size_t i = 0; i < around; ++i)
			{
				const size_t next = (i + 1) % around;
				addQuad(mesh, {previous[i], previous[next], ring[next], ring[i]});
			}
			previous = ring;
		}
	}

	double wallRadius(const Hole& h) const { return m_profile.at(h.sCentre).radius; }

	// Curve point by angle in [-pi/2, pi/2].
	Vec3 curve(double angle) const
	{
		const double up = 0.5 + 0.5 * std::sin(angle);
		return {wallRadius(m_low) + up * (wallRadius(m_high) - wallRadius(m_low)) + HANDLE_REACH * std::cos(angle),
				HANDLE_LOW + up * (HANDLE_HIGH - HANDLE_LOW), 0};
	}

	double curveLength() const { return curveArc(PI / 2); }

	// Length of the curve from its lower end to an angle.
	double curveArc(double angle) const
	{
		const double b = 0.5 * (HANDLE_HIGH - HANDLE_LOW);
		return integrate([&](double t) { return std::hypot(HANDLE_REACH * std::sin(t), b * std::cos(t)); }, -PI / 2,
						 angle);
	}

	double curveAngle(double arc) const
	{
		double angle = -PI / 2;
		const double b = 0.5 * (HANDLE_HIGH - HANDLE_LOW);
		constexpr int STEPS = 400;  // midpoint steps of the inverse; the same for every resolution
		for (int i = 0; i < STEPS; ++i)
		{
			const double step = arc / STEPS;
			const double half = angle + 0.5 * step / std::hypot(HANDLE_REACH * std::sin(angle), b * std::cos(angle));
			angle += step / std::hypot(HANDLE_REACH * std::sin(half), b * std::cos(half));
		}
		return std::min(angle, PI / 2);
	}

	// Station u along fillet, handle, fillet; low and high are the hole's vertices that this line of the handle joins.
	Vec3 handlePoint(double u, double total, const Vec3& low, const Vec3& high) const
	{
		const bool upper = u > 0.5 * total;
		const double fromEnd = upper ? total - u : u;
		const double beta = std::min(fromEnd / HANDLE_FILLET, PI / 2);
		const double along =
			beta < PI / 2 ? HANDLE_FILLET * (1 - std::cos(beta)) : HANDLE_FILLET + fromEnd - PI / 2 * HANDLE_FILLET;
		const double lowAngle = curveAngle(along);
		const double angle = upper ? -lowAngle : lowAngle;
		const Vec3 centre = curve(angle);
		const Vec3 tangent =
			normalized({-HANDLE_REACH * std::sin(angle), 0.5 * (HANDLE_HIGH - HANDLE_LOW) * std::cos(angle), 0});
		const Vec3 normal = {-tangent.y, tangent.x, 0};
		// The hole's vertex in the frame of its end, and the same vertex were the hole a flat ellipse.
		const Vec3 end = curve(upper ? PI / 2 : -PI / 2), vertex = upper ? high : low;
		const double side = upper ? -1 : 1;
		const Vec3 offset = {side * (vertex.x - end.x), side * (vertex.y - end.y), vertex.z};
		const double filletGrowth = HANDLE_FILLET * (1 - std::sin(beta));
		const double holeHeight = HANDLE_HALF_HEIGHT + HANDLE_FILLET, holeWidth = HANDLE_HALF_WIDTH + HANDLE_FILLET;
		const double direction = std::atan2(offset.z / holeWidth, offset.y / holeHeight);
		const double c = std::cos(direction), s = std::sin(direction), rest = filletGrowth / HANDLE_FILLET;
		const double onNormal = (HANDLE_HALF_HEIGHT + filletGrowth) * c + rest * (offset.y - holeHeight * c);
		const double onWidth = (HANDLE_HALF_WIDTH + filletGrowth) * s + rest * (offset.z - holeWidth * s);
		return centre + onNormal * normal + onWidth * Vec3{0, 0, 1} + rest * offset.x * tangent;
	}

	Profile m_profile;
	CupGrid m_size;
	Hole m_low, m_high;
	double m_halfRows = 0;
};
}  // namespace

ModelMesh makeCup(size_t triangles)
{
	return CupMaker(triangles).make();
}

ModelMesh makeBowl(size_t triangles)
{
	const Profile profile = vesselProfile(bowlVessel());
	const SweepSize size = sweepSize(triangles, 52.0 / 24);
	if (size.capCells == 0) return {};
	const double capEdge = 0.9 * bowlVessel().flatRadius;
	SweepGrid grid;
	grid.capCells = size.capCells;
	grid.sEnd = profile.length();
	grid.rings =
		spread([&](double s) { return stripDensity(profile, s); }, capEdge, profile.length() - capEdge, size.strips);
	return sweep([&](double s, double turn) { return turned(profile.at(s), turn); }, grid);
}
}  // namespace clod::demo
