#include "look/file_kind.h"

#include <algorithm>
#include <unordered_set>

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

/// Calls `see` for a sample of the values other than 0.
template <typename See>
void for_sample(const Field& density, See&& see) {
  const std::size_t stride = std::max<std::size_t>(density.leaves.size() / most_leaves, 1);
  for (std::size_t i = 0; i < density.leaves.size(); i += stride)
    for (int n = 0; n < 512; ++n)
      if (const float value = density.leaves[i].values[n]; value != 0) see(value);
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
