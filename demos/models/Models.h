// SPDX-License-Identifier: Zlib
// The benchmark models of Otaduy & Lin, "CLODs: Dual Hierarchies for Multiresolution Collision Detection" (SGP 2003),
// rebuilt from formulas: cup, spoon, spiral peg, wrinkled torus, bowl and the digits 0 to 9, at any resolution; plus a
// few plain shapes for tests. Lengths in metres, y up. Every mesh is closed, 2-manifold and wound outward; the same
// arguments give the same bytes.
#pragma once
#include <clod/hierarchy/Result.h>
#include <clod/collide/Vector.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clod::demo
{
struct ModelMesh
{
	std::vector<Vec3> vertices;
	std::vector<std::array<uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// cup, spoon, spiral, torus, bowl, number0 .. number9.
const std::vector<std::string>& modelNames();
// Models beyond the paper's: bolt and nut of the scene bolt-nut, and plain shapes for tests and demos (slab, floor: the
// same of few triangles, landscape: a waved slab, box, sphere, smooth-torus), and the parts of Mechanisms.h.
const std::vector<std::string>& testShapeNames();

// Table 1 of the paper; for a test shape its default count; 0 for an unknown name.
size_t paperTriangleCount(const std::string& name);
// The fewest triangles that still make the shape; 0 for an unknown name.
size_t smallestTriangleCount(const std::string& name);

// The model with the achievable triangle count closest to `triangles` (0: paperTriangleCount). At the paper's counts
// the first five models are exact. The count built is triangles.size() of the result.
Result<ModelMesh> makeModel(const std::string& name, size_t triangles = 0);

// Wavefront OBJ, every digit of every double.
std::string toObj(const ModelMesh& mesh);

// Facts of the shapes that scenes and tests need, in metres.
constexpr double CUP_OUTER_RADIUS = 0.040;
constexpr double CUP_WALL = 0.003;
constexpr double CUP_HEIGHT = 0.090;           // to within 0.1 mm
constexpr double CUP_OPENING_RADIUS = 0.0352;  // inside, at the rim, to within 0.1 mm
constexpr double SPOON_LENGTH = 0.140;
constexpr double SPOON_BOWL_THICKNESS = 0.0015;
constexpr double TORUS_RING_RADIUS = 0.0155;
constexpr double TORUS_TUBE_RADIUS = 0.006;
constexpr double TORUS_WRINKLE = 0.05;  // amplitude over tube radius
constexpr int TORUS_WAVES = 40;
constexpr double SPIRAL_ROD_RADIUS = 0.006;
constexpr double SPIRAL_HEIGHT = 0.240;
// Bolt and nut: the bolt's axis is y, its head's underside at 0; the nut's middle is the origin, and it lies on the
// bolt without touching where its height is a multiple of the lead and both are unturned. Going up by a lead it turns
// by minus one turn about y.
constexpr double BOLT_HEAD_HEIGHT = 0.006, BOLT_HEIGHT = 0.042, NUT_HEIGHT = 0.008, NUT_RADIUS = 0.0107;
constexpr double THREAD_LEAD = 0.008, THREAD_PLAY = 0.00025;  // play: radial, between both threads
constexpr int THREAD_STARTS = 4;
// The landscape is square, this wide and thick; its upper side lies this high over a place.
constexpr double LANDSCAPE_WIDTH = 2, LANDSCAPE_THICKNESS = 0.03;
double landscapeHeight(double x, double z);
// The peg's axis at a height in [0, SPIRAL_HEIGHT], and its unit tangent (upward).
Vec3 spiralAxis(double height);
Vec3 spiralTangent(double height);
}  // namespace clod::demo
