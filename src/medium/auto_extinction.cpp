#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "base/text.h"
#include "field/leaf_values.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr double auto_depth = 3;
constexpr int rays_per_side = 17;

/// Attenuation of a value, without the extinction.
struct Attenuation {
  const TransferFunction* transfer;
  double operator()(float value) const {
    const double v = double(value);
    return std::isnan(value) ? 0 : transfer ? transfer->attenuation(v) : v;
  }
};

/// Lines along one index axis through voxel centres, on a lattice over the two other axes. On such
/// a line the interpolation is linear between values, so the integral is a sum of each value times
/// the voxel's length, halved at the domain's two ends.
class LineBundle {
 public:
  /// Lattice points in voxels along the axes that follow `axis` cyclically.
  LineBundle(const Field& field, const Attenuation& attenuation, int axis,
             std::vector<int> across_1, std::vector<int> across_2)
      : attenuation_(attenuation),
        vacuum_(attenuation(0)),
        axis_(axis),
        b_((axis + 1) % 3),
        c_((axis + 2) % 3),
        domain_(field.domain()),
        across_1_(std::move(across_1)),
        across_2_(std::move(across_2)),
        sums_(across_1_.size() * across_2_.size()) {
    visit_leaves(
        field,
        [&](std::span<const Leaf> leaves) {
          for (const Leaf& leaf : leaves) add(leaf.origin, values_of(field, leaf));
        },
        [&](const Leaf& leaf) { return is_met(leaf.origin); });
    for (const Tile& tile : field.tiles) add(tile);
    length_ = glm::length(glm::dvec3(field.world_from_index[axis]));
  }

  /// Adds the integrals of the lines that meet something.
  void collect(double& sum, int& count) const {
    const double vacuum = vacuum_ * (domain_.max[axis_] - domain_.min[axis_]);
    for (const double found : sums_) {
      const double line = found + vacuum;
      if (line == 0) continue;
      sum += line * length_;
      ++count;
    }
  }

 private:
  /// Sum over the part of [first, first + width) inside the domain; ends count half.
  template <typename Value>
  double clipped_sum(int first, int width, Value value) const {
    const int low = domain_.min[axis_], high = domain_.max[axis_];
    double sum = 0;
    for (int i = std::max(first, low); i <= std::min(first + width - 1, high); ++i)
      sum += value(i - first) * (i == low || i == high ? 0.5 : 1.0);
    return sum;
  }

  /// Whether a line goes through a leaf.
  bool is_met(const glm::ivec3& leaf) const {
    const auto within = [](const std::vector<int>& places, int from) {
      const auto place = std::lower_bound(places.begin(), places.end(), from);
      return place != places.end() && *place < from + 8;
    };
    return within(across_1_, leaf[b_]) && within(across_2_, leaf[c_]);
  }

  template <typename LineSum>
  void for_lines_through(const glm::ivec3& origin, int width, LineSum line_sum) {
    const auto first = [&](const std::vector<int>& places, int from) {
      return std::size_t(std::lower_bound(places.begin(), places.end(), from) - places.begin());
    };
    const std::size_t j_end = first(across_1_, origin[b_] + width);
    const std::size_t k_begin = first(across_2_, origin[c_]);
    const std::size_t k_end = first(across_2_, origin[c_] + width);
    for (std::size_t j = first(across_1_, origin[b_]); j < j_end; ++j)
      for (std::size_t k = k_begin; k < k_end; ++k)
        sums_[j * across_2_.size() + k] +=
            line_sum(across_1_[j] - origin[b_], across_2_[k] - origin[c_]);
  }

  void add(const glm::ivec3& leaf, const LeafValues& values) {
    for_lines_through(leaf, 8, [&](int b, int c) {
      return clipped_sum(leaf[axis_], 8, [&](int a) {
        glm::ivec3 voxel;
        voxel[axis_] = a;
        voxel[b_] = b;
        voxel[c_] = c;
        return attenuation_(*values.at(voxel)) - vacuum_;
      });
    });
  }

  void add(const Tile& tile) {
    const double voxels = clipped_sum(tile.origin[axis_], tile.width, [](int) { return 1.0; });
    for_lines_through(tile.origin, tile.width,
                      [&](int, int) { return voxels * (attenuation_(tile.value.x) - vacuum_); });
  }

  const Attenuation& attenuation_;
  double vacuum_;  ///< attenuation of 0, the value where nothing is stored
  int axis_, b_, c_;
  Box domain_;
  std::vector<int> across_1_, across_2_;
  std::vector<double> sums_;
  double length_ = 1;
};

/// Middles of `rays_per_side` equal parts of the `part` of [min, max] around its centre, as voxels.
std::vector<int> lattice(int min, int max, double part) {
  std::vector<int> places;
  for (int i = 0; i < rays_per_side; ++i) {
    const double u = 0.5 + part * ((i + 0.5) / rays_per_side - 0.5);
    places.push_back(int(std::lround(min + u * (double(max) - min))));
  }
  return places;
}

/// A voxel with the largest attenuation; any voxel if all are 0.
glm::ivec3 densest_voxel(const Field& field, const Attenuation& attenuation) {
  struct Voxel {
    glm::ivec3 place;
    double largest;
  };
  Voxel densest{field.active_box.min, 0};
  visit_leaves(field, [&](std::span<const Leaf> leaves) {
    for (const Leaf& leaf : leaves) {
      const LeafValues values = values_of(field, leaf);
      for (int i = 0; i < 512; ++i) {
        const glm::ivec3 voxel = leaf_voxel(i);
        const double value = attenuation(*values.at(voxel));
        if (value > densest.largest) densest = {leaf.origin + voxel, value};
      }
    }
  });
  for (const Tile& tile : field.tiles) {
    const double value = attenuation(tile.value.x);
    if (value > densest.largest)
      densest = {
          glm::clamp(tile.origin + tile.width / 2, field.active_box.min, field.active_box.max),
          value};
  }
  return densest.place;
}

/// Mean integral over the lines that meet something; 0 if none does.
template <typename Places>
double mean_integral(const Field& field, const Attenuation& attenuation, Places places) {
  double sum = 0;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis)
    LineBundle(field, attenuation, axis, places((axis + 1) % 3), places((axis + 2) % 3))
        .collect(sum, count);
  return count ? sum / count : 0;
}

}  // namespace

double auto_extinction(const Field& field, const TransferFunction* transfer) {
  if (field.active_box.empty()) return 1;
  const Attenuation attenuation{transfer};
  const Box domain = field.domain();
  double mean = 0;
  for (const double part : {0.5, 1.0}) {
    if (mean == 0)
      mean = mean_integral(field, attenuation, [&](int axis) {
        return lattice(domain.min[axis], domain.max[axis], part);
      });
  }
  if (mean == 0) {
    // The field is so sparse that all rays of the lattices missed it.
    const glm::ivec3 voxel = densest_voxel(field, attenuation);
    mean =
        mean_integral(field, attenuation, [&](int axis) { return std::vector<int>{voxel[axis]}; });
  }
  if (mean == 0) return 1;
  const double extinction = auto_depth / mean;
  if (extinction <= std::numeric_limits<float>::max()) return extinction;
  throw Error(
      ExitCode::input,
      "grid " + in_quotes(field.name) + ": its attenuations are too small for float32; " +
          (transfer ? "give the transfer function larger ones" : "store the grid in another unit"));
}

}  // namespace psivox
