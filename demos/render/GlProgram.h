// SPDX-License-Identifier: Zlib
// A linked shader program and vertex buffers, freed with the object. An OpenGL context must be current throughout.
#pragma once
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include <array>

#include "demos/render/DrawGeometry.h"

namespace clod::demo
{
using Matrix4 = std::array<float, 16>;  // column by column, as OpenGL takes them

class GlProgram
{
public:
	static Result<std::unique_ptr<GlProgram>> create(const char* vertexSource, const char* fragmentSource);
	~GlProgram() { glDeleteProgram(m_program); }
	GlProgram(const GlProgram&) = delete;
	GlProgram& operator=(const GlProgram&) = delete;
	void use() const { glUseProgram(m_program); }
	// Of the program in use.
	void set(const char* name, float value) const { glUniform1f(location(name), value); }
	void set(const char* name, bool value) const { glUniform1i(location(name), value ? 1 : 0); }
	void set(const char* name, float x, float y) const { glUniform2f(location(name), x, y); }
	void set(const char* name, const Vec3& v) const { glUniform3f(location(name), float(v.x), float(v.y), float(v.z)); }
	void set(const char* name, const Color& c) const { glUniform4f(location(name), c.r, c.g, c.b, c.a); }
	void set(const char* name, const Matrix4& m) const { glUniformMatrix4fv(location(name), 1, GL_FALSE, m.data()); }

private:
	explicit GlProgram(GLuint program) : m_program(program) {}
	GLint location(const char* name) const { return glGetUniformLocation(m_program, name); }
	GLuint m_program;
};

class GlBuffer
{
public:
	explicit GlBuffer(const DrawList& list);
	~GlBuffer() { glDeleteBuffers(1, &m_buffer); }
	GlBuffer(const GlBuffer&) = delete;
	GlBuffer& operator=(const GlBuffer&) = delete;
	void draw() const;

private:
	GLuint m_buffer = 0;
	GLsizei m_count = 0;
};
}  // namespace clod::demo
