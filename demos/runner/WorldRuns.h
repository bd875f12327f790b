// SPDX-License-Identifier: Zlib
// How whole steps and memory of a world grow with its bodies, threads and triangles: ours, and what users of Bullet
// have instead.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
struct WorldContender
{
	std::string name;
	ContactMetric metric;            // of ours
	std::vector<SceneShape> shapes;  // of the others: one for each of the scene's models
};

struct WorldRunOptions
{
	int from = 0, to = 0;     // the steps that are measured
	double mostSeconds = 60;  // of a run, timed as its steps: it then ends with what it has, at least the step that it is in
	unsigned threads = 1;
};

// One run: bodies (that move), triangles of all, covered (for the caller to set: how many lie under a body); medians of step_us and dispatch_us, processor time on one thread;
// bytes (that the heap has grown by since before the world was made; null where the machine does not tell), pairs,
// points and levels at the end; how many steps there were time for; began_only: time was up before the first that was
// to be measured, whose growth is not told.
nlohmann::ordered_json measureWorld(const SceneDefinition& scene, const std::vector<std::shared_ptr<const Hierarchy>>& models,
									const WorldContender& contender, const WorldRunOptions& options);

// The slope of log y over log x, of the rows that have both, by least squares; NaN with fewer than two.
double growthExponent(const std::vector<nlohmann::ordered_json>& rows, const std::string& x, const std::string& y);

// A set of rows that grow along one axis.
struct WorldSweep
{
	std::string title, axis;  // the axis is a member of rows
	std::vector<nlohmann::ordered_json> rows;
};
// title, axis, rows[], growth[]: contender, threads, step_us and bytes as exponents.
nlohmann::ordered_json toJson(const WorldSweep& sweep);
std::string formatWorldCsv(const std::vector<WorldSweep>& sweeps);
// Sweeps as they are measured: what a run has that is ended early is in the file.
class WorldRecord
{
public:
	explicit WorldRecord(std::string csv) : m_csv(std::move(csv)) {}
	void begin(const std::string& title, const std::string& axis) { m_sweeps.push_back({title, axis, {}}); }
	// To the sweep begun last, and the file is written anew. Throws cli::Failure (1) when it cannot be.
	const nlohmann::ordered_json& add(nlohmann::ordered_json row);
	const std::vector<WorldSweep>& sweeps() const { return m_sweeps; }

private:
	std::string m_csv;
	std::vector<WorldSweep> m_sweeps;
};
std::string formatWorldTable(const std::vector<WorldSweep>& sweeps);
// A column a sweep: step time above, bytes below. False: gnuplot is not installed or failed.
bool plotWorlds(const std::vector<WorldSweep>& sweeps, const std::string& path);
}  // namespace clod::demo
