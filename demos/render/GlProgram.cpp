// SPDX-License-Identifier: Zlib
#include "demos/render/GlProgram.h"

#include <cstddef>

namespace clod::demo
{
namespace
{
constexpr GLuint POSITION = 0, NORMAL = 1, COLOR = 2;

// 0 where the source does not compile; `log` then says why.
GLuint compile(GLenum kind, const char* source, std::string& log)
{
	const GLuint shader = glCreateShader(kind);
	glShaderSource(shader, 1, &source, nullptr);
	glCompileShader(shader);
	GLint isCompiled = 0;
	glGetShaderiv(shader, GL_COMPILE_STATUS, &isCompiled);
	if (isCompiled) return shader;
	char text[512] = "";
	glGetShaderInfoLog(shader, sizeof text, nullptr, text);
	log = text;
	glDeleteShader(shader);
	return 0;
}
}  // namespace

Result<std::unique_ptr<GlProgram>> GlProgram::create(const char* vertexSource, const char* fragmentSource)
{
	std::string log;
	const GLuint vertex = compile(GL_VERTEX_SHADER, vertexSource, log);
	const GLuint fragment = compile(GL_FRAGMENT_SHADER, fragmentSource, log);
	const GLuint program = glCreateProgram();
	GLint isLinked = 0;
	if (vertex && fragment)
	{
		glAttachShader(program, vertex);
		glAttachShader(program, fragment);
		glBindAttribLocation(program, POSITION, "position");
		glBindAttribLocation(program, NORMAL, "normal");
		glBindAttribLocation(program, COLOR, "color");
		glLinkProgram(program);
		glGetProgramiv(program, GL_LINK_STATUS, &isLinked);
	}
	glDeleteShader(vertex);  // the program keeps what it needs
	glDeleteShader(fragment);
	std::unique_ptr<GlProgram> result(new GlProgram(program));
	if (!isLinked) return Error{"OpenGL does not accept a shader: " + log};
	return result;
}

GlBuffer::GlBuffer(const DrawList& list) : m_count(GLsizei(list.size()))
{
	glGenBuffers(1, &m_buffer);
	glBindBuffer(GL_ARRAY_BUFFER, m_buffer);
	glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(list.size() * sizeof(DrawVertex)), list.data(), GL_STATIC_DRAW);
}

void GlBuffer::draw() const
{
	const auto offset = [](size_t bytes) { return reinterpret_cast<const void*>(bytes); };
	glBindBuffer(GL_ARRAY_BUFFER, m_buffer);
	glEnableVertexAttribArray(POSITION);
	glEnableVertexAttribArray(NORMAL);
	glEnableVertexAttribArray(COLOR);
	glVertexAttribPointer(POSITION, 3, GL_FLOAT, GL_FALSE, sizeof(DrawVertex), offset(offsetof(DrawVertex, position)));
	glVertexAttribPointer(NORMAL, 3, GL_FLOAT, GL_FALSE, sizeof(DrawVertex), offset(offsetof(DrawVertex, normal)));
	glVertexAttribPointer(COLOR, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(DrawVertex), offset(offsetof(DrawVertex, color)));
	glDrawArrays(GL_TRIANGLES, 0, m_count);
}
}  // namespace clod::demo
