#pragma once

namespace psivox::gl {

/// How many OpenGL objects there are, by kind: after the same work the same, unless one is leaked.
struct ObjectCounts {
  int textures = 0, buffers = 0, framebuffers = 0, programs = 0, shaders = 0, vertex_arrays = 0,
      queries = 0;
  bool operator==(const ObjectCounts&) const = default;
};

/// Counts the objects of the current context, whoever made them.
ObjectCounts count_objects();

}  // namespace psivox::gl
