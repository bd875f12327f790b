// SPDX-License-Identifier: Zlib
#include "demos/render/DrawGeometry.h"

#include <algorithm>
#include <cmath>

namespace clod::demo
{
namespace
{
constexpr double PI = 3.14159265358979323846;
constexpr double CREASE_COSINE = 0.766;  // of 40 degrees
constexpr int ROUND_SEGMENTS = 20;

uint8_t toByte(float v)
{
	return uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
}

// A unit vector across `axis`.
Vec3 across(const Vec3& axis)
{
	const Vec3 other = std::fabs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
	return normalized(cross(axis, other));
}

struct Corner
{
	Vec3 position, normal;
};

void addTriangle(DrawList& list, const Corner& a, const Corner& b, const Corner& c, const Color& color)
{
	for (const Corner& corner : {a, b, c}) list.push_back(drawVertex(corner.position, corner.normal, color));
}

// The band between two rings round an axis; normals lean by `slope` along it.
struct Band
{
	Vec3 centre[2];
	double radius[2];
	Vec3 axis;
	double slope;
};

void addBand(DrawList& list, const Band& band, const Color& color)
{
	const Vec3 u = across(band.axis), v = cross(band.axis, u);
	const auto corner = [&](int end, int i)
	{
		const double angle = 2 * PI * i / ROUND_SEGMENTS;
		const Vec3 out = std::cos(angle) * u + std::sin(angle) * v;
		return Corner{band.centre[end] + band.radius[end] * out, normalized(out + band.slope * band.axis)};
	};
	for (int i = 0; i < ROUND_SEGMENTS; ++i)
	{
		addTriangle(list, corner(0, i), corner(0, i + 1), corner(1, i + 1), color);
		addTriangle(list, corner(0, i), corner(1, i + 1), corner(1, i), color);
	}
}
}  // namespace

DrawVertex drawVertex(const Vec3& position, const Vec3& normal, const Color& color)
{
	return {{float(position.x), float(position.y), float(position.z)},
			{float(normal.x), float(normal.y), float(normal.z)},
			{toByte(color.r), toByte(color.g), toByte(color.b), toByte(color.a)}};
}

DrawList drawList(const RenderMesh& mesh, Shading shading)
{
	const size_t count = mesh.triangles.size();
	std::vector<Vec3> scaled(count), unit(count);  // normals: by area, and of length 1
	std::vector<uint32_t> starts(mesh.vertices.size() + 1, 0), around(3 * count);
	for (size_t t = 0; t < count; ++t)
	{
		const auto& v = mesh.triangles[t];
		const Vec3 a = mesh.vertices[v[0]];
		scaled[t] = cross(mesh.vertices[v[1]] - a, mesh.vertices[v[2]] - a);
		unit[t] = normalized(scaled[t]);
		for (const uint32_t i : v) ++starts[i + 1];
	}
	for (size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
	std::vector<uint32_t> filled(starts.begin(), starts.end() - 1);
	for (size_t t = 0; t < count; ++t)
		for (const uint32_t i : mesh.triangles[t]) around[filled[i]++] = uint32_t(t);

	DrawList list;
	list.reserve(3 * count);
	for (size_t t = 0; t < count; ++t)
		for (const uint32_t i : mesh.triangles[t])
		{
			Vec3 normal = unit[t];
			if (shading == Shading::Smooth)
			{
				Vec3 sum;
				for (uint32_t k = starts[i]; k < starts[i + 1]; ++k)
					if (dot(unit[around[k]], unit[t]) > CREASE_COSINE) sum += scaled[around[k]];
				if (lengthSquared(sum) > 0) normal = normalized(sum);
			}
			list.push_back(
				drawVertex(mesh.vertices[i], normal, mesh.triangleColors.empty() ? Color{} : mesh.triangleColors[t]));
		}
	return list;
}

void addPatches(DrawList& list, const std::vector<ColoredTriangle>& triangles)
{
	for (const ColoredTriangle& t : triangles)
	{
		const Vec3 normal = normalized(cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
		for (const Vec3& corner : t.corners) list.push_back(drawVertex(corner, normal, t.color));
	}
}

void addBall(DrawList& list, const Marker& marker)
{
	constexpr int BANDS = 10;
	const auto corner = [&](int band, int i)
	{
		const double polar = PI * band / BANDS, turn = 2 * PI * i / ROUND_SEGMENTS;
		const Vec3 out = {std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn)};
		return Corner{marker.centre + marker.radius * out, out};
	};
	for (int band = 0; band < BANDS; ++band)
		for (int i = 0; i < ROUND_SEGMENTS; ++i)
		{
			addTriangle(list, corner(band, i), corner(band + 1, i + 1), corner(band + 1, i), marker.color);
			addTriangle(list, corner(band, i), corner(band, i + 1), corner(band + 1, i + 1), marker.color);
		}
}

void addArrow(DrawList& list, const Arrow& arrow)
{
	const Vec3 way = arrow.to - arrow.from;
	const double total = length(way), head = std::min(0.5 * total, 5 * arrow.radius);
	if (!(total > 0)) return;
	const Vec3 axis = (1 / total) * way, neck = arrow.to - head * axis;
	const double wide = 2.4 * arrow.radius;
	addBand(list, {{arrow.from, arrow.from}, {0, arrow.radius}, axis, -1e3}, arrow.color);
	addBand(list, {{arrow.from, neck}, {arrow.radius, arrow.radius}, axis, 0}, arrow.color);
	addBand(list, {{neck, neck}, {arrow.radius, wide}, axis, -1e3}, arrow.color);
	addBand(list, {{neck, arrow.to}, {wide, 0}, axis, wide / head}, arrow.color);
}
}  // namespace clod::demo
