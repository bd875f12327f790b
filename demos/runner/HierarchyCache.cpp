// SPDX-License-Identifier: Zlib
// Cache of built hierarchies. The builder is another process: this program links none of it.
#include "demos/runner/HierarchyCache.h"

#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "cli/Files.h"
#include "cli/Length.h"
#include "cli/MeshPath.h"
#include "cli/Program.h"
#include "demos/runner/Process.h"

namespace clod::demo
{
namespace
{
namespace fs = std::filesystem;
using cli::ExitCode;
using cli::Failure;

constexpr std::size_t kMeshSizeLimit = std::size_t(4) << 30;
constexpr std::size_t kBuilderSizeLimit = std::size_t(1) << 30;
constexpr const char* kReportEnding = ".json";  // beside an entry: what the builder did to the mesh

std::string defaultDirectory()
{
	if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && xdg[0] == '/') return std::string(xdg) + "/clod";
	if (const char* home = std::getenv("HOME"); home && home[0]) return std::string(home) + "/.cache/clod";
	return {};
}

void hash(XXH3_state_t* state, const void* data, std::size_t size)
{
	const std::uint64_t length = size;  // between the parts, so that no two lists of parts run together
	XXH3_128bits_update(state, &length, sizeof length);
	XXH3_128bits_update(state, data, size);
}

// Empty where there is none.
nlohmann::json jsonOf(const std::string& path)
{
	const Result<std::vector<std::byte>> bytes = cli::readFile(path, kMeshSizeLimit);
	if (!bytes) return nlohmann::json::object();
	const auto* const text = reinterpret_cast<const char*>(bytes.value().data());
	const auto read = nlohmann::json::parse(text, text + bytes.value().size(), nullptr, false);
	return read.is_object() ? read : nlohmann::json::object();
}

void keepFile(cli::PartialFile& file)
{
	if (const std::string problem = file.commit(); !problem.empty()) throw Failure(ExitCode::failure, problem);
}

// A mesh in memory as a file for the builder; gone with this object, or when the program is interrupted.
class TemporaryMesh
{
public:
	explicit TemporaryMesh(const MeshSource& mesh)
		: m_file(fmt::format("{}/clod-bench-mesh{}", temporaryDirectory(), mesh.extension))
	{
		const std::string problem = cli::writeFile(m_file.temporaryPath(), mesh.bytes);
		if (!problem.empty()) throw Failure(ExitCode::failure, problem);
	}
	const std::string& path() const { return m_file.temporaryPath(); }

private:
	cli::PartialFile m_file;  // never committed
};
}  // namespace

std::string temporaryDirectory()
{
	std::error_code error;
	const fs::path path = fs::temp_directory_path(error);
	return error ? std::string("/tmp") : path.string();
}

std::string builderPath()
{
	std::error_code error;
	const fs::path self = fs::read_symlink("/proc/self/exe", error);
	return (error ? fs::path(".") : self.parent_path()) / "clod-build";
}

HierarchyCache::HierarchyCache(CacheOptions options, bool quiet) : m_options(std::move(options)), m_quiet(quiet)
{
	if (!m_options.enabled)
		m_options.directory.clear();
	else if (m_options.directory.empty())
		m_options.directory = defaultDirectory();
}

std::string HierarchyCache::entryPath(const MeshSource& mesh, const BuildOptions& options) const
{
	const Result<std::vector<std::byte>> builder = cli::readFile(builderPath(), kBuilderSizeLimit);
	if (!builder)
		throw Failure(
			ExitCode::failure,
			fmt::format("no builder beside this program: {}\n  Build the target clod-build, or give .clod files "
						"instead of meshes.",
						builder.error()));
	XXH3_state_t* state = XXH3_createState();
	XXH3_128bits_reset(state);
	hash(state, mesh.bytes.data(), mesh.bytes.size());
	hash(state, mesh.extension.data(), mesh.extension.size());
	hash(state, mesh.part.data(), mesh.part.size());
	hash(state, &options.paper, 1);
	hash(state, &options.repair, 1);
	hash(state, &options.scale, sizeof options.scale);
	hash(state, options.wrap.data(), options.wrap.size());
	hash(state, &options.mostTriangles, sizeof options.mostTriangles);
	hash(state, builder.value().data(), builder.value().size());
	const XXH128_hash_t digest = XXH3_128bits_digest(state);
	XXH3_freeState(state);
	return fmt::format("{}/{:016x}{:016x}.clod", m_options.directory, digest.high64, digest.low64);
}

