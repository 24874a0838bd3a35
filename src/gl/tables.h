#pragma once

#include <epoxy/gl.h>

#include <glm/vec4.hpp>
#include <vector>

namespace psivox::gl {

/// What fetch_table reads, as a texture buffer. Needs a current context for its whole life.
class Tables {
 public:
  /// Throws Error(graphics) beyond the device's limit. `entries` is not empty.
  explicit Tables(const std::vector<glm::vec4>& entries);
  ~Tables();
  Tables(const Tables&) = delete;
  Tables& operator=(const Tables&) = delete;

  void bind(int unit) const { glBindTextureUnit(GLuint(unit), texture_); }

 private:
  GLuint buffer_ = 0, texture_ = 0;
};

}  // namespace psivox::gl
