#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <set>

#include "psivox/camera.h"

namespace psivox {
namespace {

constexpr int bins = 128;              // along each axis
constexpr double left_out = 0.01;      // at either end of what the medium hides
constexpr double left_out_far = 0.05;  // the same, if the rest is then a quarter as long
constexpr double added = 0.25;         // of the stretch between, on both sides
constexpr double least_part = 0.01;    // of the most opaque bin: less is not visible
constexpr double frame_margin = 0.1;   // of the half width and half height, left free
constexpr double mean_depth = 3;       // optical depth of a mean bin, whatever the extinction

using Profile = std::array<double, bins>;

/// A box along the axes of the frame [world units].
struct FrameBox {
  glm::dvec3 min{0}, max{0};
};

/// The part of a visible block inside a box, and the numbers of its grid and block.
struct Part {
  FrameBox box;
  double amount = 0;
  std::size_t grid = 0;
  std::size_t block = 0;
};

FrameBox around(const FrameBox& a, const FrameBox& b) {
  return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

FrameBox bounds(const std::vector<Part>& parts) {
  FrameBox all{glm::dvec3(HUGE_VAL), glm::dvec3(-HUGE_VAL)};
  for (const Part& part : parts) all = around(all, part.box);
  return all;
}

/// The blocks of a film's frame in the coordinates of the picture's. Each grid's amounts add up
/// to 1.
std::vector<Part> parts_in_frame(const Subject& subject, int frame, const glm::dmat3& axes) {
  std::vector<Part> parts;
  const glm::dmat3 frame_from_world = glm::transpose(axes);
  for (std::size_t n = 0; n < subject.grids.size(); ++n) {
    const VisibleGrid& grid = subject.grids[n];
    if (grid.frame != frame) continue;
    const glm::dmat3 m = frame_from_world * glm::dmat3(grid.world_from_index);
    const glm::dmat3 extent(glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2]));
    const glm::dvec3 origin = frame_from_world * glm::dvec3(grid.world_from_index[3]);
    double sum = 0;
    for (const VisibleBlock& block : grid.blocks) sum += block.amount;
    for (std::size_t k = 0; k < grid.blocks.size(); ++k) {
      const VisibleBlock& block = grid.blocks[k];
      const glm::dvec3 middle = m * (0.5 * (block.min + block.max)) + origin;
      const glm::dvec3 half = extent * (0.5 * (block.max - block.min));
      parts.push_back({{middle - half, middle + half}, block.amount / sum, n, k});
    }
  }
  return parts;
}

/// An axis of the frame, from `low` to `high`, in equal bins.
struct Axis {
  double low, high;

  double edge(int i) const { return i == bins ? high : low + (high - low) * i / bins; }
  int bin(double x) const {
    const double place = high > low ? (x - low) / (high - low) * bins : 0;
    return int(std::clamp(place, 0.0, bins - 1.0));
  }
  /// Calls take(bin, length of [from, to] in it, as a part of the bin's own).
  template <typename Take>
  void spread(double from, double to, Take take) const {
    const double scale = high > low ? bins / (high - low) : 0;
    for (int i = bin(from); i <= bin(to); ++i)
      take(i, std::max(0.0, (std::min(to, edge(i + 1)) - std::max(from, edge(i))) * scale));
  }
};

/// Optical depths of one grid in a picture of bins.
struct Depths {
  std::vector<double> depth = std::vector<double>(bins * bins);
  std::vector<double> covered = std::vector<double>(bins * bins);  ///< part of the bin, at most 1

  void add(const Part& part, const Axis& x, const Axis& y) {
    const glm::dvec3 size = part.box.max - part.box.min;
    const double whole = std::max(size.x * size.y, std::numeric_limits<double>::min());
    const double bin_area = (x.high - x.low) * (y.high - y.low) / (bins * bins);
    y.spread(part.box.min.y, part.box.max.y, [&](int j, double high) {
      x.spread(part.box.min.x, part.box.max.x, [&](int i, double wide) {
        const auto k = std::size_t(j) * bins + std::size_t(i);
        depth[k] += part.amount * high * wide * bin_area / whole;
        covered[k] = std::min(1.0, covered[k] + high * wide);
      });
    });
  }

