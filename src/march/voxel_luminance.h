#pragma once

#include <algorithm>
#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "field/field_index.h"
#include "psivox/medium.h"

// What a medium has at the voxels of its density before light comes: its own luminance, its albedo.

namespace psivox {

/// The luminance of the medium before its light and without `color`, at voxels of the density. It
/// is 1 where a transfer function gives its colours, which rays add (Medium::lit_colors).
class OwnLuminance {
 public:
  explicit OwnLuminance(const Medium& medium) : medium_(medium) {
    if (medium.source == LuminanceSource::density) index_.emplace(*medium.density);
    if (medium.luminance) {
      index_.emplace(*medium.luminance);
      to_luminance_ =
          glm::inverse(medium.luminance->world_from_index) * medium.density->world_from_index;
    }
  }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    switch (medium_.source) {
      case LuminanceSource::constant:
      case LuminanceSource::transfer:
        break;
      case LuminanceSource::density:
        return glm::max(glm::dvec3(0), glm::dvec3(index_->at(voxel).x));  // absent: 0
      case LuminanceSource::scalar:
        return glm::dvec3(other(voxel).x);
      case LuminanceSource::vector:
        return other(voxel);
    }
    return glm::dvec3(1);
  }

 private:
  glm::dvec3 other(const glm::ivec3& voxel) const {
    if (medium_.luminance->world_from_index == medium_.density->world_from_index)
      return index_->at(voxel);
    return index_->at(glm::dvec3(to_luminance_ * glm::dvec4(voxel, 1)));
  }

  const Medium& medium_;
  std::optional<FieldIndex> index_;  ///< of the grid that L comes from
  glm::dmat4 to_luminance_{1};
};

/// The factor of the albedo at voxels of the density.
class PointAlbedo {
 public:
  explicit PointAlbedo(const Medium& medium) {
    if (!medium.light) return;
    for (const auto& field : medium.light->albedo)
      grids_.push_back({FieldIndex(*field), field->channels,
                        glm::inverse(field->world_from_index) * medium.density->world_from_index});
    if (grids_.size() == 3) density_.emplace(*medium.density);
  }

  bool is_one() const { return grids_.empty(); }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    if (!density_) {
      const glm::dvec3 value = sample(grids_.front(), voxel);
      return grids_.front().channels == 1 ? glm::dvec3(value.x) : value;
    }
    // Colour times density. Where there is none, the mean colour beside it, so that the light
    // that is interpolated towards there keeps its colour.
    glm::dvec4 sum = colored(voxel);
    if (!(sum.w > 0))
      for (int i = 0; i < 27; ++i) sum += colored(voxel + glm::ivec3(i / 9, i / 3 % 3, i % 3) - 1);
    return sum.w > 0 ? glm::min(glm::dvec3(sum) / sum.w, 1.0) : glm::dvec3(0);
  }

 private:
  struct Grid {
    FieldIndex index;
    int channels;
    glm::dmat4 from_voxel;
  };

  static glm::dvec3 sample(const Grid& grid, const glm::ivec3& voxel) {
    if (grid.from_voxel == glm::dmat4(1)) return grid.index.at(voxel);
    return grid.index.at(glm::dvec3(grid.from_voxel * glm::dvec4(voxel, 1)));
  }

  glm::dvec4 colored(const glm::ivec3& voxel) const {
    glm::dvec4 value(0, 0, 0, std::max(density_->at(voxel).x, 0.0));
    for (int c = 0; value.w > 0 && c < 3; ++c) value[c] = sample(grids_[std::size_t(c)], voxel).x;
    return value;
  }

  std::vector<Grid> grids_;
  std::optional<FieldIndex> density_;  ///< if there are three grids
};

}  // namespace psivox
