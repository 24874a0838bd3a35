#include "gl/grid_textures.h"

#include <algorithm>

#include "gl/march_program.h"
#include "march/marcher.h"

namespace psivox::gl {

GridTextures::GridTextures(const MediumAtlas& atlas, Filter filter)
    : atlas_(atlas), filter_(filter) {
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  const bool pairs = atlas.paired && filter == Filter::exact;
  int needed = MarchProgram::first_grid_unit;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (!grids[i] || (pairs && i == luminance_grid)) continue;
    const BrickAtlas* beside = pairs && i == density_grid ? grids[luminance_grid] : nullptr;
    textures_[i] = std::make_unique<const AtlasTextures>(*grids[i], filter, beside);
    needed += textures_[i]->units();
  }
  GLint units = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  if (needed > units)
    throw DeviceFull(ExitCode::graphics, "the atlas takes " + std::to_string(needed) +
                                             " textures, and the device has " +
                                             std::to_string(units) + "");
}

ProgramKey GridTextures::key(MarchSetup& setup) const {
  PerGrid<int> buffers{};
  int texels_per_buffer = brick_texels;
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    if (!textures_[i]) continue;
    buffers[i] = textures_[i]->buffers();
    // grids of several buffers have the same: the device's limit
    texels_per_buffer = std::max(texels_per_buffer, textures_[i]->texels_per_buffer());
  }
  if (!driver_is_software()) setup.constants.passes_octants = false;
  return program_key(setup, buffers, texels_per_buffer);
}

void GridTextures::bind(const MarchProgram& march) const {
  for (std::size_t i = 0; i < textures_.size(); ++i)
    if (textures_[i]) textures_[i]->bind(march.grid_unit(int(i)));
}

}  // namespace psivox::gl