  /// Multiplies what is left of the light behind each bin.
  void darken(std::vector<double>& light) const {
    double area = 0, sum = 0;
    for (std::size_t k = 0; k < depth.size(); ++k) {
      area += covered[k];
      sum += depth[k];
    }
    for (std::size_t k = 0; k < depth.size(); ++k) {
      if (!(covered[k] > 0)) continue;
      const double tau = mean_depth * depth[k] / sum * area / covered[k];
      light[k] *= 1 - covered[k] * -std::expm1(-tau);
    }
  }
};

/// Place in the profile before which lies `share` of its sum.
double quantile(const Profile& profile, const Axis& axis, double share) {
  double sum = 0;
  for (const double value : profile) sum += value;
  double left = share * sum;
  for (int i = 0; i < bins; ++i) {
    const double value = profile[std::size_t(i)];
    if (left <= value && value > 0)
      return axis.edge(i) + (axis.edge(i + 1) - axis.edge(i)) * left / value;
    left -= value;
  }
  return axis.high;
}

/// What remains of the axis. `visible` tells which bins have something to see.
Axis trimmed(const Profile& profile, const std::array<bool, bins>& visible, const Axis& axis) {
  int first = 0, last = bins - 1;
  while (first < last && !visible[std::size_t(first)]) ++first;
  while (last > first && !visible[std::size_t(last)]) --last;
  double low = quantile(profile, axis, left_out);
  double high = quantile(profile, axis, 1 - left_out);
  const double far_low = quantile(profile, axis, left_out_far);
  const double far_high = quantile(profile, axis, 1 - left_out_far);
  if (4 * (far_high - far_low) < high - low) {
    low = far_low;
    high = far_high;
  }
  const double more = added * (high - low);
  return {std::max(axis.edge(first), low - more), std::min(axis.edge(last + 1), high + more)};
}

/// The opacity of all grids in a picture of bins.
std::vector<double> opacities(const std::vector<Part>& parts, std::size_t grids, const Axis& x,
                              const Axis& y) {
  std::vector<Depths> depths(grids);
  for (const Part& part : parts) depths[part.grid].add(part, x, y);
  std::vector<double> light(bins * bins, 1.0);
  for (const Depths& grid : depths) grid.darken(light);
  for (double& value : light) value = 1 - value;
  return light;
}

FrameBox trimmed(const std::vector<Part>& parts, std::size_t grids, const FrameBox& box) {
  const Axis x{box.min.x, box.max.x}, y{box.min.y, box.max.y}, z{box.min.z, box.max.z};
  const std::vector<double> opacity = opacities(parts, grids, x, y);
  const double least = least_part * *std::max_element(opacity.begin(), opacity.end());
  Profile along_x{}, along_y{}, along_z{};
  std::array<bool, bins> x_visible{}, y_visible{}, z_visible{};
  for (std::size_t j = 0; j < bins; ++j) {
    for (std::size_t i = 0; i < bins; ++i) {
      const double value = opacity[j * bins + i];
      along_x[i] += value;
      along_y[j] += value;
      if (value < least) continue;
      x_visible[i] = y_visible[j] = true;
    }
  }
  for (const Part& part : parts) {
    const double length =
        std::max(part.box.max.z - part.box.min.z, std::numeric_limits<double>::min());
    const double bin_length = (z.high - z.low) / bins;
    z.spread(part.box.min.z, part.box.max.z, [&](int k, double deep) {
      along_z[std::size_t(k)] += part.amount * deep * bin_length / length;
      z_visible[std::size_t(k)] = true;
    });
  }
  const Axis new_x = trimmed(along_x, x_visible, x), new_y = trimmed(along_y, y_visible, y),
             new_z = trimmed(along_z, z_visible, z);
  return {{new_x.low, new_y.low, new_z.low}, {new_x.high, new_y.high, new_z.high}};
}

/// Cuts the parts off at the box. A part keeps what of its amount is inside.
void clip(std::vector<Part>& parts, const FrameBox& box) {
  for (Part& part : parts) {
    const FrameBox whole = part.box;
    part.box = {glm::max(whole.min, box.min), glm::min(whole.max, box.max)};
    for (int axis = 0; axis < 3; ++axis) {
      const double size = whole.max[axis] - whole.min[axis];
      if (size > 0) part.amount *= (part.box.max[axis] - part.box.min[axis]) / size;
      if (part.box.max[axis] < part.box.min[axis]) part.amount = -1;
      if (part.amount < 0) break;
    }
  }
  std::erase_if(parts, [](const Part& part) { return part.amount < 0; });
}

/// The parts of one of the subject's frames that count.
std::vector<Part> counted_parts(const Subject& subject, int frame, const glm::dmat3& axes) {
  std::vector<Part> parts = parts_in_frame(subject, frame, axes);
  // Bins are too wide for a small body among stray voxels, so what remains is looked at again. Each
  // turn halves an axis at least; 60 halvings are beyond a double's digits.
  for (int turn = 0; turn < 60; ++turn) {
    const FrameBox whole = bounds(parts);
    const FrameBox box = trimmed(parts, subject.grids.size(), whole);
    clip(parts, box);
    const glm::dvec3 before = whole.max - whole.min, after = box.max - box.min;
    if (2 * after.x >= before.x && 2 * after.y >= before.y && 2 * after.z >= before.z) break;
  }
  return parts;
}

/// Those of all frames.
std::vector<Part> counted_parts(const Subject& subject, const glm::dmat3& axes) {
  std::set<int> frames;
  for (const VisibleGrid& grid : subject.grids) frames.insert(grid.frame);
  std::vector<Part> all;
  for (const int frame : frames) {
    const std::vector<Part> parts = counted_parts(subject, frame, axes);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  return all;
}

/// How far the parts reach along `direction`, in the frame's coordinates. A part reaches no farther
/// than its block, which may be turned against the frame, nor than its box.
double reach(const Subject& subject, const glm::dmat3& axes, const std::vector<Part>& parts,
             const glm::dvec3& direction) {
  double farthest = -HUGE_VAL;
  for (const Part& part : parts) {
    const VisibleGrid& grid = subject.grids[part.grid];
    const double of_block = grid.reach(grid.blocks[part.block], axes * direction);
    const glm::dvec3 corner = glm::max(direction * part.box.min, direction * part.box.max);
    farthest = std::max(farthest, std::min(of_block, corner.x + corner.y + corner.z));
  }
  return farthest;
}

}  // namespace

Subject box_subject(const glm::dvec3& box_min, const glm::dvec3& box_max) {
  Subject subject;
  subject.grids.push_back({glm::dmat4(1), {{box_min, box_max, 1}}});
  subject.box_min = box_min;
  subject.box_max = box_max;
  return subject;
}

Framing framing_of(const Subject& subject, const glm::dmat3& axes, double half_width,
                   double half_height, bool orthographic, const std::optional<glm::dvec3>& target,
                   double strip) {
  const std::vector<Part> parts = counted_parts(subject, axes);
  const auto farthest = [&](const glm::dvec3& direction) {
    return reach(subject, axes, parts, direction);
  };
  // A point is inside the frame if -slope (z - eye) <= x - aim <= high_slope (z - eye), for each of
  // the frame's two axes.
  const glm::dvec2 slope = (1 - frame_margin) * glm::dvec2(half_width, half_height);
  const glm::dvec2 free(1 - 2 * strip, 1), high_slope = slope * free;
  const glm::dvec2 high(farthest({1, 0, -high_slope.x}), farthest({0, 1, -high_slope.y}));
  const glm::dvec2 low(-farthest({-1, 0, -slope.x}), -farthest({0, -1, -slope.y}));
  const FrameBox all{{-farthest({-1, 0, 0}), -farthest({0, -1, 0}), -farthest({0, 0, -1})},
                     {farthest({1, 0, 0}), farthest({0, 1, 0}), farthest({0, 0, 1})}};
  // the point from which the frame's both sides are equally near
  const auto between = [&](const glm::dvec2& lower, const glm::dvec2& upper) {
    return (lower * free + upper) / (1.0 + free);
  };
  const double middle_z = 0.5 * (all.min.z + all.max.z);
  glm::dvec3 aim(
      orthographic ? between(glm::dvec2(all.min), glm::dvec2(all.max)) : between(low, high),
      middle_z);
  if (target) aim = glm::transpose(axes) * *target;
  const glm::dvec2 needed =
      glm::max((high - glm::dvec2(aim)) / high_slope, (glm::dvec2(aim) - low) / slope);

  Framing framing;
  framing.target = target ? *target : axes * aim;
  framing.distance = aim.z + std::max(needed.x, needed.y);
  const glm::dvec2 half = glm::max((glm::dvec2(all.max) - glm::dvec2(aim)) / free,
                                   glm::dvec2(aim) - glm::dvec2(all.min));
  framing.half_width = std::max(half.x, half.y * half_width / half_height) / (1 - frame_margin);
  return framing;
}

glm::dvec3 middle_of(const Subject& subject) {
  const FrameBox all = bounds(counted_parts(subject, glm::dmat3(1)));
  return 0.5 * (all.min + all.max);
}

}  // namespace psivox
