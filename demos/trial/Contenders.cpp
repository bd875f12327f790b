// SPDX-License-Identifier: Zlib
#include "demos/trial/Contenders.h"

#include "demos/peers/PeerShapes.h"

namespace clod::demo
{
namespace
{
// Okabe & Ito's, told apart by colour-blind readers too.
constexpr const char* kOurColor = "#000000";
constexpr const char* kGimpactColor = "#D55E00";
constexpr const char* kHullColor = "#0072B2";
constexpr const char* kPiecesColor = "#009E73";

void add(Trial& trial, const char* name, const std::string& kind, const char* color, const Preparation& preparation,
		 const std::function<void(const std::string&, double)>& progress)
{
	Result<std::vector<SceneShape>> shapes =
		peerShapes(kind, trial.surfaces, movingModels(trial.scene), kPeerMarginShare * trial.smallest, preparation, progress);
	if (!shapes)
	{
		trial.leftOut.push_back({name, shapes.error()});
		return;
	}
	Contender contender{name, describePeerShape(kind), color, std::move(shapes.value()), {}};
	contender.drawn.resize(trial.models.size());
	for (std::size_t model = 1; kind != "gimpact" && model < trial.models.size(); ++model)
		contender.drawn[model] = contender.shapes[model].meshes;
	trial.contenders.push_back(std::move(contender));
}
}  // namespace

void addContenders(Trial& trial, const Preparation& preparation,
				   const std::function<void(const std::string&, double)>& progress)
{
	trial.contenders.push_back({"CLOD", "certified to 0.5 % of the radius, the default", kOurColor, {}, {}});
	add(trial, "GImpact", "gimpact", kGimpactColor, preparation, progress);
	add(trial, "V-HACD", "vhacd", kPiecesColor, preparation, progress);
	add(trial, "convex hull", "hull", kHullColor, preparation, progress);
}
}  // namespace clod::demo
