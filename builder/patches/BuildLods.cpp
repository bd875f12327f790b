// SPDX-License-Identifier: GPL-3.0-or-later
// The simplification loop: collapse, merge, cut a level whenever the number of patches has halved.
// Source: the paper, sec. 4.2 and fig. 3. Where the default mode departs from it, README.md says why.
#include <algorithm>
#include <optional>
#include <utility>

#include "builder/Lod.h"
#include "builder/patches/Collapse.h"
#include "builder/patches/Decompose.h"
#include "builder/patches/EdgeQueue.h"

namespace clod::builder
{
namespace
{
constexpr double kStorageRounding = 8.0 / (1 << 24);  // eps_0, share of the radius
constexpr double kFirstBound = 0.0001;                // of the deviation, share of the radius
constexpr double kFineBound = 0.0005;                 // below it collapses go by their error, from it by resolution
constexpr double kBoundGrowth = 1.5;
constexpr double kToleranceShare = 0.25;  // eps_k of the deviation reached
constexpr std::uint32_t kRetries = 3;     // of a blocked edge after changes nearby
constexpr double kStuck = 3;              // times the last cut's bound without another: patches are grown anew
constexpr double kWorthRegrowing = 0.98;  // of what is left to the next cut

// The current state as a level; patches are numbered by their first triangle.
Lod snapshot(const PatchMesh& mesh, double tolerance, std::vector<std::uint32_t>& idOfPatch)
{
	Lod lod;
	lod.patchTolerance = tolerance;
	idOfPatch.assign(mesh.patches.size(), kNone);
	std::vector<std::uint32_t> idOfVertex(mesh.positions.size(), kNone);
	for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
	{
		if (mesh.star[v].empty()) continue;
		idOfVertex[v] = std::uint32_t(lod.mesh.vertices.size());
		lod.mesh.vertices.push_back(mesh.positions[v]);
	}
	for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
	{
		if (!mesh.isAlive(f)) continue;
		std::uint32_t& id = idOfPatch[mesh.label[f]];
		if (id == kNone)
		{
			id = lod.patchCount++;
			lod.patchResolution.push_back(mesh.patches[mesh.label[f]].resolution);
		}
		lod.patchOfTriangle.push_back(id);
		const auto& t = mesh.faces[f];
		lod.mesh.triangles.push_back({idOfVertex[t[0]], idOfVertex[t[1]], idOfVertex[t[2]]});
	}
	return lod;
}

class Simplifier
{
public:
	Simplifier(const Mesh& input, const BuildConfig& config, const Progress& progress, const LodSink& sink)
		: m_config(config),
		  m_progress(progress),
		  m_sink(sink),
		  m_mesh(input),
		  m_validity(m_mesh),
		  m_guard(input, m_mesh.radius)
	{
		m_validity.tolerance = kStorageRounding * m_mesh.radius;
	}

	void run()
	{
		m_validity.isExact = true;
		decompose(m_mesh, m_validity, m_progress);
		m_validity.isExact = false;
		cut();
		m_collapser.emplace(m_mesh, m_validity, m_guard, m_config);
		m_firstFaces = m_mesh.faceCount;
		if (m_config.paper)
			runPaper();
		else
			runGuarded();
	}

private:
	// What collapses and joins change.
	struct State
	{
		PatchMesh mesh;
		DeviationGuard::Held held;
		std::vector<Quadric> quadrics;
		double tolerance;
	};

	void runPaper();
	void runGuarded();
	void regrow();
	State state() const { return {m_mesh, m_guard.held(), m_collapser->quadrics(), m_validity.tolerance}; }
	void restore(State&& state);
	double shareOfLastCut() const;
	void raiseTolerance(double tolerance);
	std::size_t drainQueue();
	void pushAll();
	void push(std::uint32_t u, std::uint32_t w);
	void pushAround(std::uint32_t vertex);
	void retryRing(std::uint32_t centre);
	bool isEdge(std::uint32_t u, std::uint32_t w) const;
	void joinAround();
	void cut();
	void cutIfHalved();
	void splitOverNotches();
	bool tell() const;
	bool isFinished() const;

