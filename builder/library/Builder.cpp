// SPDX-License-Identifier: GPL-3.0-or-later
#include "clod/builder/Builder.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "builder/intake/FileFrame.h"
#include "builder/intake/ReadMesh.h"
#include "builder/library/Asset.h"

namespace clod::builder
{
namespace
{
Soup soupOf(const TriangleMesh& mesh)
{
	Soup soup;
	soup.vertices = mesh.vertices;
	for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles)
	{
		soup.corners.insert(soup.corners.end(), triangle.begin(), triangle.end());
		soup.endPolygon();
	}
	return soup;
}

constexpr unsigned kMostThreads = 1024;

std::string problemOf(const Options& options)
{
	const auto isLength = [](double length) { return length >= 0 && std::isfinite(length); };
	if (options.threads > kMostThreads)
		return std::to_string(options.threads) + " threads, at most " + std::to_string(kMostThreads);
	if (!isLength(options.maxMove)) return "maxMove is not a length";
	if (!isLength(options.wrap)) return "wrap is not a length";
	if (options.wrap > 0 && options.repair) return "a wrap stands for a repair: one of the two";
	if (options.maxMove > 0 && !options.repair) return "maxMove is of a repair";
	return "";
}

// Names that convert() takes for granted.
std::string problemOf(const FileOptions& options)
{
	std::string problem = problemOf(static_cast<const Options&>(options));
	if (!problem.empty()) return problem;
	const auto isOneOf = [](const std::vector<std::string>& names, const std::string& name)
	{ return std::find(names.begin(), names.end(), name) != names.end(); };
	if (!options.unit.empty() && !isOneOf(unitNames(), options.unit)) return "unknown unit " + options.unit;
	if (!isOneOf(upNames(), options.up)) return "no axis " + options.up;
	if (!(options.scale > 0) || !std::isfinite(options.scale)) return "the scale is not a positive number";
	return "";
}

Outcome refusal(const std::string& message)
{
	Outcome outcome;
	outcome.status = Status::refused;
	outcome.message = message;
	return outcome;
}

Outcome buildSoup(const Soup& soup, const Options& options, const Callback& callback)
{
	Outcome outcome;
	Mending mending;
	mending.repair = options.repair;
	if (options.maxMove != 0) mending.maxMove = options.maxMove;
	if (options.wrap != 0) mending.wrap = options.wrap;
	report(callback, "solid", 0);
	Repaired repaired = solidOf(soup, mending, callback);
	BuildConfig config;
	config.paper = options.paper;
	config.threads = options.threads;
	config.seed = options.seed;
	report(callback, "solid", 1);
	const HierarchyContent content = buildAsset(repaired.solid, config, callback);
	Result<std::shared_ptr<const Hierarchy>> hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy)
	{
		outcome.message = "the result is not sound: " + hierarchy.error();
		return outcome;
	}
	outcome.status = Status::built;
	outcome.hierarchy = std::move(hierarchy.value());
	outcome.moved = repaired.changes.empty() ? 0 : repaired.moved();
	outcome.changes = std::move(repaired.changes);
	return outcome;
}

// Fills in what is thrown. Messages that do not fit into memory any more stay empty.
template <class Work>
Outcome guarded(const Work& work) noexcept
{
	Outcome outcome;
	const auto say = [&outcome](Status status, const char* message) noexcept
	{
		outcome.status = status;
		try
		{
			outcome.message = message;
		}
		catch (...)
		{
		}
	};
	try
	{
		return work();
	}
	catch (const Refused& refused)
	{
		say(refused.reason() == Reason::limit ? Status::limit : Status::refused, refused.what());
	}
	catch (const Cancelled&)
	{
		say(Status::cancelled, "cancelled");
	}
	catch (const std::bad_alloc&)
	{
		say(Status::limit, "out of memory");
	}
	catch (const std::exception& error)
	{
		say(Status::failed, error.what());
	}
	catch (...)
	{
		say(Status::failed, "unknown error");
	}
	return outcome;
}
}  // namespace

Outcome build(const TriangleMesh& mesh, const Options& options, const Callback& callback) noexcept
{
	return guarded(
		[&]
		{
			const std::string problem = problemOf(options);
			return problem.empty() ? buildSoup(soupOf(mesh), options, callback) : refusal(problem);
		});
}

Outcome buildFile(const std::string& path, const FileOptions& options, const Callback& callback) noexcept
{
	return guarded(
		[&]
		{
			const std::string problem = problemOf(options);
			if (!problem.empty()) return refusal(problem);
			report(callback, "read", 0);
			Soup soup = readMesh(path);
			convert({options.unit, options.up, options.scale}, soup);
			return buildSoup(soup, options, callback);
		});
}
}  // namespace clod::builder
