#include "look/field_kind.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <tuple>

#include "field/field_cursor.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/label_function.h"

namespace psivox {
namespace {

/// One voxel of each cell of a lattice over the active box: a fixed one that looks random, so that
/// no pattern in the values meets the lattice's own.
class Lattice {
 public:
  Lattice(const Box& box, int width) : box_(box), width_(width) {}

  /// Calls see(voxel) for the chosen voxels in the cube until it returns true, and returns whether
  /// it did.
  template <typename See>
  bool any_in(const glm::ivec3& origin, int size, See&& see) const {
    const Box cube = common({origin, origin + (size - 1)}, box_);
    if (cube.empty()) return false;
    const glm::ivec3 first = (cube.min - box_.min) / width_, last = (cube.max - box_.min) / width_;
    for (int x = first.x; x <= last.x; ++x)
      for (int y = first.y; y <= last.y; ++y)
        for (int z = first.z; z <= last.z; ++z) {
          const glm::ivec3 voxel = chosen({x, y, z});
          if (cube.contains(voxel) && see(voxel)) return true;
        }
    return false;
  }

 private:
  glm::ivec3 chosen(const glm::ivec3& cell) const {
    std::uint64_t bits = (std::uint64_t(std::uint32_t(cell.x)) * 0x9E3779B97F4A7C15u) ^
                         (std::uint64_t(std::uint32_t(cell.y)) * 0xC2B2AE3D27D4EB4Fu) ^
                         (std::uint64_t(std::uint32_t(cell.z)) * 0x165667B19E3779F9u);
    // splitmix64's finaliser (Steele, Lea and Flood 2014)
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
    bits ^= bits >> 31;
    const auto place = [&](int shift) {
      return int(((bits >> shift) & 0x1FFFFF) * std::uint64_t(width_) >> 21);
    };
    return box_.min + cell * width_ + glm::ivec3(place(0), place(21), place(42));
  }

