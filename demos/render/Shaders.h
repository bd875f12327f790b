// SPDX-License-Identifier: Zlib
// The two GLSL 1.20 programs: one for everything solid, lit by a key light, a weaker one from the other side, and the
// sky; one for the ground plane and the background.
#pragma once

namespace clod::demo
{
// Solid things. `shadowHeight`: where `isShadow`, the point slides along the light down to this height. `closer`: so far
// towards the eye a point counts as lying, where something else might hide it.
constexpr const char* SOLID_VERTEX_SHADER = R"(#version 120
attribute vec3 position;
attribute vec3 normal;
attribute vec4 color;
uniform mat4 clipFromWorld;
uniform mat4 worldFromMesh;
uniform vec3 toLight;
uniform bool isShadow;
uniform float shadowHeight;
uniform vec3 eye;
uniform float closer;
varying vec3 worldPosition;
varying vec3 worldNormal;
varying vec4 vertexColor;
void main()
{
	vec4 world = worldFromMesh * vec4(position, 1.0);
	float above = world.y - shadowHeight;
	if (isShadow) world.xyz -= toLight * (above / toLight.y);
	worldPosition = isShadow ? vec3(world.x, above, world.z) : world.xyz;
	worldNormal = mat3(worldFromMesh) * normal;
	vertexColor = color;
	gl_Position = clipFromWorld * world;
	if (closer > 0.0)
	{
		vec3 toEye = eye - world.xyz;
		vec4 nearer = clipFromWorld * vec4(world.xyz + min(closer / length(toEye), 0.5) * toEye, 1.0);
		gl_Position.z = nearer.z / nearer.w * gl_Position.w;
	}
}
)";

// `useVertexColor`: the triangle's colour instead of `baseColor`; `flatness`: 0 fully shaded, 1 the plain colour;
// `veil`: how much denser than `baseColor.a` a surface seen from the side is; `hatch`: every so many drawn pixels a
// stripe of `baseColor.a` (0: all over), paler between.
constexpr const char* SOLID_FRAGMENT_SHADER = R"(#version 120
uniform vec3 eye;
uniform vec3 toLight;
uniform vec4 baseColor;
uniform bool useVertexColor;
uniform bool isShadow;
uniform float flatness;
uniform float veil;
uniform float hatch;
varying vec3 worldPosition;
varying vec3 worldNormal;
varying vec4 vertexColor;
void main()
{
	if (isShadow)
	{
		if (worldPosition.y < 0.0) discard;
		gl_FragColor = baseColor;
		return;
	}
	vec3 toEye = normalize(eye - worldPosition);
	vec3 n = normalize(worldNormal);
	if (dot(n, toEye) < 0.0) n = -n;
	vec3 surface = useVertexColor ? vertexColor.rgb : baseColor.rgb;
	float sky = 0.5 + 0.5 * n.y;
	float key = max(dot(n, toLight), 0.0);
	float fill = max(dot(n, normalize(0.6 * (eye - worldPosition) / length(eye - worldPosition) - vec3(toLight.x, 0.0, toLight.z))), 0.0);
	float shine = pow(max(dot(n, normalize(toLight + toEye)), 0.0), 48.0);
	float light = 0.34 + 0.26 * sky + 0.44 * key + 0.20 * fill;
	vec3 lit = surface * light + vec3(0.16 * shine);
	vec3 shown = mix(lit, surface, flatness);
	float facing = abs(dot(n, toEye));
	float alpha = baseColor.a + veil * (1.0 - baseColor.a) * pow(1.0 - facing, 2.5);
	if (hatch > 0.0 && mod(gl_FragCoord.x + gl_FragCoord.y, hatch) > 0.4 * hatch) alpha *= 0.3;
	gl_FragColor = vec4(shown, alpha);
}
)";

constexpr const char* PLANE_VERTEX_SHADER = R"(#version 120
attribute vec3 position;
attribute vec3 normal;
attribute vec4 color;
uniform mat4 clipFromWorld;
varying vec3 worldPosition;
varying vec4 vertexColor;
void main()
{
	worldPosition = position;
	vertexColor = color;
	gl_Position = clipFromWorld * vec4(position, 1.0);
}
)";

// `spacing` 0: the vertices' colours, for the background. Lines are one drawn pixel wide or more, every fifth stronger.
constexpr const char* PLANE_FRAGMENT_SHADER = R"(#version 120
uniform float spacing;
uniform float fadeRadius;
uniform vec2 centre;
uniform float lineWidth;
varying vec3 worldPosition;
varying vec4 vertexColor;
float lines(float step)
{
	vec2 cell = worldPosition.xz / step;
	vec2 width = max(fwidth(cell), vec2(1e-6));
	vec2 apart = abs(fract(cell - 0.5) - 0.5) / width;
	vec2 drawn = clamp(lineWidth + 0.5 - apart, 0.0, 1.0) * clamp(0.5 / width, 0.0, 1.0);
	return max(drawn.x, drawn.y);
}
void main()
{
	if (spacing <= 0.0)
	{
		gl_FragColor = vertexColor;
		return;
	}
	float away = length(worldPosition.xz - centre) / fadeRadius;
	float fade = 1.0 - smoothstep(0.25, 1.0, away);
	float line = max(0.5 * lines(spacing), lines(5.0 * spacing));
	vec3 shade = mix(vec3(0.90, 0.905, 0.915), vec3(0.74, 0.76, 0.79), line);
	gl_FragColor = vec4(shade, fade);
}
)";
}  // namespace clod::demo
