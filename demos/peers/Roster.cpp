// SPDX-License-Identifier: Zlib
// Makes every method that takes part.
#include "demos/peers/Roster.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "cli/Failure.h"
#include "demos/peers/CoalPeer.h"
#include "demos/runner/Commands.h"
#include "demos/runner/Replay.h"

namespace clod::demo
{
namespace
{
constexpr const char* kConcavities[] = {"0.1", "0.05", "0.02"};   // CoACD thresholds

class RosterMaker
{
public:
	using Say = std::function<void(const std::string&, double)>;
	RosterMaker(const RosterModels& models, HierarchyCache& cache, const Preparation& preparation,
				const RosterOptions& options, const Say& progress)
		: m_models(models), m_cache(cache), m_preparation(preparation), m_options(options), m_progress(progress)
	{
		m_meshA = std::make_shared<ModelMesh>(inputSurface(*models.a));
		m_meshB = std::make_shared<ModelMesh>(inputSurface(*models.b));
	}

	Roster make()
	{
		addOurs();
		decimateMeshes();
		addMeshPeers();
		addHulls();
		addDecimatedExact();
		return std::move(m_roster);
	}

private:
	bool has(const char* family) const { return m_options.has(family); }
	void leaveOut(const std::string& what, const std::string& reason) { m_roster.leftOut.push_back({what, reason}); }

	PeerInfo info(const char* family, const std::string& setting) const
	{
		PeerInfo result;
		result.family = family;
		result.setting = setting;
		return result;
	}

	void addOurs()
	{
		const double radius = smallerRadius(*m_models.a, *m_models.b);
		for (const Threshold& threshold : thresholdLadder(m_options.own, radius))
		{
			PeerInfo own = info("clod", threshold.label);
			own.buildSeconds = m_models.buildSeconds;
			own.sizeA = m_meshA->triangles.size();
			own.sizeB = m_meshB->triangles.size();
			const bool isOfContacts = threshold.gapError == kOff;
			if (isOfContacts && has("clod"))
				m_roster.peers.push_back(clodQuery(own, m_models.a, m_models.b, threshold, ClodQuestion::contacts));
			own.family = "clod-gap";
			if (has("clod-gap"))
				m_roster.peers.push_back(clodQuery(own, m_models.a, m_models.b, threshold, ClodQuestion::gap));
			own.family = "clod-dispatch";
			if (isOfContacts && has("clod-dispatch"))
				m_roster.peers.push_back(clodDispatch(own, m_models.a, m_models.b, threshold, m_options.frame));
		}
	}

	// Only the full meshes where no tool decimates.
	void decimateMeshes()
	{
		const bool can = m_preparation.tools().canPrepare();
		if (!can && m_options.decimations > 1)
			leaveOut("decimated meshes",
					 "no tools in " + m_preparation.tools().directory + "; scripts/peers sets them up");
		const int count = can ? m_options.decimations : 1;
		m_progress("decimating", 0);
		m_ladderA = decimate(m_preparation, m_meshA, count);
		m_progress("decimating", 0.5);
		m_ladderB = decimate(m_preparation, m_meshB, count);
		m_pairs = matchedPairs(m_ladderA, m_ladderB);
		for (const auto& [name, ladder] : {std::pair("a", &m_ladderA), std::pair("b", &m_ladderB)})
			for (const DecimatedMesh& step : *ladder)
				m_roster.preparation["decimated"][name].push_back({{"triangles", step.mesh->triangles.size()},
																   {"share", step.share},
																   {"sampled_deviation", step.deviation},
																   {"seconds", step.seconds}});
	}

	template <class Add>
	void forEachPair(const Add& add) const
	{
		for (const auto& [i, j] : m_pairs)
		{
			const DecimatedMesh &a = m_ladderA[i], &b = m_ladderB[j];
			const std::string setting =
				i + j == 0 ? std::string("full") : fmt::format("{:.3g} % x {:.3g} %", 100 * a.share, 100 * b.share);
			add(a, b, setting);
		}
	}

	void addMeshPeers()
	{
		const std::string program = m_preparation.tools().coal();
		const bool canCoal = m_preparation.tools().hasCoal();
		if (!canCoal && (has("coal-distance") || has("coal-contacts")))
			leaveOut("coal", "no " + program + "; scripts/peers builds it");
		const auto add = [&](const DecimatedMesh& a, const DecimatedMesh& b, const std::string& setting)
		{
			std::vector<PeerPointer>& peers = m_roster.peers;
			if (has("gimpact")) peers.push_back(gimpact(info("gimpact", setting), *a.mesh, *b.mesh, m_options.frame));
			if (has("bvh-gimpact"))
				peers.push_back(bvhGimpact(info("bvh-gimpact", setting), *a.mesh, *b.mesh, m_options.frame));
			if (canCoal && has("coal-distance"))
				peers.push_back(coal(info("coal-distance", setting), program, a.mesh, b.mesh, CoalQuestion::distance,
									 m_options.frame.worldScale));
			if (canCoal && has("coal-contacts"))
				peers.push_back(coal(info("coal-contacts", setting), program, a.mesh, b.mesh, CoalQuestion::allContacts,
									 m_options.frame.worldScale));
		};
		forEachPair(add);
	}

