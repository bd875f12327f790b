// SPDX-License-Identifier: Zlib
#include "demos/peers/PeerShapes.h"

#include <LinearMath/btConvexHullComputer.h>
#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "demos/models/Sweep.h"
#include "demos/scenes/BulletPose.h"

namespace clod::demo
{
namespace
{
constexpr double kConvex = 1e-4;  // a hull of no more volume than this beyond the mesh's is the mesh

// A kind taken apart: whether static models keep their triangles, and prepare.py's tool and amount, where one is
// needed.
struct PeerKind
{
	bool hasStaticTrees;
	std::string shape, amount;
};
PeerKind kindOf(const std::string& name)
{
	constexpr std::string_view kTrees = "bvh-";
	const bool hasTrees = name.compare(0, kTrees.size(), kTrees) == 0;
	std::string shape = hasTrees ? name.substr(kTrees.size()) : name;
	if (const std::size_t colon = shape.find(':'); colon != std::string::npos)
		return {hasTrees, shape.substr(0, colon), shape.substr(colon + 1)};
	if (shape == "vhacd") return {hasTrees, shape, std::to_string(kPeerHulls)};
	if (shape == "coacd") return {hasTrees, shape, fmt::format("{:g}", kPeerConcavity)};
	return {hasTrees, shape, {}};
}
}  // namespace

std::string describePeerShape(const std::string& name)
{
	const auto [hasStaticTrees, kind, amount] = kindOf(name);
	if (hasStaticTrees) return describePeerShape(kind) + "; btBvhTriangleMeshShape for what stands still";
	if (kind == "gimpact") return "btGImpactMeshShape, full meshes";
	if (kind == "vhacd") return "btCompoundShape of at most " + amount + " hulls a mesh";
	if (kind == "coacd") return "btCompoundShape of hulls, concavity " + amount;
	return "btConvexHullShape, one a mesh";
}

ModelMesh convexHullOf(const ModelMesh& mesh)
{
	std::vector<double> coordinates;
	for (const Vec3& vertex : mesh.vertices) coordinates.insert(coordinates.end(), {vertex.x, vertex.y, vertex.z});
	btConvexHullComputer computer;
	computer.compute(coordinates.data(), 3 * int(sizeof(double)), int(mesh.vertices.size()), 0, 0);
	ModelMesh hull;
	for (int i = 0; i < computer.vertices.size(); ++i) hull.vertices.push_back(fromBullet(computer.vertices[i]));
	for (int i = 0; i < computer.faces.size(); ++i)
	{
		// A fan round the first corner; Bullet's faces go round clockwise.
		const btConvexHullComputer::Edge* const first = &computer.edges[computer.faces[i]];
		const std::uint32_t corner = std::uint32_t(first->getSourceVertex());
		for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != int(corner);
			 edge = edge->getNextEdgeOfFace())
			hull.triangles.push_back(
				{corner, std::uint32_t(edge->getTargetVertex()), std::uint32_t(edge->getSourceVertex())});
	}
	return hull;
}

Result<std::vector<SceneShape>> peerShapes(const std::string& name, const std::vector<ModelMesh>& surfaces,
										   const std::vector<bool>& moves, double margin,
										   const Preparation& preparation,
										   const std::function<void(const std::string&, double)>& progress)
{
	const PeerKind kind = kindOf(name);
	if (!kind.amount.empty() && !preparation.tools().canPrepare())
		return Error{"its tool is not set up; run scripts/peers, then this command again"};
	std::vector<SceneShape> shapes;
	for (std::size_t model = 0; model < surfaces.size(); ++model)
	{
		const ModelMesh& surface = surfaces[model];
		shapes.push_back({SceneShape::Kind::hulls, {convexHullOf(surface)}, margin});
		SceneShape& shape = shapes.back();
		if (std::fabs(signedVolume(shape.meshes.front())) <= (1 + kConvex) * std::fabs(signedVolume(surface))) continue;
		const bool isTree = kind.hasStaticTrees && !moves[model];
		if (isTree || kind.shape == "gimpact")
		{
			shape.kind = isTree ? SceneShape::Kind::bvh : SceneShape::Kind::gimpact;
			shape.meshes = {surface};
		}
		else if (!kind.amount.empty())
		{
			progress("convex decompositions", double(model) / double(surfaces.size()));
			Result<Prepared> made = preparation.make(kind.shape, kind.amount, surface);
			if (!made) return Error{made.error()};
			shape.meshes = std::move(made.value().pieces);
		}
	}
	return shapes;
}

std::vector<bool> movingModels(const SceneDefinition& scene)
{
	std::vector<bool> moves(scene.info.models.size());
	for (std::size_t i = 0; i < scene.bodies.size(); ++i)
		if (scene.bodies[i].mass > 0 || scene.bodies[i].course) moves[scene.info.bodies[i].model] = true;
	return moves;
}
}  // namespace clod::demo
