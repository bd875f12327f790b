// SPDX-License-Identifier: Zlib
// Triangles as the graphics library takes them: three vertices each, with normal and colour.
#pragma once
#include <cstdint>
#include <vector>

#include "demos/render/Renderer.h"

namespace clod::demo
{
struct DrawVertex
{
	float position[3];
	float normal[3];
	uint8_t color[4];
};
static_assert(sizeof(DrawVertex) == 28, "three of these are one triangle in the vertex buffer, without padding");
using DrawList = std::vector<DrawVertex>;

DrawVertex drawVertex(const Vec3& position, const Vec3& normal, const Color& color);
DrawList drawList(const RenderMesh& mesh, Shading shading);
void addPatches(DrawList& list, const std::vector<ColoredTriangle>& triangles);
void addBall(DrawList& list, const Marker& marker);
void addArrow(DrawList& list, const Arrow& arrow);
}  // namespace clod::demo