  Box box_;
  int width_;
};

std::vector<SampledVoxel> on_lattice(const Field& field, const Lattice& lattice) {
  std::vector<SampledVoxel> all;
  visit_leaves(
      field,
      [&](std::span<const Leaf> leaves) {
        for (const Leaf& leaf : leaves) {
          const LeafValues values = values_of(field, leaf);
          lattice.any_in(leaf.origin, 8, [&](const glm::ivec3& voxel) {
            if (const float value = *values.at(voxel - leaf.origin); is_active(value))
              all.push_back({voxel, value});
            return false;
          });
        }
      },
      [&](const Leaf& leaf) {
        return lattice.any_in(leaf.origin, 8, [](const glm::ivec3&) { return true; });
      });
  for (const Tile& tile : field.tiles)
    lattice.any_in(tile.origin, tile.width, [&](const glm::ivec3& voxel) {
      if (is_active(tile.value.x)) all.push_back({voxel, tile.value.x});
      return false;
    });
  std::ranges::sort(all, {}, [](const SampledVoxel& some) {
    return std::tuple(some.voxel.x, some.voxel.y, some.voxel.z);
  });
  return all;
}

/// Voxels of the active box that leaves or tiles may hold.
double stored_voxels(const Field& field) {
  double count = 0;
  for (const Tile& tile : field.tiles) {
    const glm::dvec3 size =
        glm::dvec3(glm::min(tile.origin + (tile.width - 1), field.active_box.max)) -
        glm::dvec3(glm::max(tile.origin, field.active_box.min)) + 1.0;
    if (size.x > 0 && size.y > 0 && size.z > 0) count += size.x * size.y * size.z;
  }
  return std::max(count, double(field.active_voxels));
}

constexpr std::size_t sample_size = 16384;
/// A mask or a solid has few values too, but no more than this; eight bits have no more than that.
constexpr std::size_t few_values = 8, most_steps = 255;
/// How far from a whole step a value may be, in steps: the rounding of half floats moves the 255th
/// step by 1/8.
constexpr double step_rounding = 0.2;
/// Smoke fades to this part of its greatest value, at the most.
constexpr float faded = 0.02f;
/// A mean in this part of the range is low.
constexpr double low = 0.25;
/// Undershoots of a solver are smaller.
constexpr double least_side = 0.05;
/// Faulty voxels below 0 are fewer than this part of all.
constexpr double rare = 1e-3;

/// Whether all are whole multiples of the greatest one's n-th part, for an n of at most 255. Of
/// more than 50 values that are no steps, one in 10^20 samples would look so by chance: 0.4 of
/// random values are so near to a step.
bool are_steps(const std::vector<float>& values) {
  if (values.size() > most_steps) return false;
  for (std::size_t n = values.size(); n <= most_steps; ++n) {
    const double step = double(values.back()) / double(n);
    if (std::ranges::all_of(values, [&](float value) {
          const double place = double(value) / step;
          return std::abs(place - std::round(place)) <= step_rounding;
        }))
      return true;
  }
  return false;
}

}  // namespace

std::vector<SampledVoxel> sample_voxels(const Field& field, std::size_t wanted) {
  if (field.active_box.empty()) return {};
  const double per_sample = stored_voxels(field) / double(wanted);
  int width = std::max(1, int(std::cbrt(per_sample)));
  std::vector<SampledVoxel> found = on_lattice(field, {field.active_box, width});
  // many active voxels may be 0
  while (found.size() < wanted / 4 && width > 1) {
    width /= 2;
    found = on_lattice(field, {field.active_box, width});
  }
  return found;
}

const std::vector<SampledVoxel>& FieldKind::sample() {
  if (!sample_) sample_ = sample_voxels(density_, sample_size);
  return *sample_;
}

const std::vector<float>& FieldKind::values() {
  if (values_) return *values_;
  values_.emplace();
  for (const SampledVoxel& some : sample()) values_->push_back(some.value);
  std::ranges::sort(*values_);
  return *values_;
}

std::vector<float> FieldKind::distinct_values() {
  std::vector<float> distinct = values();
  const auto rest = std::ranges::unique(distinct);
  distinct.erase(rest.begin(), rest.end());
  return distinct;
}

bool FieldKind::is_scan(bool known_fog, bool full) {
  const std::vector<float> distinct = distinct_values();
  if (distinct.size() <= few_values) return false;
  const bool floats = density_.value_type == "float" || density_.value_type == "double";
  return full || (are_steps(distinct) && (floats || !known_fog)) ||
         (!known_fog && distinct.front() > faded * distinct.back());
}

namespace {

/// Values of voxels spread over the faces of the active box, ascending.
std::vector<double> border_values(const Field& density) {
  constexpr int across = 24;
  FieldCursor values(density);
  std::vector<double> found;
  const Box& box = density.active_box;
  for (int face = 0; face < 6; ++face)
    for (int i = 0; i < across; ++i)
      for (int k = 0; k < across; ++k) {
        const int axis = face >> 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
        glm::ivec3 at;
        at[axis] = face & 1 ? box.max[axis] : box.min[axis];
        at[u] = box.min[u] + (box.max[u] - box.min[u]) * i / (across - 1);
        at[v] = box.min[v] + (box.max[v] - box.min[v]) * k / (across - 1);
        if (const double value = values.at(at); !std::isnan(value)) found.push_back(value);
      }
  std::ranges::sort(found);
  return found;
}

/// The middle of some ascending values if so large a part of them, half at least, are equal.
std::optional<double> most_common(const std::vector<double>& sorted, double part = 0.5) {
  if (sorted.empty()) return {};
  const double middle = sorted[sorted.size() / 2];
  const auto [first, last] = std::ranges::equal_range(sorted, middle);
  if (double(last - first) < part * double(sorted.size())) return {};
  return middle;
}

}  // namespace

bool FieldKind::is_labels() {
  if (!labels_) labels_ = find_labels();
  return *labels_;
}

bool FieldKind::find_labels() {
  constexpr std::size_t few = 16;
  constexpr double alike = 0.6, surely = 0.85, steps = 0.5, enough = 1000;
  const std::string& type = density_.value_type;
  bool whole = type.find("int") != type.npos || type == "bool" || type == "mask";
  if (type == "points" || density_.channels > 1 || density_.reader) return false;
  const std::vector<float> found = distinct_values();
  // of one value alone it may be a solid
  whole = whole || (found.size() > 1 && std::ranges::all_of(found, [](float value) {
                      return value == std::floor(value);
                    }));
  if (found.empty() || (!whole && !are_steps(found))) return false;
  const double outside = most_common(border_values(density_)).value_or(0);
  FieldCursor cursor(density_);
  double pairs = 0;
  std::vector<double> passes;  // from a voxel to the next one, where values differ
  for (const SampledVoxel& some : sample())
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 beside = some.voxel;
      ++beside[axis];
      const double value = cursor.at(beside), step = std::abs(value - double(some.value));
      if (value == 0 || std::isnan(value)) continue;
      if (value == outside && step == 0) continue;  // as everywhere around the object
      ++pairs;
      if (step > 0) passes.push_back(step);
    }
  const double same = pairs - double(passes.size());
  if (same < alike * pairs || (!whole && pairs < enough)) return false;
  const auto counts = label_counts(density_);
  if (!counts || counts->empty() || (!whole && counts->size() < few)) return false;
  // one value that fills the whole box is no body in an outside
  if (counts->size() == 1 && density_.active_voxels >= count_of(density_.active_box)) return false;
  double least_step = HUGE_VAL;
  for (auto label = counts->begin(); std::next(label) != counts->end(); ++label)
    least_step = std::min(least_step, double(std::next(label)->first) - double(label->first));
  // neighbours in a scan of few values are one step apart
  const auto next =
      double(std::ranges::count_if(passes, [&](double step) { return step < 1.5 * least_step; }));
  return counts->size() <= 8 || same >= surely * pairs || next <= steps * double(passes.size());
}

