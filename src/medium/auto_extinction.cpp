#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "base/text.h"
#include "field/field_index.h"
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

/// Lines along an index axis go through the voxels at these places on the two others, ascending.
using Places = std::array<std::vector<int>, 3>;

/// Whether a line goes through a leaf.
bool is_met(const glm::ivec3& leaf, const Places& places) {
  int met = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<int>& all = places[std::size_t(axis)];
    const auto place = std::ranges::lower_bound(all, leaf[axis]);
    met += place != all.end() && *place < leaf[axis] + 8;
  }
  return met >= 2;
}

/// Integral of the attenuation over the domain along an axis, through a voxel [voxels]. The
/// interpolation is linear between the values, so it is their sum, with half of those at the ends.
double line_integral(const FieldIndex& index, const Attenuation& attenuation, int axis,
                     glm::ivec3 voxel) {
  const Box domain = index.field().domain();
  const int low = domain.min[axis], high = domain.max[axis];
  const auto weight = [&](int at) { return at == low || at == high ? 0.5 : 1.0; };
  double sum = 0;
  for (voxel[axis] = low; voxel[axis] <= high;) {
    const auto [box, block] = index.cube(voxel);
    const int first = voxel[axis], last = std::min(box.max[axis], high);
    if (block.is_constant()) {
      double voxels = weight(first) + last - first;
      if (last > first) voxels += weight(last) - 1;
      sum += voxels * attenuation(block.values.channel(0));
      voxel[axis] = last + 1;
    }
    for (int& at = voxel[axis]; at <= last; ++at)
      sum += weight(at) * attenuation(*block.values.at(voxel - box.min));
  }
  return sum;
}

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
  Voxel densest = fold_leaves(
      field, Voxel{field.active_box.min, 0},
      [&](Voxel& found, const Leaf& leaf, const OrderedValues& values) {
        for (int i = 0; i < 512; ++i)
          if (const double value = attenuation(values[std::size_t(i)]); value > found.largest)
            found = {leaf.origin + leaf_voxel(i), value};
      },
      [](const Voxel& a, const Voxel& b) { return b.largest > a.largest ? b : a; });
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
double mean_integral(const Field& field, const Attenuation& attenuation, const Places& places) {
  std::optional<Field> met;
  if (field.reader)
    met = part_of_field(field, [&](const Leaf& leaf) { return is_met(leaf.origin, places); });
  const FieldIndex index(met ? *met : field);
  double sum = 0;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const double length = glm::length(glm::dvec3(field.world_from_index[axis]));
    glm::ivec3 voxel;
    for (const int at_b : places[std::size_t(b)])
      for (const int at_c : places[std::size_t(c)]) {
        voxel[b] = at_b;
        voxel[c] = at_c;
        const double line = line_integral(index, attenuation, axis, voxel);
        sum += line * length;
        count += line != 0;
      }
  }
  return count ? sum / count : 0;
}

}  // namespace

double auto_extinction(const Field& field, const TransferFunction* transfer) {
  if (field.active_box.empty()) return 1;
  const Attenuation attenuation{transfer};
  const Box domain = field.domain();
  double mean = 0;
  for (const double part : {0.5, 1.0}) {
    if (mean != 0) break;
    Places places;
    for (int axis = 0; axis < 3; ++axis)
      places[std::size_t(axis)] = lattice(domain.min[axis], domain.max[axis], part);
    mean = mean_integral(field, attenuation, places);
  }
  if (mean == 0) {
    // The field is so sparse that all rays of the lattices missed it.
    const glm::ivec3 voxel = densest_voxel(field, attenuation);
    mean = mean_integral(field, attenuation, {{{voxel.x}, {voxel.y}, {voxel.z}}});
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
