#include "medium/stored_density.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "medium/map_field.h"
#include "vdb/reading_messages.h"

namespace psivox {
namespace {

/// How often an overview is halved to have so many leaves at most.
int overview_level(const Field& field, std::size_t most) {
  std::vector<glm::ivec3> places;
  for (const Leaf& leaf : field.leaves) places.push_back(leaf.origin >> 3);
  int level = 0;
  for (; places.size() > most; ++level) {
    for (glm::ivec3& place : places) place >>= 1;
    std::ranges::sort(places, comes_before);
    const auto same = std::ranges::unique(places);
    places.erase(same.begin(), same.end());
  }
  return level;
}

}  // namespace

std::string topology_of(const Field& field) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const Leaf& leaf : field.leaves)
    for (int axis = 0; axis < 3; ++axis)
      hash = (hash ^ std::uint32_t(leaf.origin[axis])) * 1099511628211u;
  return std::to_string(hash) + " " + std::to_string(field.active_voxels);
}

Field overview_of(const Field& stored, Centering centering, std::uint64_t memory,
                  std::size_t most_leaves) {
  // an atlas on host and GPU has 5.7 KiB for the 2 KiB of a leaf
  const std::uint64_t leaf_bytes = 4 * 512 * sizeof(float) * std::uint64_t(stored.channels);
  while (most_leaves > 8 && memory > 0 && leaf_bytes * most_leaves > memory) most_leaves /= 2;
  const int level = overview_level(stored, most_leaves);
  return level > 0 ? coarse_field(stored, level, centering, CoarseValue::sample)
                   : part_of_field(stored, everywhere);
}

void take_first(Field& field, Team& team) {
  if (team.size() == 1) return;
  std::vector<float> values;
  if (team.first() && !stays_in_file(field))
    for (const Leaf& leaf : field.leaves) {
      const OrderedValues own(field, leaf);
      values.insert(values.end(), own.begin(), own.end());
    }
  const std::string first = team.gather(team.first() ? guard::packed(field, values) : "").front();
  if (team.first()) return;
  guard::unpack(first, field, values);
  if (values.empty()) return;
  field.reader = {};
  fill_leaves(field, [&](std::size_t n, float* to) {
    const std::size_t floats = values.size() / field.leaves.size();
    std::copy_n(values.begin() + std::ptrdiff_t(n * floats), floats, to);
  });
}

bool is_shared(const Parts& parts) { return parts.team->size() > 1; }

std::uint64_t own_memory(const Scene& scene, const Parts& parts) {
  // a limit is each process's
  const int sharing = scene.memory_limit ? 1 : parts.team->place().local_size;
  return grid_memory(scene) / std::uint64_t(sharing);
}

}  // namespace psivox