std::optional<double> FieldKind::outside() {
  if (!outside_) outside_.emplace(find_outside());
  return *outside_;
}

std::optional<double> FieldKind::find_outside() {
  constexpr double narrow = 0.1;
  if (density_.active_box.empty() || density_.reader || density_.channels > 1) return {};
  const std::vector<double> border = border_values(density_);
  const glm::dvec2 range = active_range(density_);
  if (border.empty() || !(range.x < range.y)) return {};
  if (const auto common = most_common(border)) return common;
  const double low = border[border.size() / 10], middle = border[border.size() / 2],
               high = border[border.size() * 9 / 10];
  const std::vector<float>& all = values();
  if (all.empty()) return {};
  if (low > double(all[all.size() / 2])) return middle;
  // or about the same value at the border and in most of the volume
  const double spread = high - low;
  const auto near = std::ranges::count_if(all, [&](float value) {
    return double(value) >= low - spread && double(value) <= high + spread;
  });
  if (spread <= narrow * double(all.back() - all.front()) && 2 * near >= std::ptrdiff_t(all.size()))
    return middle;
  return {};
}

std::optional<double> FieldKind::label_outside() {
  constexpr double nearly_all = 0.9;
  const std::optional<double> label = most_common(border_values(density_), nearly_all);
  const glm::dvec2 range = active_range(density_);
  return is_labels() && range.x < range.y ? label : std::nullopt;
}

bool FieldKind::is_negative_outside() const {
  std::vector<double> border = border_values(density_);
  std::erase(border, 0);
  return !border.empty() && border[border.size() / 2] < 0;
}

bool FieldKind::is_about_0() {
  constexpr double near_0 = 0.02, middle = 0.05, lopsided = 3;
  const glm::dvec2 range = active_range(density_);
  if (const std::optional<double> value = outside())
    return std::abs(*value) <= near_0 * std::max(-range.x, range.y);
  const double low = active_percentile(density_, 1), high = active_percentile(density_, 99);
  return low < 0 && high > 0 && std::max(-low / high, high / -low) <= lopsided &&
         std::abs(active_percentile(density_, 50)) <= middle * (high - low);
}

