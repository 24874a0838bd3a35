#pragma once

#include "gl/program.h"
#include "march/march_parameters.h"

namespace psivox::gl {

/// What a march shader is compiled for: the march's constants and how its textures are stored.
struct MarchVariant {
  MarchConstants constants;
  int density_buffers = 1;
  int luminance_buffers = 1;
  int texels_per_buffer = brick_texels;
  bool resumable = false;  ///< rays may need several passes: state is read and written

  /// The defines that stand before march.frag; equal for equal variants.
  std::string prelude() const;
};

/// march.frag for one variant.
class MarchProgram {
 public:
  explicit MarchProgram(const MarchVariant& variant);

  /// Texture units: density's from 4 on, then luminance's; 0 to 3 are the resumed state.
  static constexpr int density_unit = 4;
  int luminance_unit() const { return density_unit + 3 + variant_.density_buffers; }

  /// Sets every parameter but sample_offset and tile_origin.
  void configure(const MarchParameters& parameters) const;

  const Program& program() const { return program_; }

 private:
  MarchVariant variant_;
  Program program_;
};

}  // namespace psivox::gl
