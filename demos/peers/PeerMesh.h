// SPDX-License-Identifier: Zlib
// The triangles that peers work on: always those a hierarchy stores, so that everybody answers about the same surface.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "clod/hierarchy/Hierarchy.h"
#include "demos/models/Models.h"
#include "demos/runner/InputSurface.h"

namespace clod::demo
{
using MeshPointer = std::shared_ptr<const ModelMesh>;

// A file of `v x y z`, `f i j k` and `o NAME` lines as prepare.py and toObj write them; every `o` starts a piece
// (none: one piece). Comments are kept: "# key value" lines go to `notes`. Fails with file and line.
struct PieceFile
{
	std::vector<ModelMesh> pieces;
	std::vector<std::pair<std::string, double>> notes;
	double note(const std::string& key, double otherwise) const;
};
Result<PieceFile> readPieces(const std::string& path);

// Largest distance of a vertex or face centre of `full` to `coarse`, and the other way round: how far a decimated mesh
// is from its original, sampled.
double sampledDeviation(const ModelMesh& full, const ModelMesh& coarse);
}  // namespace clod::demo
