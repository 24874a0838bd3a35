#pragma once

#include "gl/program.h"
#include "march/march_parameters.h"

namespace psivox::gl {

/// What a march shader is compiled for: the march's constants and how its textures are stored.
struct ProgramKey {
  MarchConstants constants;
  PerGrid<int> buffers{};  ///< texel buffers of each grid, 0: there is no such grid
  int texels_per_buffer = brick_texels;
  bool resumable = false;  ///< rays may need several passes: state is read and written

  /// The text that stands before march.frag; equal for equal keys.
  std::string prelude() const;
};

/// What stands before every shader that includes binding.glsl: the constants that it shares with
/// C++, and whether the driver wants uniforms held.
std::string common_prelude();

/// Sets every parameter but sample_offset and tile_origin of a shader that includes binding.glsl.
void set_parameters(const Program& program, const MarchParameters& parameters);

/// Loop turns that one pass may take.
int turns_per_pass(const MarchSetup& setup);

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

}  // namespace psivox::gl
