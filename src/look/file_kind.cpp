#include "look/file_kind.h"

#include <algorithm>
#include <unordered_set>
#include <vector>

#include "psivox/leaf_values.h"

namespace psivox {
namespace {

/// Leaves that are looked at: a sample of 32 k voxels.
constexpr std::size_t most_leaves = 64;
/// A mask or a solid has few values too, but no more than this.
constexpr std::size_t few_values = 8, most_steps = 256;
/// Smoke fades to this part of its greatest value, at the most.
constexpr float faded = 0.02f;

/// A mean in this part of the range is low.
constexpr double low = 0.25;

/// Values of some leaves that are spread over a density, wherever its values are, in no order.
std::vector<float> sample(const Field& density) {
  const std::size_t stride = std::max<std::size_t>(density.leaves.size() / most_leaves, 1);
  std::vector<float> own;
  const auto take = [&](const Leaf& leaf) {
    const OrderedValues values(density, leaf);
    own.insert(own.end(), values.begin(), values.begin() + 512);
  };
  if (!density.reader) {
    for (std::size_t i = 0; i < density.leaves.size(); i += stride) take(density.leaves[i]);
    return own;
  }
  visit_own_leaves(
      density, [&](std::span<const Leaf> leaves) { std::ranges::for_each(leaves, take); },
      [&](const Leaf& leaf) { return std::size_t(&leaf - density.leaves.data()) % stride == 0; });
  return joined_found(density, own);
}

/// Calls `see` for a sample of the values other than 0, ascending: what they sum up to does not
/// depend on which process has which.
template <typename See>
void for_sample(const Field& density, See&& see) {
  std::vector<float> values = sample(density);
  std::ranges::sort(values);
  for (const float value : values)
    if (value != 0) see(value);
}

}  // namespace

std::string flame_grid(const VdbFile& file, const std::string& density) {
  for (const char* name : {"flame", "flames", "fire", "temperature", "heat", "temp", "fuel"})
    if (name != density && file.channels(name) == 1) return name;
  return "";
}

bool is_scan(const Field& density) {
  std::unordered_set<float> values;
  float least = HUGE_VALF, greatest = 0;
  for_sample(density, [&](float value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    if (values.size() <= most_steps) values.insert(value);
  });
  if (values.size() <= few_values) return false;
  return values.size() <= most_steps || least > faded * greatest;
}

bool is_mostly_low(const Field& density) {
  if (!density.active_range) return false;
  double sum = 0, count = 0;
  for_sample(density, [&](float value) {
    sum += double(value);
    ++count;
  });
  const double least = double(density.active_range->x), most = double(density.active_range->y);
  return sum < count * (least + low * (most - least));
}

}  // namespace psivox
