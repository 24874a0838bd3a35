#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <type_traits>

#include "atlas/brick_code.h"
#include "base/memory.h"
#include "field/lane_range.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr int word_bits[] = {7, 12, 16};  // of a code, by width

int bits_of(CodeWidth width) { return word_bits[std::size_t(width)]; }

/// The step of codes from 0 to `most` that reach over `range`: of the narrowest steps that a head
/// can hold, the one whose multiple is nearest to the range. The greatest value is then nearly
/// exact: it often fills the inside of a cloud, where a ray meets its error in every voxel.
float step_of(double range, double most) {
  constexpr float least = 1e-37F;  // no code is a denormal number
  constexpr int tries = 8;         // the last is at most 1.6 % wider than the first
  float best = 0;
  double least_off = 1;
  auto bits = std::bit_cast<std::uint32_t>(std::max(float(range / most), least));
  for (int i = 0; i < tries; ++i) {
    bits = (bits + code_width_bits + 1) & ~code_width_bits;
    const auto step = std::bit_cast<float>(bits);
    const double codes = range / double(step), off = std::abs(codes - std::round(codes));
    if (off < least_off) {
      best = step;
      least_off = off;
    }
  }
  return best;
}

/// The code of values from `min` to `max`. 0 is one of its values if it lies between them. Where
/// values may be absent, the last code stands for them.
BrickCode code_of(float min, float max, CodeWidth width, bool absent) {
  const double codes = (1 << bits_of(width)) - (absent ? 2 : 1);
  const bool around_zero = min < 0 && max > 0;
  const float step = step_of(double(max) - double(min), around_zero ? codes - 1 : codes);
  const float offset =
      around_zero ? float(-double(step) * std::ceil(-double(min) / double(step))) : min;
  return {offset, step, 1 / step, float(codes) + 0.5F};
}

/// A brick's values in one atlas: its channels share a code.
struct Record {
  const float* values;
  int channels;
  float min, max;
  bool absent = false;  ///< values may be

  bool can_be_coded() const { return std::isfinite(max - min); }
};

Record record_of(const BrickAtlas& atlas, std::size_t slot) {
  const auto channels = std::size_t(atlas.channels);
  const float* values = atlas.texels.get() + slot * brick_texels * channels;
  if (channels == 1)
    return {values, 1, atlas.bricks[slot].min, atlas.bricks[slot].max, atlas.absent};
  LaneRange<brick_texels> range;
  for (std::size_t i = 0; i < channels; ++i) range.include(values + i * brick_texels);
  return {values, atlas.channels, range.least(), range.greatest()};
}

/// Of the density and what is beside it.
std::size_t channels_of(const BrickAtlas* beside) {
  return beside ? 1 + std::size_t(beside->channels) : 1;
}

/// Calls each(record) for the brick's own, and then for that beside it.
template <typename Each>
void for_records(const BrickAtlas& atlas, const BrickAtlas* beside, std::size_t slot,
                 const Each& each) {
  each(record_of(atlas, slot));
  if (beside) each(record_of(*beside, slot));
}

/// Writes each word of a channel, `stride` words behind the one before.
void encode(const Record& record, int channel, CodeWidth width, std::uint64_t* words,
            std::size_t stride) {
  const BrickCode code = code_of(record.min, record.max, width, record.absent);
  const float* const values = record.values + channel;
  std::array<std::int32_t, brick_texels> codes;
  const auto find = [&](auto channels) {
    for (std::size_t i = 0; i < codes.size(); ++i)
      codes[i] = code.of(values[i * std::size_t(channels)]);
    if (record.absent)
      for (std::size_t i = 0; i < codes.size(); ++i)
        if (std::isnan(values[i * std::size_t(channels)])) codes[i] = (1 << bits_of(width)) - 1;
  };
  if (record.channels == 1)
    find(std::integral_constant<int, 1>());  // which vectorises
  else
    find(record.channels);
  const auto write = [&](std::uint64_t word) {
    *words = word;
    words += stride;
  };
  write(std::bit_cast<std::uint32_t>(code.offset) |
        std::uint64_t{std::bit_cast<std::uint32_t>(code.step) | std::uint32_t(width)} << 32);
  const auto pack = [&]<int wide>(std::integral_constant<int, wide>) {  // loops of known lengths
    constexpr int cells = brick_cells >> wide;
    for (int row = 0; row < brick_values * brick_values; ++row)
      for (int z = 0; z < brick_cells; z += cells) {
        const std::int32_t* const first = codes.data() + row * brick_values + z;
        std::uint64_t word = 0;
        for (int i = cells; i >= 0; --i) word = word << word_bits[wide] | std::uint64_t(first[i]);
        write(word);
      }
  };
  if (width == CodeWidth::bits7) pack(std::integral_constant<int, 0>());
  if (width == CodeWidth::bits12) pack(std::integral_constant<int, 1>());
  if (width == CodeWidth::bits16) pack(std::integral_constant<int, 2>());
}

/// Words of one channel of a brick.
std::size_t words_of(CodeWidth width) { return std::size_t(code_words) << int(width); }