	void addCompound(const char* tool, const std::string& amount, const std::string& setting)
	{
		const Result<Prepared> a = m_preparation.make(tool, amount, *m_meshA);
		const Result<Prepared> b = a ? m_preparation.make(tool, amount, *m_meshB) : Result<Prepared>(Error{a.error()});
		if (!b) return leaveOut(fmt::format("{} {}", tool, setting), b.error());
		PeerInfo peer = info(tool, setting);
		peer.buildSeconds = a.value().seconds + b.value().seconds;
		m_roster.peers.push_back(compounds(peer, a.value().pieces, b.value().pieces, m_options.frame));
	}

	void addHulls()
	{
		if (!has("vhacd") && !has("coacd")) return;
		if (!m_preparation.tools().canPrepare())
			return leaveOut("vhacd, coacd",
							"no tools in " + m_preparation.tools().directory + "; scripts/peers sets them up");
		double done = 0;
		for (const int hulls : m_options.hullCounts)
		{
			m_progress("convex decompositions", done++ / 10);
			if (has("vhacd")) addCompound("vhacd", std::to_string(hulls), fmt::format("at most {} hulls", hulls));
		}
		for (const char* concavity : kConcavities)
		{
			m_progress("convex decompositions", done++ / 10);
			if (has("coacd")) addCompound("coacd", concavity, fmt::format("concavity {}", concavity));
		}
	}

	// Each decimated mesh through the builder: our exact query without any choice of level.
	BuiltHierarchy hierarchyOf(const DecimatedMesh& step) const
	{
		return buildTimed(m_cache, meshSource("decimated mesh", *step.mesh));
	}

	std::vector<BuiltHierarchy> buildLadder(const std::vector<DecimatedMesh>& ladder, const HierarchyPointer& full,
											const std::string& body)
	{
		std::vector<BuiltHierarchy> built = {{full, m_models.buildSeconds}};
		for (std::size_t i = 1; i < ladder.size(); ++i)
		{
			m_progress("building decimated hierarchies of " + body, double(i) / double(ladder.size()));
			try
			{
				built.push_back(hierarchyOf(ladder[i]));
			}
			catch (const cli::Failure& failure)
			{
				built.push_back({nullptr, 0});
				leaveOut(fmt::format("decimated-exact, {} at {:.3g} %", body, 100 * ladder[i].share), failure.what());
			}
		}
		return built;
	}

	void addDecimatedExact()
	{
		if (!has("decimated-exact") || m_pairs.size() < 2) return;
		const std::vector<BuiltHierarchy> a = buildLadder(m_ladderA, m_models.a, "A"),
										  b = buildLadder(m_ladderB, m_models.b, "B");
		Threshold exact;
		exact.metric.exact = true;
		for (const auto& [i, j] : m_pairs)
		{
			if (!a[i].hierarchy || !b[j].hierarchy) continue;
			PeerInfo own = info(
				"decimated-exact",
				i + j == 0 ? std::string("full")
						   : fmt::format("{:.3g} % x {:.3g} %", 100 * m_ladderA[i].share, 100 * m_ladderB[j].share));
			own.buildSeconds = a[i].seconds + b[j].seconds + m_ladderA[i].seconds + m_ladderB[j].seconds;
			m_roster.peers.push_back(clodQuery(own, a[i].hierarchy, b[j].hierarchy, exact, ClodQuestion::gap));
		}
	}

	const RosterModels& m_models;
	HierarchyCache& m_cache;
	const Preparation& m_preparation;
	const RosterOptions& m_options;
	const Say& m_progress;
	MeshPointer m_meshA, m_meshB;
	std::vector<DecimatedMesh> m_ladderA, m_ladderB;
	std::vector<std::array<std::size_t, 2>> m_pairs;
	Roster m_roster;
};
}  // namespace

bool RosterOptions::has(const char* family) const
{
	return families.empty() || std::find(families.begin(), families.end(), family) != families.end();
}

Roster makeRoster(const RosterModels& models, HierarchyCache& cache, const Preparation& preparation,
				  const RosterOptions& options, const std::function<void(const std::string&, double)>& progress)
{
	return RosterMaker(models, cache, preparation, options, progress).make();
}

BuiltHierarchy buildTimed(HierarchyCache& cache, const MeshSource& source)
{
	const int before = cache.built();
	const auto start = std::chrono::steady_clock::now();
	BuiltHierarchy result{cache.build(source, {}), 0};
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	result.seconds = cache.built() > before ? seconds : std::numeric_limits<double>::quiet_NaN();
	return result;
}
}  // namespace clod::demo
