#pragma once

#include <epoxy/gl.h>

#include <glm/vec4.hpp>
#include <vector>

#include "gl/march_source.h"
#include "gl/program.h"

namespace psivox::gl {

/// Whether the current context's driver runs on the CPU: it wants uniforms copied before loops
/// (binding.glsl), and gains by passing over octants (atlas.glsl).
bool driver_is_software();

/// Sets every parameter but sample_offset and tile_origin of a shader that includes binding.glsl.
void set_parameters(const Program& program, const MarchParameters& parameters);

/// march.frag, or another shader over the same march, compiled for one key.
class MarchProgram {
 public:
  explicit MarchProgram(const ProgramKey& key, const std::string& shader = "march.frag");

  /// Texture units: 0 to 3 are the resumed state, then the tables, then grid after grid.
  static constexpr int tables_unit = 4;
  static constexpr int first_grid_unit = 5;
  int grid_unit(int grid) const;

  /// Sets the march's parameters and the interval of a function that has only one.
  void configure(const MarchSetup& setup) const;

  const Program& program() const { return program_; }
  const ProgramKey& key() const { return key_; }

 private:
  ProgramKey key_;
  Program program_;
};

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
