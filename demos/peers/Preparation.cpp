// SPDX-License-Identifier: Zlib
// Runs prepare.py and keeps what it made.
#include "demos/peers/Preparation.h"

#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "cli/Files.h"
#include "cli/Program.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Process.h"

namespace clod::demo
{
namespace
{
namespace fs = std::filesystem;
constexpr std::size_t kScriptLimit = std::size_t(1) << 20;

// Of everything the result depends on: the mesh's bits, the tool, its amount and the script's bytes.
std::string keyOf(const std::string& script, const std::string& tool, const std::string& amount, const ModelMesh& mesh)
{
	XXH3_state_t* state = XXH3_createState();
	XXH3_128bits_reset(state);
	XXH3_128bits_update(state, script.data(), script.size());
	XXH3_128bits_update(state, tool.c_str(), tool.size() + 1);
	XXH3_128bits_update(state, amount.c_str(), amount.size() + 1);
	XXH3_128bits_update(state, mesh.vertices.data(), mesh.vertices.size() * sizeof mesh.vertices[0]);
	XXH3_128bits_update(state, mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
	const XXH128_hash_t digest = XXH3_128bits_digest(state);
	XXH3_freeState(state);
	return fmt::format("{}-{}-{:016x}{:016x}.obj", tool, amount, digest.high64, digest.low64);
}

constexpr int kTimedOut = 124;  // exit code of coreutils' timeout

Result<Prepared> readPrepared(const std::string& path)
{
	Result<PieceFile> file = readPieces(path);
	if (!file) return Error{file.error()};
	const double seconds = file.value().note("seconds", -1);
	if (seconds < 0) return Error{path + ": has no `# seconds` line"};
	return Prepared{std::move(file.value().pieces), seconds};
}
}  // namespace

bool PeerTools::canPrepare() const
{
	return access(python().c_str(), X_OK) == 0 && access(prepare().c_str(), R_OK) == 0;
}

bool PeerTools::hasCoal() const
{
	return access(coal().c_str(), X_OK) == 0;
}

std::string defaultPeerDirectory()
{
	// .../build/release/bin/clod-build -> .../build/peers
	return (fs::path(builderPath()).parent_path() / "../../peers").lexically_normal().string();
}

Result<Prepared> Preparation::run(const std::string& output, const std::string& tool, const std::string& amount,
								  const ModelMesh& mesh) const
{
	const cli::PartialFile input(temporaryDirectory() + "/clod-peer-mesh.obj");  // never committed
	if (std::string error = cli::writeFile(input.temporaryPath(), toObj(mesh)); !error.empty()) return Error{error};
	const int code = runProgram({"timeout", fmt::format("{:.0f}", m_mostSeconds), m_tools.python(), m_tools.prepare(),
								 tool, input.temporaryPath(), output, amount});
	if (code == kTimedOut) return Error{fmt::format("{} {} took longer than {:.0f} s", tool, amount, m_mostSeconds)};
	if (code != 0) return Error{fmt::format("{} {} failed with exit code {}", tool, amount, code)};
	return readPrepared(output);
}

Result<Prepared> Preparation::make(const std::string& tool, const std::string& amount, const ModelMesh& mesh) const
{
	const Result<std::vector<std::byte>> script = cli::readFile(m_tools.prepare(), kScriptLimit);
	if (!script) return Error{script.error()};
	const std::string bytes(reinterpret_cast<const char*>(script.value().data()), script.value().size());
	const std::string name = keyOf(bytes, tool, amount, mesh);
	if (m_cache.empty())
	{
		const cli::PartialFile output(temporaryDirectory() + "/clod-peer-pieces.obj");  // never committed
		return run(output.temporaryPath(), tool, amount, mesh);
	}
	const std::string entry = m_cache + "/" + name;
	std::error_code failed;
	if (fs::exists(entry, failed))
		if (Result<Prepared> kept = readPrepared(entry)) return kept;  // a damaged entry is made again
	fs::create_directories(m_cache, failed);
	if (failed) return Error{fmt::format("cannot create {}: {}", m_cache, failed.message())};
	cli::PartialFile output(entry);
	Result<Prepared> made = run(output.temporaryPath(), tool, amount, mesh);
	if (made)
		if (const std::string problem = output.commit(); !problem.empty()) return Error{problem};
	return made;
}

std::vector<DecimatedMesh> decimate(const Preparation& preparation, const MeshPointer& mesh, int count)
{
	std::vector<DecimatedMesh> ladder(1);
	ladder[0].mesh = mesh;
	for (int i = 1; i < count; ++i)
	{
		const double share = std::pow(kSmallestShare, double(i) / (count - 1));
		const std::size_t triangles = std::size_t(share * double(mesh->triangles.size()));
		Result<Prepared> made = preparation.make("decimate", std::to_string(triangles), *mesh);
		if (!made || made.value().pieces.size() != 1)
		{
			fmt::print(stderr, "a mesh of {} triangles is left out: {}\n", triangles, made ? "no mesh" : made.error());
			continue;
		}
		DecimatedMesh step;
		step.mesh = std::make_shared<ModelMesh>(std::move(made.value().pieces[0]));
		step.share = double(step.mesh->triangles.size()) / double(mesh->triangles.size());
		step.deviation = sampledDeviation(*mesh, *step.mesh);
		step.seconds = made.value().seconds;
		ladder.push_back(std::move(step));
	}
	return ladder;
}

std::vector<std::array<std::size_t, 2>> matchedPairs(const std::vector<DecimatedMesh>& a,
													 const std::vector<DecimatedMesh>& b)
{
	const auto coarsest = [](const std::vector<DecimatedMesh>& ladder, double deviation)
	{
		std::size_t best = 0;
		for (std::size_t i = 0; i < ladder.size(); ++i)
			if (ladder[i].deviation <= deviation && ladder[i].share <= ladder[best].share) best = i;
		return best;
	};
	std::set<std::array<std::size_t, 2>> pairs;
	for (std::size_t i = 0; i < a.size(); ++i) pairs.insert({i, coarsest(b, a[i].deviation)});
	for (std::size_t j = 0; j < b.size(); ++j) pairs.insert({coarsest(a, b[j].deviation), j});
	return {pairs.begin(), pairs.end()};
}
}  // namespace clod::demo
