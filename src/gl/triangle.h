#pragma once

#include "gl/program.h"

namespace psivox::gl {

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