/// Where codes of these widths begin, by slot, and where they end, in units of `code_words`.
std::vector<std::uint32_t> places_of(const std::vector<CodeWidth>& widths) {
  std::vector<std::uint32_t> places{0};
  for (const CodeWidth width : widths) places.push_back(places.back() + (1u << int(width)));
  return places;
}

}  // namespace

CodeWidths code_widths(const BrickAtlas& atlas, std::span<const float> steps,
                       const BrickAtlas* beside, float step_beside) {
  auto widths = std::make_shared<std::vector<CodeWidth>>();
  bool fits = true;
  for (std::size_t slot = 0; slot < atlas.bricks.size() && fits; ++slot) {
    float most = steps[slot];
    int width = 0;
    for_records(atlas, beside, slot, [&](const Record& record) {
      while (width < 3 &&
             !(code_of(record.min, record.max, CodeWidth(width), record.absent).step <= most))
        ++width;
      fits = fits && width < 3 && record.can_be_coded();
      most = step_beside;
    });
    widths->push_back(CodeWidth(width));
  }
  return fits ? widths : nullptr;
}

BrickCodes brick_codes(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                       const BrickAtlas* beside) {
  const std::size_t count = widths.size();
  BrickCodes codes{std::vector<BrickCode>(count), std::vector<BrickCode>(beside ? count : 0)};
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t slot) {
    std::vector<BrickCode>* to = &codes.own;
    for_records(atlas, beside, slot, [&](const Record& record) {
      (*to)[slot] = code_of(record.min, record.max, widths[slot], record.absent);
      to = &codes.beside;
    });
  });
  return codes;
}

std::uint64_t coded_bytes(const std::vector<CodeWidth>& widths, const BrickAtlas* beside) {
  return places_of(widths).back() * code_words * channels_of(beside) * sizeof(std::uint64_t);
}

/// Stores the codes of a brick and of the brick beside it.
static void encode(const BrickAtlas& atlas, const BrickAtlas* beside, std::size_t slot,
                   CodeWidth width, std::uint64_t* to) {
  const std::size_t records = channels_of(beside);
  const std::size_t rows = std::size_t(brick_values * brick_values) << int(width);
  std::fill(to + (1 + rows) * records, to + words_of(width) * records, 0);
  for_records(atlas, beside, slot, [&](const Record& record) {
    if (!record.can_be_coded())
      throw Error(ExitCode::input, "values reach from " + std::to_string(record.min) + " to " +
                                       std::to_string(record.max) +
                                       ", beyond codes; use --texel float32");
    for (int channel = 0; channel < record.channels; ++channel)
      encode(record, channel, width, to++, records);
  });
}

BrickAtlas coded(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                 const BrickAtlas* beside, bool replaces) {
  if (!atlas.texels && !atlas.bricks.empty())
    throw Error(ExitCode::failure, "codes are of float32 texels");
  BrickAtlas result = atlas;
  result.texels.reset();
  std::vector<std::uint32_t> places = places_of(widths);
  const std::uint32_t end = places.back();
  PageTable& pages = result.pages;
  pages.octants = pages.octants && end >> entry_slot_bits == 0;
  for (std::uint32_t& entry : pages.entries) {
    if (entry_kind(entry) != EntryKind::brick) continue;
    const std::uint32_t hidden = pages.octants ? entry_payload(entry) >> entry_slot_bits : 0;
    entry =
        make_entry(EntryKind::brick, places[atlas.pages.slot(entry)] | hidden << entry_slot_bits);
  }
  const std::size_t bricks = widths.size(), unit = code_words * channels_of(beside);
  // codes of a brick must lie before the texels of the next
  replaces = replaces && atlas.texels;
  for (std::size_t slot = 0; slot < bricks && replaces; ++slot)
    replaces = places[slot + 1] * unit * sizeof(std::uint64_t) <=
               (slot + 1) * brick_texels * sizeof(float);
  if (replaces)
    result.codes = {atlas.texels, reinterpret_cast<std::uint64_t*>(atlas.texels.get())};
  else
    result.codes = page_array<std::uint64_t>(end * unit);
  const std::size_t at_once = replaces ? 1024 : bricks;
  std::vector<std::uint64_t> some;  // beside the texels that they replace
  for (std::size_t first = 0; first < bricks; first += at_once) {
    const std::size_t last = std::min(first + at_once, bricks), begin = places[first] * unit;
    const std::size_t words = places[last] * unit - begin;
    if (replaces) some.resize(words);
    std::uint64_t* const to = replaces ? some.data() : result.codes.get();
    tbb::parallel_for(first, last, [&](std::size_t slot) {
      encode(atlas, beside, slot, widths[slot], to + places[slot] * unit - begin);
    });
    if (replaces) std::memcpy(result.codes.get() + begin, to, words * sizeof(std::uint64_t));
  }
  if (replaces)
    give_back(result.codes.get() + end * unit,
              atlas.texel_count() * sizeof(float) - end * unit * sizeof(std::uint64_t));
  places.pop_back();
  result.code_places = std::move(places);
  result.size.texel_bytes = end * unit * sizeof(std::uint64_t);
  return result;
}

}  // namespace psivox
