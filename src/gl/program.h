#pragma once

#include <epoxy/gl.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <span>
#include <string>

#include "gl/shader_source.h"

namespace psivox::gl {

/// A linked GL program; needs a current context for its whole life.
class Program {
 public:
  /// Compiles and links march.vert and the fragment shader `name`, of that text.
  /// Throws Error(graphics) with the driver's first message, mapped to file and line.
  Program(const std::string& name, const ShaderSource& fragment);
  /// Compiles and links the text that load_shader gives.
  Program(const std::string& name, const std::string& prelude,
          const std::map<std::string, std::string>& generated);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  GLuint id() const { return id_; }

  /// Sets a uniform; names that the compiler has dropped are ignored. Doubles become floats.
  void set(const char* name, int value) const;
  void set(const char* name, double value) const;
  void set(const char* name, const glm::ivec2& value) const;
  void set(const char* name, const glm::ivec3& value) const;
  void set(const char* name, const glm::dvec2& value) const;
  void set(const char* name, const glm::dvec3& value) const;
  void set(const char* name, const glm::dvec4& value) const;
  /// An array's, as many as there are.
  void set(const char* name, std::span<const glm::vec4> values) const;

 private:
  GLint location(const char* name) const;
  GLuint id_ = 0;
};

/// One triangle over the whole viewport (march.vert). Needs a current context for its whole life.
class Triangle {
 public:
  Triangle() { glCreateVertexArrays(1, &vertex_array_); }
  ~Triangle() { glDeleteVertexArrays(1, &vertex_array_); }
  Triangle(const Triangle&) = delete;
  Triangle& operator=(const Triangle&) = delete;

  void draw(const Program& program, int width, int height) const {
    glBindVertexArray(vertex_array_);
    glUseProgram(program.id());
    glViewport(0, 0, width, height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

 private:
  GLuint vertex_array_ = 0;
};

}  // namespace psivox::gl