	const BuildConfig& m_config;
	const Progress& m_progress;
	const LodSink& m_sink;
	PatchMesh m_mesh;
	Validity m_validity;
	DeviationGuard m_guard;
	std::optional<Collapser> m_collapser;
	EdgeQueue m_queue;
	struct
	{
		std::uint32_t patches = 0;
		std::size_t triangles = 0;
		double bound = 0;
	} m_last;                  // level
	bool m_isLoose = false;    // every face is a patch, and stays one
	bool m_isRegrown = false;  // since the last cut: whose patches went where is not known
	std::size_t m_firstFaces = 0;
	std::size_t m_attempts = 0;
};

// False to cancel.
bool Simplifier::tell() const
{
	return !m_progress || m_progress("simplify", 1 - double(m_mesh.faceCount) / double(m_firstFaces));
}

bool Simplifier::isFinished() const
{
	return m_mesh.patchCount <= 1;
}

void Simplifier::cut()
{
	std::vector<std::uint32_t> idOfPatch;
	Lod lod = snapshot(m_mesh, m_validity.tolerance, idOfPatch);
	if (!m_isRegrown) lod.patchOfChild.assign(m_last.patches, kNone);
	for (std::uint32_t p = 0; p < m_mesh.patches.size(); ++p)
	{
		std::vector<std::uint32_t>& kids = m_mesh.patches[p].kids;
		if (m_last.patches > 0 && !m_isRegrown)
			for (const std::uint32_t kid : kids) lod.patchOfChild[kid] = idOfPatch[p];
		kids.clear();
		if (idOfPatch[p] != kNone) kids.push_back(idOfPatch[p]);
	}
	m_last = {lod.patchCount, lod.mesh.triangles.size(), m_guard.bound};
	m_isRegrown = false;
	m_sink(std::move(lod));
}

void Simplifier::cutIfHalved()
{
	if (2 * m_mesh.patchCount > m_last.patches) return;
	// Default mode: a level that saves patches alone costs more, in the file and in every query, than it saves.
	if (!m_config.paper && 2 * m_mesh.faceCount > m_last.triangles) return;
	joinEverywhere(m_mesh, m_validity);
	if (!m_config.paper) splitOverNotches();
	if (2 * m_mesh.patchCount > m_last.patches) return;
	cut();
	m_mesh.rebuildTrees();
}

// Between levels a thin patch may span a notch of a sheet. Its faces do not; the paper's levels inherit patches whole.
void Simplifier::splitOverNotches()
{
	for (std::uint32_t p = 0; p < m_mesh.patches.size(); ++p)
		if (!m_mesh.patches[p].faces.empty() && m_validity.spansNotch(p)) m_mesh.split(p);
}

// By resolution, the paper's order, a level uses up its whole bound; by error it takes first what costs nearly nothing.
// Coarse levels by error have more slivers and more patches.
void Simplifier::push(std::uint32_t u, std::uint32_t w)
{
	const bool byError = !m_config.paper && m_guard.bound < kFineBound * m_mesh.radius;
	m_queue.push(u, w, byError ? -m_collapser->quadricError(u, w) : m_collapser->resolution(u, w));
}

void Simplifier::pushAround(std::uint32_t vertex)
{
	for (const std::uint32_t f : m_mesh.star[vertex])
	{
		const auto& t = m_mesh.faces[f];
		const std::uint32_t next = t[std::size_t((m_mesh.cornerOf(f, vertex) + 1) % 3)];
		push(vertex, next);
	}
}

void Simplifier::pushAll()
{
	m_queue.clear();
	for (std::uint32_t f = 0; f < m_mesh.faces.size(); ++f)
	{
		if (!m_mesh.isAlive(f)) continue;
		const auto& t = m_mesh.faces[f];
		for (std::size_t k = 0; k < 3; ++k)
			if (t[k] < t[(k + 1) % 3]) push(t[k], t[(k + 1) % 3]);
	}
}

// Pairs of patches that meet in a convex edge at the new star.
void Simplifier::joinAround()
{
	const std::vector<std::uint32_t> star = m_collapser->newStar();
	for (bool joined = true; joined;)
	{
		joined = false;
		for (std::size_t i = 0; i < star.size() && !joined; ++i)
			for (int k = 0; k < 3 && !joined; ++k)
			{
				const std::uint32_t a = m_mesh.label[star[i]];
				const std::uint32_t b = m_mesh.label[m_mesh.adjacent[star[i]][std::size_t(k)]];
				if (a == b || m_mesh.edgeHeight(star[i], k) > m_validity.tolerance) continue;
				joined = tryJoin(m_mesh, m_validity, std::min(a, b), std::max(a, b));
			}
	}
}

// Edges of the ring that were blocked may have become possible.
void Simplifier::retryRing(std::uint32_t centre)
{
	for (const std::uint32_t f : m_mesh.star[centre])
	{
		const std::uint32_t p = m_mesh.faces[f][std::size_t((m_mesh.cornerOf(f, centre) + 1) % 3)];
		for (const std::uint32_t g : m_mesh.star[p])
		{
			const std::uint32_t q = m_mesh.faces[g][std::size_t((m_mesh.cornerOf(g, p) + 1) % 3)];
			if (q == centre || m_queue.isWaiting(p, q)) continue;
			if (m_queue.retries(p, q)++ < kRetries) push(p, q);
		}
	}
}

bool Simplifier::isEdge(std::uint32_t u, std::uint32_t w) const
{
	for (const std::uint32_t f : m_mesh.star[u])
		if (m_mesh.cornerOf(f, w) >= 0) return true;
	return false;
}

std::size_t Simplifier::drainQueue()
{
	std::size_t done = 0;
	EdgeQueue::Edge edge;
	while (!isFinished() && m_queue.pop(edge))
	{
		if (!isEdge(edge.first, edge.second)) continue;
		if (++m_attempts % 512 == 0 && !tell()) throw Cancelled{};
		if (m_collapser->attempt(edge.first, edge.second) != Outcome::Done) continue;
		++done;
		if (!m_isLoose) joinAround();
		pushAround(edge.first);
		retryRing(edge.first);
		if (!m_isLoose) cutIfHalved();
	}
	return done;
}

// No control of the deviation but its end: without one, a surface of genus 0 runs down to a tetrahedron.
void Simplifier::runPaper()
{
	m_guard.bound = m_config.stopDeviation * m_mesh.radius;
	do pushAll();
	while (drainQueue() > 0 && !isFinished());
}

// Which patches lean on others depends on the tolerance.
void Simplifier::raiseTolerance(double tolerance)
{
	if (tolerance <= m_validity.tolerance) return;
	m_validity.tolerance = tolerance;
	for (std::uint32_t p = 0; p < m_mesh.patches.size(); ++p)
	{
		if (m_mesh.patches[p].faces.empty()) continue;
		// A front that only the wider tolerance leaves uncovered is inside by the narrower one: it blocks nobody.
		if (m_validity.keepsCovered(p)) m_mesh.lean(p, m_validity.supports());
	}
}

void Simplifier::restore(State&& state)
{
	m_mesh = std::move(state.mesh);
	m_guard.restore(std::move(state.held));
	m_collapser->restore(std::move(state.quadrics));
	m_validity.tolerance = state.tolerance;
}

// A level is cut when neither of the two is more than half.
double Simplifier::shareOfLastCut() const
{
	return std::max(double(m_mesh.patchCount) / m_last.patches, double(m_mesh.faceCount) / double(m_last.triangles));
}

// Patches that can neither merge nor bend hold the collapses up (threads, wrinkles). Without any the mesh is simplified
// as far as the bound allows, and cut into patches anew. Patches that have been merged for long are the better ones
// elsewhere: the new ones stay only where they are nearer to the next level.
void Simplifier::regrow()
{
	State before = state();
	const double share = shareOfLastCut();
	m_mesh.dissolve();
	m_isLoose = true;
	pushAll();
	drainQueue();
	m_isLoose = false;
	raiseTolerance(kToleranceShare * m_guard.reached());
	decompose(m_mesh, m_validity, [this](const char*, double) { return tell(); });
	if (shareOfLastCut() >= kWorthRegrowing * share)
	{
		restore(std::move(before));
		return;
	}
	m_isRegrown = true;
	cutIfHalved();
}

void Simplifier::runGuarded()
{
	for (double bound = kFirstBound; !isFinished(); bound = std::min(kBoundGrowth * bound, m_config.stopDeviation))
	{
		m_guard.bound = bound * m_mesh.radius;
		raiseTolerance(kToleranceShare * m_guard.reached());
		pushAll();
		drainQueue();
		joinEverywhere(m_mesh, m_validity);
		cutIfHalved();
		const bool isLast = bound >= m_config.stopDeviation;
		if (isLast || bound >= kStuck * std::max(m_last.bound / m_mesh.radius, kFirstBound)) regrow();
		if (isLast) break;
	}
}
}  // namespace

void buildLods(const Mesh& input, const BuildConfig& config, const Progress& progress, const LodSink& sink)
{
	Simplifier(input, config, progress, sink).run();
}

LodSequence buildLods(const Mesh& input, const BuildConfig& config, const Progress& progress)
{
	LodSequence sequence;
	buildLods(input, config, progress, [&sequence](Lod&& lod) { sequence.lods.push_back(std::move(lod)); });
	return sequence;
}
}  // namespace clod::builder
