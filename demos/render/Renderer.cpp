// SPDX-License-Identifier: Zlib
// Order of drawing: background, ground, shadows, opaque bodies, coloured patches (first their hidden parts, hatched,
// then the visible ones), markers, transparent bodies, patches half over those, and the same of markers: what hides
// them, be it a body or a patch, is drawn before their faint parts.
#include "demos/render/Renderer.h"

#include <algorithm>
#include <cmath>

#include "demos/render/GlProgram.h"
#include "demos/render/OffscreenContext.h"
#include "demos/render/Shaders.h"

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr float HIDDEN_ALPHA = 0.7f, HIDDEN_MARKER_ALPHA = 0.35f;
constexpr float HATCH = 9;  // pixels from stripe to stripe
constexpr float SHADOW_ALPHA = 0.20f, THIN_SHADOW_ALPHA = 0.09f, VEIL = 0.75f, VEIL_ALPHA = 0.6f, GLASS_ALPHA = 0.6f;
constexpr double kBeyond = 2;  // deviations: one leads to the surface, another as far before it
const Color SKY_TOP = {0.865f, 0.885f, 0.92f, 1}, SKY_BOTTOM = {0.955f, 0.96f, 0.968f, 1};

Matrix4 matrixOf(const Transform& t)
{
	Matrix4 m = {};
	for (int column = 0; column < 3; ++column)
		for (int row = 0; row < 3; ++row) m[size_t(4 * column + row)] = float(t.rotation.row[row][column]);
	for (int row = 0; row < 3; ++row) m[size_t(12 + row)] = float(t.translation[row]);
	m[15] = 1;
	return m;
}

// Perspective times view, computed in double.
Matrix4 cameraMatrix(const Camera& camera, double aspect)
{
	const double distance = length(camera.target - camera.eye);
	const Vec3 back = normalized(camera.eye - camera.target);
	const Vec3 up = std::fabs(back.y) > 0.999 ? Vec3{0, 0, -1} : Vec3{0, 1, 0};
	const Vec3 right = normalized(cross(up, back));
	const Transform viewFromWorld = inverse(Transform{transposed({{right, cross(back, right), back}}), camera.eye});
	const double nearPlane = 0.02 * distance, farPlane = 40 * distance, scale = 1 / std::tan(camera.fovy * PI / 360);
	const double depth = (farPlane + nearPlane) / (nearPlane - farPlane);
	const double shift = 2 * farPlane * nearPlane / (nearPlane - farPlane);
	Matrix4 m = {};
	for (int column = 0; column < 4; ++column)
	{
		const Vec3 v = column < 3 ? viewFromWorld.rotation.column(column) : viewFromWorld.translation;
		m[size_t(4 * column)] = float(scale / aspect * v.x);
		m[size_t(4 * column + 1)] = float(scale * v.y);
		m[size_t(4 * column + 2)] = float(depth * v.z + (column == 3 ? shift : 0));
		m[size_t(4 * column + 3)] = float(-v.z);
	}
	return m;
}

// From over the viewer's left shoulder; it turns with the camera, but not with its tilt.
Vec3 keyLight(const Camera& camera)
{
	Vec3 back = camera.eye - camera.target;
	back.y = 0;
	back = lengthSquared(back) > 0 ? normalized(back) : Vec3{0, 0, 1};
	const Vec3 right = {back.z, 0, -back.x};
	return normalized(-0.55 * right + Vec3{0, 1.1, 0} + 0.45 * back);
}

const Matrix4 IDENTITY = matrixOf(Transform{});
}  // namespace

struct Renderer::Implementation
{
	struct Mesh
	{
		std::unique_ptr<GlBuffer> buffer;
		bool hasColors = false;
	};
	// Patches, markers and arrows of one frame, uploaded for it.
	struct Layer
	{
		std::unique_ptr<GlBuffer> buffer;
		Transform worldFromMesh;
		float flatness = 0, closer = 0;
		bool isPatch = false, isSeenThrough = true, isGlass = false;
	};

