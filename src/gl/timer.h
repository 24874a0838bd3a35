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
  ~Timer() {
    if (running_) glEndQuery(GL_TIME_ELAPSED);
    glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
  }
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void begin() {
    if (!works_) return;
    glCreateQueries(GL_TIME_ELAPSED, 1, &queries_.emplace_back());
    glBeginQuery(GL_TIME_ELAPSED, queries_.back());
    running_ = true;
    if (waits_) glFinish();
  }
  /// What is measured has been handed to the driver, which begins with it now.
  void submitted() {
    glFlush();
    if (!waits_) end();
  }
  /// It is waited for next.
  void awaited() {
    if (!waits_) return;
    glFinish();
    end();
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
  void end() {
    if (running_) glEndQuery(GL_TIME_ELAPSED);
    running_ = false;
  }

  bool waits_;
  bool works_ = false;
  bool running_ = false;
  std::vector<GLuint> queries_;
};

}  // namespace psivox::gl
