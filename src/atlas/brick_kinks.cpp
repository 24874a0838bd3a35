#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "atlas/atlas.h"
#include "field/block_map.h"
#include "field/index_space.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// The textured bricks of a page table: where they are, and their slots. Several may share one.
class BrickPlaces {
 public:
  explicit BrickPlaces(const BrickAtlas& atlas)
      : pages_(atlas.pages), numbers_(atlas.bricks.size()) {
    places_.reserve(atlas.bricks.size());
    for_entries(pages_, [&](std::uint32_t entry, const glm::ivec3& at, int) {
      if (entry_kind(entry) != EntryKind::brick) return;
      numbers_.insert(at, std::int32_t(places_.size()));
      places_.push_back({at, pages_.slot(entry)});
    });
  }

  std::size_t size() const { return places_.size(); }
  std::size_t slot(std::size_t place) const { return places_[place].slot; }
  /// The place beside one; unset where no textured brick is.
  std::optional<std::size_t> beside(std::size_t place, int axis, int way) const {
    glm::ivec3 at = places_[place].brick;
    at[axis] += way;
    const std::int32_t found = numbers_.find(at);
    if (found == BlockMap::none) return {};
    return std::size_t(found);
  }

 private:
  struct Place {
    glm::ivec3 brick;
    std::uint32_t slot;
  };

  const PageTable& pages_;
  std::vector<Place> places_;
  BlockMap numbers_;  ///< of places, by brick
};

/// The largest |low - 2 face + high| of values beside each other. Floats of one sign are ordered as
/// their bits are, and compilers vectorise the maximum of integers.
std::int32_t kink_bits(const float* low, const float* face, const float* high, std::size_t count) {
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < count; ++i)
    largest =
        std::max(largest, std::bit_cast<std::int32_t>(std::abs(low[i] - 2 * face[i] + high[i])));
  return largest;
}

/// The largest kink on the face between two bricks; `before` has the smaller coordinates. A missing
/// brick continues the values of the face.
float face_kink(const float* before, const float* behind, int axis, std::size_t channels) {
  constexpr std::size_t n = brick_values;
  const std::size_t along = axis == 0 ? n * n * channels : axis == 1 ? n * channels : channels;
  const float* face = behind ? behind : before + 8 * along;
  const float* low = before ? before + 7 * along : face;
  const float* high = behind ? behind + along : face;
  // what is side by side in memory
  const std::size_t run = along, runs = n * n * channels / run;
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < runs; ++i) {
    const std::size_t at = i * n * along;
    largest = std::max(largest, kink_bits(low + at, face + at, high + at, run));
  }
  // NaN where values overflow
  constexpr float infinite = std::numeric_limits<float>::infinity();
  return std::bit_cast<float>(std::min(largest, std::bit_cast<std::int32_t>(infinite)));
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

std::vector<float> brick_kinks(const BrickAtlas& atlas, const std::vector<bool>& wanted) {
  if (!atlas.texels && !atlas.bricks.empty())
    throw Error(ExitCode::failure, "kinks are of float32 texels");
  const BrickPlaces places(atlas);
  const auto channels = std::size_t(atlas.channels);
  const auto wanted_at = [&](std::size_t place) {
    return wanted.empty() || wanted[places.slot(place)];
  };
  const auto texels = [&](std::optional<std::size_t> place) -> const float* {
    return place ? atlas.texels.get() + places.slot(*place) * brick_texels * channels : nullptr;
  };
  std::vector<float> of_place(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t place) {
    if (!wanted_at(place)) return;
    const float* const values = texels(place);
    float kink = channels == 1 ? atlas.bricks[places.slot(place)].second_difference
                               : inner_kink(values, channels);
    for (int axis = 0; axis < 3; ++axis)
      kink =
          std::max({kink, face_kink(texels(places.beside(place, axis, -1)), values, axis, channels),
                    face_kink(values, texels(places.beside(place, axis, 1)), axis, channels)});
    of_place[place] = kink;
  });
  std::vector<float> kinks(atlas.bricks.size());
  for (std::size_t place = 0; place < places.size(); ++place) {
    float& kink = kinks[places.slot(place)];
    kink = std::max(kink, of_place[place]);
  }
  return kinks;
}

}  // namespace psivox
