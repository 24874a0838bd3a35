#include "gl/object_counts.h"

#include <epoxy/gl.h>

namespace psivox::gl {
namespace {

/// Names in use. A driver gives out the lowest free name, or the one after the highest there ever
/// was: all are below a new one, or with no wide gap behind it.
template <typename IsObject>
int count_names(GLuint fresh, const IsObject& is_object) {
  constexpr int widest_gap = 512;
  int count = 0, gap = 0;
  for (GLuint name = 1; name < fresh || gap < widest_gap; ++name) {
    const bool there = is_object(name);
    gap = there ? 0 : gap + 1;
    count += there;
  }
  return count;
}

template <typename Generate, typename Delete, typename IsObject>
int count_generated(const Generate& generate, const Delete& remove, const IsObject& is_object) {
  GLuint fresh = 0;
  generate(1, &fresh);
  remove(1, &fresh);
  return count_names(fresh, is_object);
}

}  // namespace

ObjectCounts count_objects() {
  ObjectCounts counts;
  counts.textures = count_generated(glGenTextures, glDeleteTextures, glIsTexture);
  counts.buffers = count_generated(glGenBuffers, glDeleteBuffers, glIsBuffer);
  counts.framebuffers = count_generated(glGenFramebuffers, glDeleteFramebuffers, glIsFramebuffer);
  counts.vertex_arrays = count_generated(glGenVertexArrays, glDeleteVertexArrays, glIsVertexArray);
  counts.queries = count_generated(glGenQueries, glDeleteQueries, glIsQuery);
  const GLuint fresh = glCreateProgram();  // shaders have the same names
  glDeleteProgram(fresh);
  counts.programs = count_names(fresh, glIsProgram);
  counts.shaders = count_names(fresh, glIsShader);
  return counts;
}

}  // namespace psivox::gl
