// SPDX-License-Identifier: Zlib
// Draws triangle meshes, coloured patches over them, contact markers and arrows over a ground grid, into memory. It
// knows neither physics nor scenes: a Frame says all. The same frame gives the same bytes on one machine.
#pragma once
#include <clod/hierarchy/Result.h>
#include <clod/collide/Vector.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "demos/render/Image.h"

namespace clod::demo
{
struct RenderMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<uint32_t, 3>> triangles;
	std::vector<Color> triangleColors;  // empty, or one a triangle; they replace the instance's colour, not its alpha
};

enum class Shading
{
	Smooth,  // normals averaged, but for creases above 40 degrees
	Flat,
};

using MeshId = size_t;

struct Instance
{
	MeshId mesh = 0;
	Transform worldFromMesh;
	Color color = {0.62f, 0.66f, 0.72f, 1};
	bool isTransparent = false;  // drawn after everything opaque: back faces, then front faces; `color.a` facing the
								 // eye, denser towards the outline, so that the shape stays readable
};

struct ColoredTriangle
{
	std::array<Vec3, 3> corners;
	Color color;
};

// Triangles in a body's frame, drawn in front of the surface that they lie on or, by their deviation, near.
struct PatchLayer
{
	Transform worldFromBody;
	std::vector<ColoredTriangle> triangles;
	bool isSeenThrough = true;  // hatched where opaque bodies hide it
	bool isGlass = false;       // what is behind shows through
	double deviation = 0;       // from the surface at most: it hides patches of less, and is not hidden by that surface
};

struct Marker
{
	Vec3 centre;
	double radius = 0;
	Color color = {0.85f, 0.1f, 0.1f, 1};
};

struct Arrow
{
	Vec3 from, to;
	double radius = 0;  // of the shaft
	Color color = {0.85f, 0.1f, 0.1f, 1};
};

struct Camera
{
	Vec3 eye, target;
	double fovy = 35;  // degrees, vertical
	// Length of a picture of `height` pixels per metre, at the target's distance.
	double pixelsPerMetre(int height) const;
};

struct Ground
{
	bool isDrawn = true;
	double height = 0;        // y
	double spacing = 0.01;    // of the grid lines
	double fadeRadius = 0.4;  // where plane and lines have melted into the background, round the camera's target
	bool hasShadows = true;   // the instances' shadows under the key light
};

struct Frame
{
	Camera camera;
	std::vector<Instance> instances;
	std::vector<PatchLayer> patches;
	std::vector<Marker> markers;  // markers and arrows show faintly through what is opaque
	std::vector<Arrow> arrows;
	Ground ground;
};

class Renderer
{
public:
	// Pictures of width x height; each pixel the mean of supersampling x supersampling drawn ones.
	static Result<std::unique_ptr<Renderer>> create(int width, int height, int supersampling = 2);
	~Renderer();
	// Uploads once; an index out of range is an error. Ids count from 0.
	Result<MeshId> addMesh(const RenderMesh& mesh, Shading shading = Shading::Smooth);
	Image render(const Frame& frame);
	int width() const;
	int height() const;

private:
	struct Implementation;
	explicit Renderer(std::unique_ptr<Implementation> implementation);
	std::unique_ptr<Implementation> m_implementation;
};

// Colour of a level: viridis, level 0 (the finest) blue, the last one yellow; readable for the colour-blind.
Color levelColor(int level, int levelCount);
// The same colour a little lighter or darker by index, so that neighbouring patches can be told apart.
Color variedByIndex(const Color& color, size_t index);
// A camera that shows a ball of the given radius round the target, from azimuth (0: from +z, 90: from +x) and
// elevation in degrees.
Camera orbitCamera(const Vec3& target, double radius, double azimuth, double elevation, double fovy = 35);
}  // namespace clod::demo