	std::unique_ptr<OffscreenContext> context;
	std::unique_ptr<GlProgram> solid, plane;
	std::vector<Mesh> meshes;
	int width = 0, height = 0, supersampling = 1;
	Vec3 toLight = {0, 1, 0};

	~Implementation()
	{
		// What the context owns goes before it.
		context->makeCurrent();
		meshes.clear();
		solid.reset();
		plane.reset();
	}

	void drawBackground(const Camera& camera, const Ground& ground, const Matrix4& clipFromWorld) const;
	void drawShadows(const Frame& frame) const;
	void drawInstance(const Instance& instance) const;
	void drawTransparent(const Frame& frame) const;
	std::vector<Layer> upload(const Frame& frame) const;
	enum class Pass
	{
		Hidden,  // the parts behind what is opaque: of patches hatched, or these would seem to lie before it; markers faint
		Visible,
		ThroughVeil  // the visible parts once more over transparent bodies, so that these hardly tint the colours
	};
	enum class Kind
	{
		Patches,
		Markers
	};
	void drawLayers(const std::vector<Layer>& layers, Kind kind, Pass pass) const;
};

void Renderer::Implementation::drawBackground(const Camera& camera, const Ground& ground,
											  const Matrix4& clipFromWorld) const
{
	const auto quad = [](const std::array<Vec3, 4>& corners, const std::array<Color, 4>& colors)
	{
		DrawList list;
		for (const size_t i : {0, 1, 2, 0, 2, 3}) list.push_back(drawVertex(corners[i], {0, 1, 0}, colors[i]));
		return list;
	};
	glDisable(GL_DEPTH_TEST);
	glDepthMask(GL_FALSE);
	plane->use();
	plane->set("clipFromWorld", IDENTITY);
	plane->set("spacing", 0.0f);
	GlBuffer(quad({{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}}, {SKY_BOTTOM, SKY_BOTTOM, SKY_TOP, SKY_TOP}))
		.draw();
	if (ground.isDrawn && camera.eye.y > ground.height)
	{
		const double r = ground.fadeRadius, x = camera.target.x, z = camera.target.z, y = ground.height;
		plane->set("clipFromWorld", clipFromWorld);
		plane->set("spacing", float(ground.spacing));
		plane->set("fadeRadius", float(r));
		plane->set("centre", float(x), float(z));
		plane->set("lineWidth", 0.5f * float(supersampling));
		GlBuffer(quad({{{x - r, y, z - r}, {x - r, y, z + r}, {x + r, y, z + r}, {x + r, y, z - r}}}, {})).draw();
	}
	glDepthMask(GL_TRUE);
}

void Renderer::Implementation::drawShadows(const Frame& frame) const
{
	if (!frame.ground.isDrawn || !frame.ground.hasShadows || frame.camera.eye.y <= frame.ground.height) return;
	// Each pixel is darkened once; the ground has no depth, bodies are drawn over it later.
	glEnable(GL_STENCIL_TEST);
	glStencilFunc(GL_EQUAL, 0, 0xff);
	glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
	solid->set("isShadow", true);
	solid->set("shadowHeight", float(frame.ground.height));
	for (const bool isTransparent : {false, true})
		for (const Instance& instance : frame.instances)
		{
			if (instance.isTransparent != isTransparent) continue;
			solid->set("baseColor", Color{0.05f, 0.06f, 0.1f, isTransparent ? THIN_SHADOW_ALPHA : SHADOW_ALPHA});
			solid->set("worldFromMesh", matrixOf(instance.worldFromMesh));
			meshes[instance.mesh].buffer->draw();
		}
	solid->set("isShadow", false);
	glDisable(GL_STENCIL_TEST);
}

void Renderer::Implementation::drawInstance(const Instance& instance) const
{
	const Mesh& mesh = meshes[instance.mesh];
	Color color = instance.color;
	if (!instance.isTransparent) color.a = 1;
	solid->set("baseColor", color);
	solid->set("useVertexColor", mesh.hasColors);
	solid->set("veil", instance.isTransparent ? VEIL : 0.0f);
	solid->set("flatness", 0.0f);
	solid->set("worldFromMesh", matrixOf(instance.worldFromMesh));
	mesh.buffer->draw();
}

