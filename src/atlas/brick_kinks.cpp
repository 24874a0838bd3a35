#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "atlas/block_map.h"
#include "psivox/atlas.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// Finds the bricks of a page table by slot, and slots by brick.
class BrickPlaces {
 public:
  explicit BrickPlaces(const BrickAtlas& atlas)
      : pages_(atlas.pages), at_(atlas.bricks.size()), slots_(atlas.bricks.size()) {
    visit(0, pages_.top_size, pages_.levels - 1, glm::ivec3(0));
  }

  glm::ivec3 brick(std::size_t slot) const { return at_[slot]; }
  std::int32_t slot(const glm::ivec3& brick) const { return slots_.find(brick); }

 private:
  void visit(std::size_t base, const glm::ivec3& size, int level, const glm::ivec3& first) {
    std::size_t index = base;
    for (int x = 0; x < size.x; ++x)
      for (int y = 0; y < size.y; ++y)
        for (int z = 0; z < size.z; ++z) {
          const std::uint32_t entry = pages_.entries[index++];
          const glm::ivec3 at = first + glm::ivec3(x, y, z) * (1 << (3 * level));
          if (entry_kind(entry) == EntryKind::child)
            visit(entry_payload(entry), glm::ivec3(8), level - 1, at);
          if (entry_kind(entry) != EntryKind::brick) continue;
          at_[entry_payload(entry)] = at;
          slots_.insert(at, std::int32_t(entry_payload(entry)));
        }
  }

  const PageTable& pages_;
  std::vector<glm::ivec3> at_;
  atlas::BlockMap slots_;
};

/// The largest kink on the face between two bricks; `before` has the smaller coordinates. A missing
/// brick continues the values of the face.
float face_kink(const float* before, const float* behind, int axis, std::size_t channels) {
  constexpr std::size_t n = brick_values;
  const std::size_t strides[] = {n * n * channels, n * channels, channels};
  const std::size_t along = strides[axis], u = strides[(axis + 1) % 3], v = strides[(axis + 2) % 3];
  float largest = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t at = i * u + k * v; at < i * u + k * v + channels; ++at) {
        const float face = behind ? behind[at] : before[at + 8 * along];
        const float low = before ? before[at + 7 * along] : face;
        const float high = behind ? behind[at + along] : face;
        largest = std::max(largest, std::abs(low - 2 * face + high));
      }
  return largest;
}

/// The largest kink inside a brick.
float inner_kink(const float* values, std::size_t channels) {
  constexpr std::size_t n = brick_values;
  float largest = 0;
  for (const std::size_t along : {n * n * channels, n * channels, channels})
    for (std::size_t at = along; at + along < brick_texels * channels; ++at)
      if (const std::size_t place = at / along % n; place > 0 && place < n - 1)
        largest =
            std::max(largest, std::abs(values[at - along] - 2 * values[at] + values[at + along]));
  return largest;
}

}  // namespace

std::vector<float> brick_kinks(const BrickAtlas& atlas) {
  if (!atlas.texels32 && !atlas.bricks.empty())
    throw Error(ExitCode::failure, "kinks are of float32 texels");
  const BrickPlaces places(atlas);
  const auto channels = std::size_t(atlas.channels);
  const auto texels = [&](std::int32_t of) -> const float* {
    return of < 0 ? nullptr : atlas.texels32.get() + std::size_t(of) * brick_texels * channels;
  };
  // kinks of each brick's three lower faces
  std::vector<std::array<float, 3>> lower(atlas.bricks.size());
  std::vector<float> kinks(atlas.bricks.size());
  const auto neighbour = [&](std::size_t slot, int axis, int way) {
    glm::ivec3 at = places.brick(slot);
    at[axis] += way;
    return places.slot(at);
  };
  tbb::parallel_for(std::size_t{0}, kinks.size(), [&](std::size_t slot) {
    const float* own = texels(std::int32_t(slot));
    kinks[slot] = channels == 1 ? atlas.bricks[slot].second_difference : inner_kink(own, channels);
    for (int axis = 0; axis < 3; ++axis) {
      float& face = lower[slot][std::size_t(axis)];
      face = face_kink(texels(neighbour(slot, axis, -1)), own, axis, channels);
      kinks[slot] = std::max(kinks[slot], face);
      if (neighbour(slot, axis, 1) < 0)
        kinks[slot] = std::max(kinks[slot], face_kink(own, nullptr, axis, channels));
    }
  });
  for (std::size_t slot = 0; slot < kinks.size(); ++slot)
    for (int axis = 0; axis < 3; ++axis)
      if (const std::int32_t next = neighbour(slot, axis, 1); next >= 0)
        kinks[slot] = std::max(kinks[slot], lower[std::size_t(next)][std::size_t(axis)]);
  return kinks;
}

}  // namespace psivox
