#include "gl/program.h"

#include <vector>

#include "psivox/error.h"

namespace psivox::gl {
namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

GLuint compile(GLenum stage, const std::string& name, const ShaderSource& source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.text.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  std::vector<char> log(65536, '\0');
  glGetShaderInfoLog(shader, GLsizei(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  throw Error(ExitCode::graphics,
              "shader '" + name + "' does not compile: " + first_line(source.map_log(log.data())));
}

}  // namespace

Program::Program(const std::string& name, const ShaderSource& source, bool computes) {
  std::vector<GLuint> shaders{
      compile(computes ? GL_COMPUTE_SHADER : GL_FRAGMENT_SHADER, name, source)};
  if (!computes)
    shaders.push_back(compile(GL_VERTEX_SHADER, "march.vert", load_shader("march.vert", "", {})));
  id_ = glCreateProgram();
  for (const GLuint shader : shaders) {
    glAttachShader(id_, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(id_);
  GLint ok = 0;
  glGetProgramiv(id_, GL_LINK_STATUS, &ok);
  if (!ok) {
    std::vector<char> log(65536, '\0');
    glGetProgramInfoLog(id_, GLsizei(log.size()), nullptr, log.data());
    glDeleteProgram(id_);
    throw Error(ExitCode::graphics,
                "shader '" + name + "' does not link: " + first_line(log.data()));
  }
  if (!computes) return;
  GLint group[3] = {};
  glGetProgramiv(id_, GL_COMPUTE_WORK_GROUP_SIZE, group);
  group_ = {group[0], group[1]};
}

void EachPixel::run(const Program& program, int width, int height) const {
  glUseProgram(program.id());
  if (const glm::ivec2 group = program.group(); group.x > 0) {
    const glm::ivec2 size(width, height), groups = (size + group - 1) / group;
    program.set("drawn_size", size);
    glDispatchCompute(GLuint(groups.x), GLuint(groups.y), 1);
    glMemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    return;
  }
  glBindVertexArray(vertex_array_);
  glViewport(0, 0, width, height);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Program::~Program() { glDeleteProgram(id_); }

GLint Program::location(const char* name) const { return glGetUniformLocation(id_, name); }

void Program::set(const char* name, int value) const {
  glProgramUniform1i(id_, location(name), value);
}
void Program::set(const char* name, double value) const {
  glProgramUniform1f(id_, location(name), float(value));
}
void Program::set(const char* name, const glm::ivec2& v) const {
  glProgramUniform2i(id_, location(name), v.x, v.y);
}
void Program::set(const char* name, const glm::ivec3& v) const {
  glProgramUniform3i(id_, location(name), v.x, v.y, v.z);
}
void Program::set(const char* name, const glm::dvec2& v) const {
  glProgramUniform2f(id_, location(name), float(v.x), float(v.y));
}
void Program::set(const char* name, const glm::dvec3& v) const {
  glProgramUniform3f(id_, location(name), float(v.x), float(v.y), float(v.z));
}
void Program::set(const char* name, const glm::dvec4& v) const {
  glProgramUniform4f(id_, location(name), float(v.x), float(v.y), float(v.z), float(v.w));
}
void Program::set(const char* name, std::span<const glm::vec4> values) const {
  glProgramUniform4fv(id_, location(name), GLsizei(values.size()),
                      reinterpret_cast<const float*>(values.data()));
}

}  // namespace psivox::gl
