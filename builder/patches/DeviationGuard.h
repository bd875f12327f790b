// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the simplified surface within a bound of the input and the input within the bound of the simplified surface.
// Both directions are sampled: the moved faces at corners, edge midpoints and centroids against the input; the input at
// its vertices, and on a grid inside large triangles, against the faces that took over the surroundings.
// Source of the second half: R. Klein, G. Liebich, W. Strasser, Mesh Reduction with Error Control, 1996.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "builder/patches/PatchMesh.h"

namespace clod::builder
{
class DeviationGuard
{
public:
	DeviationGuard(const Mesh& input, double radius);
	double bound = 0;

	// Whether the star round a moved vertex stays near the input.
	bool surfaceIsNear(const Vec3& centre, const std::vector<TrianglePoints>& star) const;
	// Whether the samples held by the old faces lie near the new ones; remembers where each would go.
	bool inputIsNear(const std::vector<std::uint32_t>& oldFaces, const std::vector<std::uint32_t>& newFaces,
					 const std::vector<TrianglePoints>& newPoints);
	// Hands the samples over as the last inputIsNear found.
	void commit(const std::vector<std::uint32_t>& oldFaces);
	// Largest distance of a sample of the input to the faces that hold it, over all commits.
	double reached() const { return m_held.reached; }

	// What collapses change.
	struct Held
	{
		std::vector<std::vector<std::uint32_t>> samples;  // of each face of the simplified mesh
		double reached = 0;
	};
	const Held& held() const { return m_held; }
	void restore(Held&& held) { m_held = std::move(held); }

private:
	bool isNear(const Vec3& p) const;
	const Mesh& m_input;
	BoxTree m_tree;
	std::vector<Vec3> m_samples;
	Held m_held;
	struct Handover
	{
		std::uint32_t sample, face;
	};
	std::vector<Handover> m_handover;
	double m_trialReached = 0;
};
}  // namespace clod::builder