void Renderer::Implementation::drawTransparent(const Frame& frame) const
{
	std::vector<const Instance*> sorted;
	for (const Instance& instance : frame.instances)
		if (instance.isTransparent) sorted.push_back(&instance);
	const auto distance = [&](const Instance* i)
	{ return lengthSquared(i->worldFromMesh.translation - frame.camera.eye); };
	std::stable_sort(sorted.begin(), sorted.end(),
					 [&](const Instance* a, const Instance* b) { return distance(a) > distance(b); });
	glDepthMask(GL_FALSE);
	glEnable(GL_CULL_FACE);
	for (const Instance* instance : sorted)
		for (const GLenum hidden : {GL_FRONT, GL_BACK})
		{
			glCullFace(hidden);
			drawInstance(*instance);
		}
	glDisable(GL_CULL_FACE);
	glDepthMask(GL_TRUE);
}

std::vector<Renderer::Implementation::Layer> Renderer::Implementation::upload(const Frame& frame) const
{
	std::vector<Layer> layers;
	for (const PatchLayer& patches : frame.patches)
	{
		DrawList list;
		addPatches(list, patches.triangles);
		if (list.empty()) continue;
		layers.push_back({std::make_unique<GlBuffer>(list), patches.worldFromBody, 0.55f,
						  float(kBeyond * patches.deviation), true, patches.isSeenThrough, patches.isGlass});
	}
	DrawList list;
	for (const Marker& marker : frame.markers) addBall(list, marker);
	for (const Arrow& arrow : frame.arrows) addArrow(list, arrow);
	if (!list.empty()) layers.push_back({std::make_unique<GlBuffer>(list), Transform{}, 0.25f, 0, false, true});
	return layers;
}

void Renderer::Implementation::drawLayers(const std::vector<Layer>& layers, Kind kind, Pass pass) const
{
	const bool isHidden = pass == Pass::Hidden;
	if (isHidden)
	{
		// One faint layer a pixel, behind what has been drawn.
		glClear(GL_STENCIL_BUFFER_BIT);
		glEnable(GL_STENCIL_TEST);
		glStencilFunc(GL_EQUAL, 0, 0xff);
		glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
		glDepthFunc(GL_GREATER);
		glDepthMask(GL_FALSE);
	}
	solid->set("useVertexColor", true);
	solid->set("veil", 0.0f);
	const bool isHatched = isHidden && kind == Kind::Patches;
	const float hiddenAlpha = isHatched ? HIDDEN_ALPHA : HIDDEN_MARKER_ALPHA;
	solid->set("baseColor", Color{0, 0, 0, isHidden ? hiddenAlpha : pass == Pass::Visible ? 1.0f : VEIL_ALPHA});
	solid->set("hatch", isHatched ? HATCH * float(supersampling) : 0.0f);
	glEnable(GL_POLYGON_OFFSET_FILL);
	const auto draw = [&](const Layer& layer)
	{
		glPolygonOffset(layer.isPatch ? -1.0f : 0.0f, layer.isPatch ? -8.0f : 0.0f);
		solid->set("flatness", layer.flatness);
		solid->set("closer", layer.closer);
		solid->set("worldFromMesh", matrixOf(layer.worldFromMesh));
		layer.buffer->draw();
	};
	const auto isOfKind = [&](const Layer& layer) { return layer.isPatch == (kind == Kind::Patches); };
	for (const Layer& layer : layers)
		if (isOfKind(layer) && (isHidden ? layer.isSeenThrough : !layer.isGlass)) draw(layer);
	if (pass == Pass::ThroughVeil)
	{
		solid->set("baseColor", Color{0, 0, 0, GLASS_ALPHA});
		glDepthMask(GL_FALSE);
		for (const Layer& layer : layers)
			if (isOfKind(layer) && layer.isGlass) draw(layer);
	}
	solid->set("hatch", 0.0f);
	solid->set("closer", 0.0f);
	glDisable(GL_POLYGON_OFFSET_FILL);
	glDisable(GL_STENCIL_TEST);
	glDepthFunc(GL_LEQUAL);
	glDepthMask(GL_TRUE);
}