bool FieldKind::is_body() {
  // From each face of the box inwards: of the rays that meet something, how many have reached half
  // of the brighter values within a few voxels of where they met the first?
  constexpr int across = 32, few = 6;
  constexpr double most_rays = 0.6;
  if (values().empty()) return false;
  const double high = double(values()[values().size() * 9 / 10]);
  if (!(high > 0)) return false;
  FieldCursor cursor(density_);
  const Box& box = density_.active_box;
  int rays = 0, reached = 0;
  for (int face = 0; face < 6; ++face)
    for (int i = 0; i < across; ++i)
      for (int k = 0; k < across; ++k) {
        const int axis = face >> 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
        glm::ivec3 at;
        at[u] = box.min[u] + (box.max[u] - box.min[u]) * (2 * i + 1) / (2 * across);
        at[v] = box.min[v] + (box.max[v] - box.min[v]) * (2 * k + 1) / (2 * across);
        int left = -1;
        for (int d = box.min[axis]; d <= box.max[axis] && left != 0; ++d) {
          at[axis] = face & 1 ? box.max[axis] + box.min[axis] - d : d;
          const double value = cursor.at(at);
          if (left < 0 && value > 0.1 * high) {
            left = few;
            ++rays;
          }
          if (left < 0) continue;
          if (value >= 0.5 * high) {
            ++reached;
            break;
          }
          --left;
        }
      }
  return rays > 0 && reached > most_rays * rays;
}

bool FieldKind::is_mostly_low() {
  if (!density_.active_range) return false;
  double sum = 0;
  for (const SampledVoxel& some : sample()) sum += double(some.value);
  const double least = double(density_.active_range->x), most = double(density_.active_range->y);
  return sum < double(sample().size()) * (least + low * (most - least));
}

bool FieldKind::is_veiled() {
  return 2 * density_.active_voxels < count_of(density_.active_box) && is_mostly_low();
}

bool FieldKind::is_signed() const {
  // where reading put 0 in place of values below it, there is no range yet
  const auto negative = double(density_.replaced.negative);
  if (!density_.active_range && negative == 0) return false;
  if (negative > 0 && negative < rare * stored_voxels(density_)) return false;
  const glm::dvec2 range = active_range(density_);
  const double least = std::min(double(density_.replaced.least), range.x);
  return least < 0 && -least > least_side * range.y;
}

namespace {

/// Gradient at a voxel by central differences [1/voxel]. Unset where a neighbour is not known or at
/// an end of the range, where distances are cut off.
std::optional<glm::dvec3> gradient_at(FieldCursor& values, const glm::ivec3& voxel,
                                      const glm::dvec2& range) {
  glm::dvec3 differences;
  for (int axis = 0; axis < 3; ++axis) {
    glm::ivec3 step(0);
    step[axis] = 1;
    const double before = values.at(voxel - step), behind = values.at(voxel + step);
    for (const double value : {before, behind})
      if (!(value > range.x && value < range.y) || value == 0) return {};
    differences[axis] = 0.5 * (behind - before);
  }
  return differences;
}

/// Whether three in four are equally long to 10 %, and they do not point in one direction.
bool are_of_distances(const std::vector<glm::dvec3>& gradients) {
  constexpr double nearly = 0.1, most = 0.75, one_way = 0.9;
  std::vector<double> lengths;
  glm::dvec3 sum(0);
  for (const glm::dvec3& gradient : gradients) {
    lengths.push_back(glm::length(gradient));
    if (lengths.back() > 0) sum += gradient / lengths.back();
  }
  std::ranges::sort(lengths);
  const double middle = lengths[lengths.size() / 2], count = double(lengths.size());
  const auto alike = std::ranges::upper_bound(lengths, (1 + nearly) * middle) -
                     std::ranges::lower_bound(lengths, (1 - nearly) * middle);
  return middle > 0 && double(alike) >= most * count && glm::length(sum) <= one_way * count;
}

}  // namespace

bool FieldKind::is_distance() {
  constexpr std::size_t enough = 100;
  if (density_.reader || density_.channels > 1 || !is_signed()) return false;
  const glm::dvec2 range = active_range(density_);
  const glm::dmat3 to_world = glm::transpose(glm::inverse(glm::dmat3(density_.world_from_index)));
  FieldCursor cursor(density_);
  std::vector<glm::dvec3> gradients;
  for (const SampledVoxel& some : sample())
    if (double(some.value) > range.x && double(some.value) < range.y)
      if (const auto gradient = gradient_at(cursor, some.voxel, range))
        gradients.push_back(*gradient);
  if (gradients.size() < enough) return false;
  if (are_of_distances(gradients)) return true;
  for (glm::dvec3& gradient : gradients) gradient = to_world * gradient;
  return are_of_distances(gradients);
}

}  // namespace psivox
