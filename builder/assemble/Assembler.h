// SPDX-License-Identifier: GPL-3.0-or-later
// Levels of detail in, finest first and one at a time; a hierarchy out whose numbers are proved. See README.md.
#pragma once
#include "builder/Lod.h"
#include "builder/assemble/BoundingSphere.h"
#include "builder/assemble/Draft.h"
#include "builder/assemble/Parallel.h"
#include "builder/assemble/Protrusion.h"

namespace clod::builder
{
class Assembler
{
public:
	// input: the surface of level 0.
	// threads: for the loops; never changes a result.
	Assembler(const Mesh& input, const BuildConfig& config, const Progress& progress, const ThreadLimit& threads);

	// The next coarser level: who answers for what, and its certified numbers.
	void add(Lod&& lod);
	// Everything that needs all levels.
	HierarchyContent finish();

private:
	void take(Lod&& lod);
	void report(const char* phase, double fraction) const;
	void assign(std::size_t level);
	LevelAssignment assignmentOf(std::size_t level);
	void link(std::size_t level, const std::vector<Overlap>& shared);
	void certify(std::size_t level);
	double hausdorffStep(const NodeDraft& node) const;
	double exactHausdorff(const NodeDraft& node) const;
	void addAreas();
	std::vector<std::vector<Vec3>> cornersBelowTop() const;
	void linkParents();
	void crudeCompletionBounds();
	void closeMonotone();
	void closeNode(NodeDraft& node) const;

	std::vector<Lod> m_lods;
	std::vector<Lod> m_coarse;  // levels of few patches, kept back until all are known
	const BuildConfig& m_config;
	const Progress& m_progress;
	const ThreadLimit& m_threads;
	const Solid m_solid;
	const Sphere m_sphere;
	const ProtrusionScale m_scale;
	HierarchyDraft m_draft;
	LevelAssignment m_below;             // of the level added last
	std::vector<std::uint32_t> m_label;  // paper mode: the patch of each input face in that level
};
}  // namespace clod::builder
