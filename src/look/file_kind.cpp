#include "look/file_kind.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "look/field_sample.h"

namespace psivox {
namespace {

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
constexpr float least_side = 0.05f;

/// Different values of a sample, ascending.
std::vector<float> values_in(const Field& density) {
  std::vector<float> values;
  for (const SampledVoxel& some : sample_voxels(density, sample_size)) values.push_back(some.value);
  std::ranges::sort(values);
  const auto rest = std::ranges::unique(values);
  values.erase(rest.begin(), rest.end());
  return values;
}

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

bool is_scan(const Field& density, bool known_fog) {
  const std::vector<float> values = values_in(density);
  if (values.size() <= few_values) return false;
  const bool floats = density.value_type == "float" || density.value_type == "double";
  return (are_steps(values) && (floats || !known_fog)) ||
         (!known_fog && values.front() > faded * values.back());
}

bool is_mostly_low(const Field& density) {
  if (!density.active_range) return false;
  double sum = 0, count = 0;
  for (const SampledVoxel& some : sample_voxels(density, sample_size)) {
    sum += double(some.value);
    ++count;
  }
  const double least = double(density.active_range->x), most = double(density.active_range->y);
  return sum < count * (least + low * (most - least));
}

bool is_signed(const Field& density) {
  const float least =
      std::min(density.replaced.least, density.active_range.value_or(glm::vec2(0)).x);
  const float greatest = density.active_range.value_or(glm::vec2(0)).y;
  return least < 0 && -least > least_side * greatest;
}

}  // namespace psivox
