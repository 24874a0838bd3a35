#pragma once

#include <epoxy/gl.h>

#include <string>
#include <vector>

namespace psivox::gl {

/// Sum of the times that the GPU takes for stretches of commands, by GL_TIME_ELAPSED.
class Timer {
 public:
  /// llvmpipe stores commands, the timer's among them, and runs them tile by tile: the timer's must
  /// not be stored together with the draws.
  explicit Timer(const std::string& renderer)
      : waits_(renderer.find("llvmpipe") != std::string::npos) {
    GLint bits = 0;
    glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
    works_ = bits > 0;
  }
  ~Timer() { glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data()); }
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void begin() {
    if (!works_) return;
    glCreateQueries(GL_TIME_ELAPSED, 1, &queries_.emplace_back());
    glBeginQuery(GL_TIME_ELAPSED, queries_.back());
    if (waits_) glFinish();
  }
  void end() const {
    if (!works_) return;
    if (waits_) glFinish();
    glEndQuery(GL_TIME_ELAPSED);
  }

  /// Waits for the commands; 0 where the driver has no such timer.
  double sum_ms() const {
    double sum = 0;
    for (const GLuint query : queries_) {
      GLuint64 nanoseconds = 0;
      glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
      sum += 1e-6 * static_cast<double>(nanoseconds);
    }
    return sum;
  }

 private:
  bool waits_;
  bool works_ = false;
  std::vector<GLuint> queries_;
};

}  // namespace psivox::gl
