#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "gl/program.h"
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

/// How a driver's programs are best built.
struct ProgramForm {
  bool holds_uniforms = false;  ///< uniforms are copied before loops (binding.glsl)
  bool computes = false;        ///< as a compute shader, else as a fragment shader (stage.glsl)
};

/// That of the current context's driver. One that runs on the CPU gathers uniforms lane by lane,
/// and its fragment shaders are as fast; a GPU may run these on few of its units (docs/gpu.md).
ProgramForm program_form();

/// What stands before every shader that includes binding.glsl: the constants that it shares with
/// C++, and the form's.
std::string common_prelude(const ProgramForm& form);

/// The text of march.frag, or of another shader over the same march, for one key: only what is
/// used.
ShaderSource march_source(const ProgramKey& key, const std::string& shader,
                          const ProgramForm& form = {});

/// Loop turns that one pass may take.
int turns_per_pass(const MarchSetup& setup);

/// What tests set in place of the driver's: limits that small volumes reach. 0: the driver's.
struct TestLimits {
  std::optional<bool> computes{};   ///< compute or fragment shaders; unset: as suits the driver
  int turns_per_pass = 0;           ///< loop turns that a ray may take in one draw
  std::uint64_t buffer_texels = 0;  ///< texels of one texture buffer
  bool copies_texels = false;       ///< to the device, even where it can use the host's
};

/// Limits of every GlRenderer of the process. Only tests set them.
inline TestLimits test_limits;

/// Sets every parameter but sample_offset and tile_origin of a shader that includes binding.glsl.
void set_parameters(const Program& program, const MarchParameters& parameters);

/// march.frag, or another shader over the same march, compiled for one key.
class MarchProgram {
 public:
  explicit MarchProgram(const ProgramKey& key, const std::string& shader = "march.frag",
                        const ProgramForm& form = program_form());

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