void HierarchyCache::runBuilder(const std::string& meshPath, const std::string& output, const std::string& report,
								const BuildOptions& options) const
{
	std::vector<std::string> words = {builderPath(), "build", meshPath, "-o", output, "--json", report, "--no-advice"};
	if (options.paper) words.push_back("--paper");
	if (options.repair) words.push_back("--repair");
	if (!options.wrap.empty()) words.insert(words.end(), {"--wrap", options.wrap});
	if (!options.wrap.empty() && options.mostTriangles > 0)
		words.insert(words.end(), {"--most-triangles", fmt::format("{}", options.mostTriangles)});
	if (options.scale != 1) words.insert(words.end(), {"--scale", fmt::format("{}", options.scale)});
	if (m_quiet) words.push_back("--quiet");
	const int code = runProgram(words, m_quiet);
	if (code == 0) return;
	if (code == int(ExitCode::badInput) || code == int(ExitCode::limitReached))
		throw RefusedMesh(ExitCode(code), "the builder refused this mesh (its reason is above)",
						  jsonOf(report).value("mendable", false));
	if (code == kProgramMissing) throw Failure(ExitCode::failure, "cannot run " + words[0]);
	throw Failure(
		ExitCode::failure,
		fmt::format("{} {} {}", words[0], code < 0 ? "was ended by signal" : "failed with exit code", std::abs(code)));
}

// Its file may be gone, of an entry of the cache: nothing is known then.
void HierarchyCache::readChanges(const std::string& report, const Hierarchy& hierarchy)
{
	m_changes.clear();
	const nlohmann::json read = jsonOf(report);
	if (!read.contains("repair") || read["repair"]["changes"].empty()) return;
	const auto& repair = read["repair"];
	m_changes = repair["changes"].get<std::vector<std::string>>();
	const auto moved = [&](const char* way)
	{ return 100 * repair[way]["upper"].get<double>() / double(hierarchy.asset().radius); };
	m_changes.push_back(fmt::format("the surface is within {:.2g} % of the radius of the file's, the file's within "
									"{:.2g} % of it; certified errors are to the surface as it is now",
									moved("added"), moved("lost")));
}

HierarchyPointer HierarchyCache::buildInto(const std::string& entry, const MeshSource& mesh,
										   const BuildOptions& options, bool keep)
{
	std::error_code error;
	fs::create_directories(fs::path(entry).parent_path(), error);
	if (error)
		throw Failure(ExitCode::failure, fmt::format("cannot create the cache directory {}: {}",
													 fs::path(entry).parent_path().string(), error.message()));
	cli::PartialFile partial(entry), report(entry + kReportEnding);
	try
	{
		if (mesh.path.empty())
			runBuilder(TemporaryMesh(mesh).path(), partial.temporaryPath(), report.temporaryPath(), options);
		else
			runBuilder(mesh.part.empty() ? mesh.path : mesh.path + "#" + mesh.part, partial.temporaryPath(),
					   report.temporaryPath(), options);
	}
	catch (const RefusedMesh& refused)
	{
		std::string told = mesh.name + ": " + refused.what();
		if (refused.isMendable && !mesh.path.empty())
		{
			const std::string built = cli::shellWord(cli::nameOf({mesh.path, mesh.part}) + ".clod");
			told += fmt::format("\n  Try: clod-build build {} {} -o {}, and {} in its place", cli::shellWord(mesh.name),
								cli::mendingAfter(options.repair, {}), built, built);
		}
		throw RefusedMesh(refused.code(), told, refused.isMendable);
	}
	catch (const Failure& failure)
	{
		throw Failure(failure.code(), mesh.name + ": " + failure.what());
	}
	Result<HierarchyPointer> hierarchy = Hierarchy::load(partial.temporaryPath());
	if (!hierarchy)
		throw Failure(ExitCode::failure, mesh.name + ": the builder wrote a bad file: " + hierarchy.error());
	readChanges(report.temporaryPath(), *hierarchy.value());
	if (keep && (options.repair || !options.wrap.empty())) keepFile(report);
	if (keep) keepFile(partial);
	++m_built;
	return hierarchy.value();
}

