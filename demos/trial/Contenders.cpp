// SPDX-License-Identifier: Zlib
#include "demos/trial/Contenders.h"

#include <fmt/format.h>

#include "demos/scenes/BulletShapes.h"

namespace clod::demo
{
namespace
{
// Okabe & Ito's, told apart by colour-blind readers too.
constexpr const char* kOurColor = "#000000";
constexpr const char* kGimpactColor = "#D55E00";
constexpr const char* kHullColor = "#0072B2";
constexpr const char* kPiecesColor = "#009E73";

// The floor is a box, so its hull is exact: everybody gets that.
Contender peer(const Trial& trial, const char* name, const std::string& setting, const char* color)
{
	Contender contender{name, setting, color, {}, {}};
	contender.drawn.resize(trial.models.size());
	const double margin = kPeerMarginShare * trial.smallest;
	for (const ModelMesh& surface : trial.surfaces)
		contender.shapes.push_back({SceneShape::Kind::hulls, {convexHullOf(surface)}, margin});
	return contender;
}

Contender gimpactOf(const Trial& trial)
{
	Contender contender = peer(trial, "GImpact", "btGImpactMeshShape, full meshes", kGimpactColor);
	for (std::size_t model = 1; model < trial.models.size(); ++model)
	{
		contender.shapes[model].kind = SceneShape::Kind::gimpact;
		contender.shapes[model].meshes = {trial.surfaces[model]};
	}
	return contender;
}

Contender hullOf(const Trial& trial)
{
	Contender contender = peer(trial, "convex hull", "btConvexHullShape, one a mesh", kHullColor);
	for (std::size_t model = 1; model < trial.models.size(); ++model)
		contender.drawn[model] = contender.shapes[model].meshes;
	return contender;
}
}  // namespace

void addContenders(Trial& trial, const Preparation& preparation,
				   const std::function<void(const std::string&, double)>& progress)
{
	trial.contenders.push_back({"CLOD", "certified to 0.5 % of the radius, the default", kOurColor, {}, {}});
	trial.contenders.push_back(gimpactOf(trial));
	const auto leaveOut = [&](const std::string& reason) { trial.leftOut.push_back({"V-HACD", reason}); };
	Contender pieces =
		peer(trial, "V-HACD", fmt::format("btCompoundShape of at most {} hulls a mesh", kTrialHulls), kPiecesColor);
	bool isWhole = preparation.tools().canPrepare();
	if (!isWhole) leaveOut("its tool is not set up; run scripts/peers, then this command again");
	for (std::size_t model = 1; isWhole && model < trial.models.size(); ++model)
	{
		progress("convex decompositions", double(model - 1) / double(trial.models.size() - 1));
		const Result<Prepared> made = preparation.make("vhacd", std::to_string(kTrialHulls), trial.surfaces[model]);
		if (!made) leaveOut(made.error());
		isWhole = bool(made);
		if (made) pieces.shapes[model].meshes = pieces.drawn[model] = made.value().pieces;
	}
	if (isWhole) trial.contenders.push_back(std::move(pieces));
	trial.contenders.push_back(hullOf(trial));
}
}  // namespace clod::demo
