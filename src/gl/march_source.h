#pragma once

#include <cstdint>

#include "gl/shader_source.h"
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

/// Key of the program for a setup. Lowers max_turns to what one pass may take.
ProgramKey program_key(MarchSetup& setup, const PerGrid<int>& buffers,
                       int texels_per_buffer = brick_texels);

/// What stands before every shader that includes binding.glsl: the constants that it shares with
/// C++. `holds_uniforms`: the driver wants them copied before loops.
std::string common_prelude(bool holds_uniforms);

/// The text of march.frag, or of another shader over the same march, for one key: only what is
/// used.
ShaderSource march_source(const ProgramKey& key, const std::string& shader, bool holds_uniforms);

/// Loop turns that one pass may take.
int turns_per_pass(const MarchSetup& setup);

/// Limits that tests lower below the driver's, so that small volumes reach them. 0: the driver's.
struct TestLimits {
  int turns_per_pass = 0;           ///< loop turns that a ray may take in one draw
  std::uint64_t buffer_texels = 0;  ///< texels of one texture buffer
};

/// Limits of every GlRenderer of the process. Only tests set them.
inline TestLimits test_limits;

}  // namespace psivox::gl
