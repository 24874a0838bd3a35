#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

#include "field/field_index.h"
#include "psivox/medium.h"
#include "scene/transfer_function.h"

// What a medium has at the voxels of its density before light comes: its own luminance, its albedo.

namespace psivox {

/// The colours of a transfer function, for many values: its intervals are found by bins, several to
/// an interval.
class FunctionColors {
 public:
  explicit FunctionColors(const TransferFunction& function) {
    const std::vector<TransferPoint>& points = function.points();
    first_ = points.front().value;
    last_ = points.back().value;
    for (std::size_t k = 0; k + 1 < points.size(); ++k)
      intervals_.push_back(
          {points[k].value, points[k + 1].value, points[k].color,
           (points[k + 1].color - points[k].color) / (points[k + 1].value - points[k].value)});
    if (intervals_.empty()) intervals_.push_back({first_, HUGE_VAL, points[0].color, {}});
    const auto bins = 32 * intervals_.size();
    scale_ = last_ > first_ ? double(bins) / (last_ - first_) : 0;
    for (std::size_t bin = 0; bin < bins; ++bin) {
      // a bin earlier than it begins, whatever rounding does
      const double from = scale_ > 0 ? first_ + (double(bin) - 1) / scale_ : first_;
      begins_.push_back(
          std::size_t(std::clamp(function.interval(from), 0, int(intervals_.size()) - 1)));
    }
  }

  glm::dvec3 at(float value) const {
    if (std::isnan(value)) return glm::dvec3(0);  // absent
    const double v = std::clamp(double(value), first_, last_);
    const auto bin = std::min(std::size_t((v - first_) * scale_), begins_.size() - 1);
    const Interval* in = &intervals_[begins_[bin]];
    while (v > in->end) ++in;
    return in->color + in->slope * (v - in->begin);
  }

 private:
  struct Interval {
    double begin, end;
    glm::dvec3 color, slope;
  };
  std::vector<Interval> intervals_;
  std::vector<std::size_t> begins_;  ///< of each bin, an interval that is not behind it
  double first_ = 0, last_ = 0, scale_ = 0;
};

/// The luminance of the medium before its light and without `color`, at voxels of the density.
class OwnLuminance {
 public:
  explicit OwnLuminance(const Medium& medium) : medium_(medium) {
    if (medium.transfer || medium.source == LuminanceSource::density)
      index_.emplace(*medium.density);
    if (medium.source == LuminanceSource::transfer) colors_.emplace(*medium.transfer);
    if (medium.luminance) {
      index_.emplace(*medium.luminance);
      to_luminance_ =
          glm::inverse(medium.luminance->world_from_index) * medium.density->world_from_index;
    }
  }

  /// At the 8^3 voxels from `origin` on, z fastest.
  void block(const glm::ivec3& origin, std::span<glm::dvec3> to) const {
    if (medium_.source != LuminanceSource::transfer) {
      for (int i = 0; i < 512; ++i) to[std::size_t(i)] = at(origin + leaf_voxel(i));
      return;
    }
    const FieldIndex::Block block = index_->block(origin);
    for (int i = 0; i < 512; ++i) to[std::size_t(i)] = colors_->at(block.value(i));
  }

  glm::dvec3 at(const glm::ivec3& voxel) const {
    switch (medium_.source) {
      case LuminanceSource::constant:
        break;
      case LuminanceSource::density:
        return glm::max(glm::dvec3(0), glm::dvec3(index_->at(voxel).x));  // absent: 0
      case LuminanceSource::transfer:
        return colors_->at(float(index_->at(voxel).x));
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
  std::optional<FunctionColors> colors_;
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
