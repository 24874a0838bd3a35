#include "scene/map_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <memory>

#include "psivox/leaf_values.h"

namespace psivox {

Field map_field(const Field& field, int channels, const VoxelMap& map) {
  check_in_memory(field);
  Field result = field;
  result.channels = channels;
  result.active_range.reset();
  result.stored_range.reset();
  const std::size_t from_stride = static_cast<std::size_t>(field.channels);
  const std::size_t to_stride = static_cast<std::size_t>(channels);
  const auto values =
      std::make_shared_for_overwrite<float[]>(field.leaves.size() * 512 * to_stride);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, field.leaves.size(), 16),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t n = range.begin(); n != range.end(); ++n) {
                        const OrderedValues own(field, field.leaves[n]);
                        const float* from = own.data();
                        float* to = values.get() + n * 512 * to_stride;
                        result.leaves[n].values = to;
                        for (int i = 0; i < 512; ++i, from += from_stride, to += to_stride) {
                          glm::vec3 value(0);
                          for (int c = 0; c < field.channels; ++c) value[c] = from[c];
                          value = map(value);
                          for (int c = 0; c < channels; ++c) to[c] = value[c];
                        }
                      }
                    });
  for (Tile& tile : result.tiles) tile.value = map(tile.value);
  std::erase_if(result.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0); });
  result.array.reset();
  result.storage = values;
  return result;
}

}  // namespace psivox
