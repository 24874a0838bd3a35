#pragma once

#include <epoxy/gl.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>

#include "gl/shader_source.h"

namespace psivox::gl {

/// A linked GL program; needs a current context for its whole life.
class Program {
 public:
  /// Compiles and links the shader `name`, of that text: as a compute shader, or as a fragment
  /// shader behind march.vert. Throws Error(graphics) with the driver's first message, mapped to
  /// file and line.
  Program(const std::string& name, const ShaderSource& source, bool computes = false);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  GLuint id() const { return id_; }
  /// Invocations of a compute shader's group along x and y; 0 of a fragment shader.
  const glm::ivec2& group() const { return group_; }

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
  glm::ivec2 group_{0};
};

/// Runs a program for each pixel of a region, into what is bound: compute shaders in groups
/// (stage.glsl), fragment shaders by one triangle over the whole viewport (march.vert). Needs a
/// current context for its whole life.
class EachPixel {
 public:
  EachPixel() { glCreateVertexArrays(1, &vertex_array_); }
  ~EachPixel() { glDeleteVertexArrays(1, &vertex_array_); }
  EachPixel(const EachPixel&) = delete;
  EachPixel& operator=(const EachPixel&) = delete;

  void run(const Program& program, int width, int height) const;

 private:
  GLuint vertex_array_ = 0;
};

}  // namespace psivox::gl
