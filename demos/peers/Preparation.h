// SPDX-License-Identifier: Zlib
// What peers need before they can run: convex pieces and decimated meshes, made by prepare.py in the venv of
// scripts/peers, and kept in the cache by the hash of mesh, tool and amount.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "demos/peers/PeerMesh.h"

namespace clod::demo
{
// Where scripts/peers puts things: build/peers beside the folder of this program's build.
struct PeerTools
{
	std::string directory;  // may not exist
	std::string python() const { return directory + "/venv/bin/python3"; }
	std::string prepare() const { return directory + "/prepare.py"; }
	std::string coal() const { return directory + "/clod-coal"; }
	bool canPrepare() const;
	bool hasCoal() const;
};
std::string defaultPeerDirectory();

struct Prepared
{
	std::vector<ModelMesh> pieces;
	double seconds = 0;  // when it was made
};

class Preparation
{
public:
	// `cache`: a folder, made when needed; empty: nothing is kept.
	// What takes longer than `mostSeconds` is given up.
	Preparation(PeerTools tools, std::string cache, double mostSeconds)
		: m_tools(std::move(tools)), m_cache(std::move(cache)), m_mostSeconds(mostSeconds)
	{
	}
	const PeerTools& tools() const { return m_tools; }
	// tool: vhacd, coacd or decimate; amount as prepare.py's. Fails with a sentence (tool and reason).
	Result<Prepared> make(const std::string& tool, const std::string& amount, const ModelMesh& mesh) const;

private:
	Result<Prepared> run(const std::string& output, const std::string& tool, const std::string& amount,
						 const ModelMesh& mesh) const;
	PeerTools m_tools;
	std::string m_cache;
	double m_mostSeconds;
};

// A body's mesh and its uniformly decimated versions, from fine to coarse; the first is the mesh itself.
struct DecimatedMesh
{
	MeshPointer mesh;
	double share = 1;      // of the triangles, as they came out
	double deviation = 0;  // sampled, from the full mesh
	double seconds = 0;
};
// `count` meshes at log-spaced shares from 1 to kSmallestShare; those that a tool cannot make are left out.
inline constexpr double kSmallestShare = 0.01;
std::vector<DecimatedMesh> decimate(const Preparation& preparation, const MeshPointer& mesh, int count);

// Pairs in which neither body is finer than the other's deviation asks for: for every mesh of one body the coarsest of
// the other that deviates no more.
std::vector<std::array<std::size_t, 2>> matchedPairs(const std::vector<DecimatedMesh>& a,
													 const std::vector<DecimatedMesh>& b);
}  // namespace clod::demo