HierarchyPointer HierarchyCache::build(const MeshSource& mesh, const BuildOptions& options)
{
	// A .gltf file refers to others, which the key would not see.
	const bool keep = !m_options.directory.empty() && mesh.extension != ".gltf";
	if (!keep) return buildInto(temporaryDirectory() + "/clod-bench.clod", mesh, options, false);
	const std::string entry = entryPath(mesh, options);
	if (fs::exists(entry))
	{
		Result<HierarchyPointer> hierarchy = Hierarchy::load(entry);
		if (hierarchy)
		{
			++m_found;
			readChanges(entry + kReportEnding, *hierarchy.value());
			return hierarchy.value();
		}
		if (!m_quiet)
			fmt::print(stderr, "the cached hierarchy of {} is damaged and is built again: {}\n", mesh.name,
					   hierarchy.error());
	}
	else if (!m_quiet)
		fmt::print(stderr, "building the hierarchy of {} (kept as {})\n", mesh.name, entry);
	return buildInto(entry, mesh, options, true);
}

HierarchyPointer HierarchyCache::open(const std::string& path, const BuildOptions& options)
{
	const cli::MeshPath mesh = cli::meshPath(path);
	const std::string extension = fs::path(mesh.file).extension().string();
	if (extension == ".clod")
	{
		Result<HierarchyPointer> hierarchy = Hierarchy::load(path);
		if (!hierarchy) throw Failure(ExitCode::badInput, hierarchy.error());
		m_changes.clear();
		if (options.scale != 1)
			throw Failure(ExitCode::usage,
						  fmt::format("{}: a .clod file has its size; build the mesh again with `clod-build build MESH "
									  "--scale {:.6g} -o {}`",
									  path, options.scale, path));
		if (options.paper && !hierarchy.value()->isPaperBuild())
			throw Failure(ExitCode::usage, path + ": --paper needs a file built with `clod-build build --paper`");
		return hierarchy.value();
	}
	if (const std::string problem = cli::notAMesh(mesh.file); !problem.empty())
		throw Failure(ExitCode::badInput, problem + " or .clod");
	Result<std::vector<std::byte>> bytes = cli::readFile(mesh.file, kMeshSizeLimit);
	if (!bytes) throw Failure(ExitCode::badInput, bytes.error());
	return build({path, extension, std::move(bytes.value()), mesh.file, mesh.part}, options);
}

std::vector<ScenePart> partsOf(const std::string& file)
{
	if (!cli::isGltf(file)) return {};
	const cli::PartialFile list(temporaryDirectory() + "/clod-parts.json");  // never committed
	const int code = runProgram({builderPath(), "parts", file, "--quiet", "--json", list.temporaryPath()}, true);
	if (code == int(ExitCode::badInput))
	{
		const std::string other = cli::shellWord(cli::nameOf({file, {}}) + "-exported.obj");
		throw Failure(ExitCode::badInput,
					  fmt::format("{}: no scene can be read of it (the reason is above)\n  Try: assimp export {} {} (Debian's "
								  "assimp-utils), and {}",
								  file, cli::shellWord(file), other, other));
	}
	const Result<std::vector<std::byte>> bytes = cli::readFile(list.temporaryPath(), kMeshSizeLimit);
	if (code != 0 || !bytes) throw Failure(ExitCode::failure, fmt::format("{} parts {} failed", builderPath(), file));
	const auto* const text = reinterpret_cast<const char*>(bytes.value().data());
	const auto report = nlohmann::json::parse(text, text + bytes.value().size());
	std::vector<ScenePart> parts;
	for (const auto& part : report["parts"]) parts.push_back({part["name"], part["faces"], part["radius"]});
	return parts;
}
}  // namespace clod::demo
