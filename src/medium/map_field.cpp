#include "medium/map_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <cstddef>
#include <memory>

#include "field/field_index.h"
#include "medium/fill_domain.h"
#include "medium/gradient_field.h"
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

Field attenuation_of_voxels(const Field& field, const TransferFunction& function) {
  const auto map = [&](const glm::vec3& value) {
    const TransferPoint point = function.at(static_cast<double>(value.x));
    return glm::vec3(static_cast<float>(point.attenuation), 0, 0);
  };
  if (function.at(0).attenuation == 0) return map_field(field, 1, map);
  Field whole = field;
  fill_domain(whole);
  return map_field(whole, 1, map);
}

Field attenuation_of_voxels(const Field& field, const Field& gradient,
                            const TransferFunction& function) {
  Field whole = field;
  if (function.attenuation(0, 0) > 0) fill_domain(whole);
  whole = told_by_blocks(whole, gradient, true);
  const FieldIndex values(whole), gradients(gradient);

  // Places where values or gradients vary become leaves; the rest are tiles without gradients.
  Field result = whole;
  result.active_range.reset();
  result.stored_range.reset();
  result.tiles.clear();
  for (const Tile& tile : whole.tiles) {
    if (tile.width == 8 && gradients.stores(tile.origin)) {
      result.leaves.push_back({tile.origin, nullptr});
      continue;
    }
    const double v = static_cast<double>(tile.value.x);
    const auto attenuation = static_cast<float>(function.attenuation(v, 0));
    if (attenuation != 0)
      result.tiles.push_back({tile.origin, tile.width, glm::vec3(attenuation, 0, 0)});
  }
  const auto to = std::make_shared_for_overwrite<float[]>(result.leaves.size() * 512);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, result.leaves.size(), 16),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t n = range.begin(); n != range.end(); ++n) {
                        Leaf& leaf = result.leaves[n];
                        const FieldIndex::Block v = values.block(leaf.origin);
                        const FieldIndex::Block g = gradients.block(leaf.origin);
                        float* attenuation = to.get() + n * 512;
                        leaf.values = attenuation;
                        for (int i = 0; i < 512; ++i)
                          attenuation[i] = static_cast<float>(function.attenuation(
                              static_cast<double>(v.value(i)), static_cast<double>(g.value(i))));
                      }
                    });
  result.array.reset();
  result.storage = to;
  return result;
}

Field color_of_voxels(const Field& field, const TransferFunction& function) {
  Field whole = field;
  if (function.at(0).attenuation > 0)
    fill_domain(whole);
  else if (function.at(0).color != glm::dvec3(0))
    fill_surroundings(whole);
  return map_field(whole, 3, [&](const glm::vec3& value) {
    return glm::vec3(function.at(static_cast<double>(value.x)).color);
  });
}

}  // namespace psivox