Renderer::Renderer(std::unique_ptr<Implementation> implementation) : m_implementation(std::move(implementation)) {}
Renderer::~Renderer() = default;
int Renderer::width() const
{
	return m_implementation->width;
}
int Renderer::height() const
{
	return m_implementation->height;
}

Result<std::unique_ptr<Renderer>> Renderer::create(int width, int height, int supersampling)
{
	if (width < 1 || height < 1 || supersampling < 1 || width > 8192 || height > 8192 || supersampling > 4)
		return Error{"Pictures of " + std::to_string(width) + " x " + std::to_string(height) + " with " +
					 std::to_string(supersampling) + "-fold supersampling are out of range (1 to 8192, 1 to 4)."};
	auto context = makeOsMesaContext(width * supersampling, height * supersampling);
	if (!context) return Error{context.error()};
	auto implementation = std::make_unique<Implementation>();
	implementation->context = std::move(*context);
	auto solid = GlProgram::create(SOLID_VERTEX_SHADER, SOLID_FRAGMENT_SHADER);
	auto plane = GlProgram::create(PLANE_VERTEX_SHADER, PLANE_FRAGMENT_SHADER);
	if (!solid) return Error{solid.error()};
	if (!plane) return Error{plane.error()};
	implementation->solid = std::move(*solid);
	implementation->plane = std::move(*plane);
	implementation->width = width;
	implementation->height = height;
	implementation->supersampling = supersampling;
	return std::unique_ptr<Renderer>(new Renderer(std::move(implementation)));
}

Result<MeshId> Renderer::addMesh(const RenderMesh& mesh, Shading shading)
{
	for (size_t t = 0; t < mesh.triangles.size(); ++t)
		for (const uint32_t v : mesh.triangles[t])
			if (v >= mesh.vertices.size())
				return Error{"Triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + " of " +
							 std::to_string(mesh.vertices.size()) + "."};
	if (!mesh.triangleColors.empty() && mesh.triangleColors.size() != mesh.triangles.size())
		return Error{std::to_string(mesh.triangleColors.size()) + " triangle colours for " +
					 std::to_string(mesh.triangles.size()) + " triangles."};
	Implementation& r = *m_implementation;
	r.context->makeCurrent();
	r.meshes.push_back({std::make_unique<GlBuffer>(drawList(mesh, shading)), !mesh.triangleColors.empty()});
	return r.meshes.size() - 1;
}

Image Renderer::render(const Frame& frame)
{
	Implementation& r = *m_implementation;
	r.context->makeCurrent();
	glViewport(0, 0, r.context->width(), r.context->height());
	glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
	glEnable(GL_BLEND);
	glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE);
	glDepthFunc(GL_LEQUAL);
	r.toLight = keyLight(frame.camera);
	const Matrix4 clipFromWorld = cameraMatrix(frame.camera, double(r.width) / r.height);
	r.drawBackground(frame.camera, frame.ground, clipFromWorld);
	r.solid->use();
	r.solid->set("clipFromWorld", clipFromWorld);
	r.solid->set("eye", frame.camera.eye);
	r.solid->set("toLight", r.toLight);
	r.solid->set("isShadow", false);
	r.drawShadows(frame);
	glEnable(GL_DEPTH_TEST);
	for (const Instance& instance : frame.instances)
		if (!instance.isTransparent) r.drawInstance(instance);
	const std::vector<Implementation::Layer> layers = r.upload(frame);
	using Kind = Implementation::Kind;
	using Pass = Implementation::Pass;
	r.drawLayers(layers, Kind::Patches, Pass::Hidden);
	r.drawLayers(layers, Kind::Patches, Pass::Visible);
	r.drawLayers(layers, Kind::Markers, Pass::Visible);
	r.drawTransparent(frame);
	r.drawLayers(layers, Kind::Patches, Pass::ThroughVeil);
	r.drawLayers(layers, Kind::Markers, Pass::Hidden);
	r.drawLayers(layers, Kind::Markers, Pass::ThroughVeil);
	return reduced(r.context->pixels(), r.supersampling);
}
}  // namespace clod::demo
