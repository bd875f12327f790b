// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/Repair.h"

#include <CGAL/Random.h>
#include <CGAL/assertions_behaviour.h>
#include <CGAL/exceptions.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "builder/assemble/TriangleTree.h"
#include "builder/repair/CleanSoup.h"
#include "builder/repair/Cracks.h"
#include "builder/repair/MendMesh.h"
#include "builder/repair/Wrap.h"

namespace clod::builder
{
namespace
{
constexpr double kSewing = 1e-5;  // of the extent
constexpr double kOffsetOfAlpha = 1.0 / 30;
constexpr double kShell = 2.5;       // offsets; a wrap of a sheet from both sides is two thick
constexpr double kSolid = 0.01;      // offsets; what is thicker between two faces of the file is no sheet
constexpr double kMuchShell = 0.01;  // of the wrap's area, to be told
constexpr double kWrapTriangleLimit = 5e6;
constexpr int kRoundings = 3;
constexpr double kCoarser = 1.3;    // times the length, where the wrap has too many triangles
constexpr double kCurvedFaces = 8;  // times the triangles, of curved faces; a guess for the progress

Mesh toMesh(const WeldedMesh& mesh)
{
	return {mesh.vertices, mesh.triangles};
}

Soup toSoup(const Mesh& mesh)
{
	Soup soup;
	soup.vertices = mesh.vertices;
	for (const auto& t : mesh.triangles)
	{
		soup.corners.insert(soup.corners.end(), t.begin(), t.end());
		soup.endPolygon();
	}
	return soup;
}

// In the frame of the file.
Mesh builtSurface(const Intake& solid)
{
	Mesh mesh = solid.mesh;
	for (Vec3& v : mesh.vertices) v = v + solid.meshFromBody;
	return mesh;
}

double areaOf(const Mesh& mesh)
{
	double area = 0;
	for (const auto& t : mesh.triangles)
		area +=
			0.5 * length(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
	return area;
}

// The share of a wrap's area that bounds a shell: no thicker than kShell, with faces of the file in between, but no
// solid of the file (a thin part has both its sides there, a sheet one, or two in the same place).
double shellShareOf(const Mesh& wrap, const Mesh& file, double offset)
{
	Mesh turned = file;
	for (auto& t : turned.triangles) std::swap(t[1], t[2]);
	const TriangleTree tree(wrap), into(turned), outOf(file);
	double all = 0, shell = 0;
	for (std::uint32_t t = 0; t < tree.size(); ++t)
	{
		const Vec3 outward = areaVector(tree.triangle(t)), from = centroid(tree.triangle(t));
		const double area = length(outward);
		if (!(area > 0)) continue;
		all += area;
		const Vec3 inward = (-1 / area) * outward;
		const double thickness = tree.exitDistance(from, inward, 0);
		if (thickness > kShell * offset) continue;
		const double in = into.exitDistance(from, inward, 0), out = outOf.exitDistance(from, inward, 0);
		const bool isSolid = std::max(in, out) <= thickness && std::abs(in - out) > kSolid * offset;
		if (std::min(in, out) <= thickness && !isSolid) shell += area;
	}
	return shell / all;
}

// CGAL's failed assertions become refusals, and its random choices the same in every run.
template <class Step>
Repaired guarded(const Step& step)
{
	const CGAL::Failure_behaviour before = CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
	CGAL::get_default_random() = CGAL::Random(0);
	try
	{
		const Repaired result = step();
		CGAL::set_error_behaviour(before);
		return result;
	}
	catch (const CGAL::Failure_exception& failure)
	{
		CGAL::set_error_behaviour(before);
		throw Refused(Reason::selfIntersection,
					  fmt::format("the repair meets a case CGAL gives up on ({}); try --wrap", failure.expression()));
	}
	catch (...)
	{
		CGAL::set_error_behaviour(before);
		throw;
	}
}

void measure(const Mesh& file, Repaired& repaired, const Progress& progress)
{
	const Mesh built = builtSurface(repaired.solid);
	const double rounding = 1e-5 * extentOf(file.vertices);
	report(progress, "measure", 0);
	repaired.added = directedDistance(built, file, rounding);
	report(progress, "measure", 0.5);
	repaired.lost = directedDistance(file, built, rounding);
	report(progress, "measure", 1);
}

bool isSound(const Soup& soup, Intake& solid)
{
	try
	{
		solid = intake(soup);
		return true;
	}
	catch (const Refused&)
	{
		return false;
	}
}

// The intake's checks are the judge; what rounding to float breaks is mended again.
Intake accept(Mesh mesh, Changes& changes, const Progress& progress)
{
	for (int round = 0;; ++round)
	{
		report(progress, "check", double(round) / (kRoundings + 1));
		if (mesh.triangles.empty()) throw Refused(Reason::zeroVolume, "nothing encloses a volume after the repair");
		try
		{
			return intake(toSoup(mesh));
		}
		catch (const Refused& refused)
		{
			const Reason reason = refused.reason();
			const bool again = reason == Reason::selfIntersection || reason == Reason::rounding ||
							   reason == Reason::degenerate || reason == Reason::inverted;
			if (!again || round == kRoundings)
				throw Refused(reason,
							  fmt::format("still so after the repair, elements numbered as repaired: {}; try --wrap",
										  refused.what()));
		}
		const Vec3 center = mesh.vertices.front();
		for (Vec3& v : mesh.vertices)
			for (int i = 0; i < 3; ++i) v[i] = center[i] + double(roundToFloat(v[i] - center[i]));
		mesh = mendRounded(mesh, changes);
	}
}
}  // namespace

double Repaired::moved() const
{
	return std::max(added.upper, lost.upper);
}

Repaired repair(const Soup& soup, double maxMove, const Progress& progress)
{
	return guarded(
		[&]
		{
			Repaired repaired;
			if (isSound(soup, repaired.solid)) return repaired;
			report(progress, "repair", 0);
			WeldedMesh mesh = usableFaces(soup, repaired.changes);
			const Mesh file = toMesh(mesh);
			const double tolerance = kSewing * extentOf(mesh.vertices);
			sewCracks(mesh, tolerance, repaired.changes);
			splitAtTJunctions(mesh, tolerance, repaired.changes);
			dropRepeatedFaces(mesh, repaired.changes);
			report(progress, "repair", 0.5);
			Mesh mended = mend(mesh, repaired.changes);
			report(progress, "repair", 1);
			repaired.solid = accept(std::move(mended), repaired.changes, progress);
			measure(file, repaired, progress);
			if (repaired.moved() > maxMove)
			{
				const DistanceBracket& farthest =
					repaired.added.upper > repaired.lost.upper ? repaired.added : repaired.lost;
				throw Refused(Reason::limit,
							  fmt::format("the repair would move the surface by {:.4g}, near {}; allowed are {:.4g} "
										  "(--max-move of clod-build)",
										  repaired.moved(), placeOf(farthest.at), maxMove));
			}
			return repaired;
		});
}

Repaired wrapAround(const Soup& soup, double asked, std::size_t mostTriangles, const Progress& progress)
{
	return guarded(
		[&]
		{
			Repaired repaired;
			const Mesh file = toMesh(usableFaces(soup, repaired.changes));
			// A wrap has one or two triangles of side `length`; where it turns, `length * offset`.
			const auto fewestOf = [area = areaOf(file)](double length) { return 2 * area / (length * length); };
			double length = asked;
			const double most = mostTriangles > 0 ? double(mostTriangles) : std::numeric_limits<double>::infinity();
			while (length > 0 && fewestOf(length) > most) length *= kCoarser;
			const double triangles = fewestOf(length);
			if (!(triangles <= kWrapTriangleLimit))
				throw Refused(Reason::limit,
							  fmt::format("a wrap of {:.4g} would need about {:.2g} triangles; the limit is {:.2g}",
										  length, triangles, kWrapTriangleLimit));
			report(progress, "wrap", 0);
			const auto wrapOf = [&](double alpha)
			{
				const double expected = std::min(most, kCurvedFaces * fewestOf(alpha)) / 2;
				return alphaWrap(file, alpha, kOffsetOfAlpha * alpha, {expected, most / 2}, progress);
			};
			std::optional<Mesh> found = wrapOf(length);
			for (; !found; found = wrapOf(length)) length *= kCoarser;
			const Mesh& wrap = *found;
			if (length > asked)
				repaired.changes.push_back(fmt::format("gaps narrower than {:.4g} closed instead of {:.4g}: {} triangles "
													   "are the most that are wanted",
													   length, asked, mostTriangles));
			repaired.changes.push_back(fmt::format("{} faces wrapped by {} triangles {:.4g} outside of them",
												   file.triangles.size(), wrap.triangles.size(),
												   kOffsetOfAlpha * length));
			const double shell = shellShareOf(wrap, file, kOffsetOfAlpha * length);
			if (shell > kMuchShell)
				repaired.changes.push_back(fmt::format("{:.0f} % of the wrap bound a shell only {:.4g} thick: there is a "
													   "gap wider than {:.4g}, or faces have nothing behind them; a "
													   "longer --wrap closes wider gaps",
													   100 * shell, 2 * kOffsetOfAlpha * length, length));
			repaired.solid = accept(wrap, repaired.changes, progress);
			measure(file, repaired, progress);
			return repaired;
		});
}
}  // namespace clod::builder
