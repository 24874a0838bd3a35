#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
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
int row_words(CodeWidth width) { return 1 << int(width); }

/// The code of values from `min` to `max`. 0 is one of its values if it lies between them.
BrickCode code_of(float min, float max, CodeWidth width) {
  constexpr float least_step = 1e-37F;  // no code is a denormal number
  const double codes = (1 << bits_of(width)) - 1;
  const bool around_zero = min < 0 && max > 0;
  const double exact = (double(max) - double(min)) / (around_zero ? codes - 1 : codes);
  const auto above = std::bit_cast<std::uint32_t>(std::max(float(exact), least_step)) + 4;
  const auto step = std::bit_cast<float>((above & ~3u) | std::uint32_t(width));
  const float offset =
      around_zero ? float(-double(step) * std::ceil(-double(min) / double(step))) : min;
  return {offset, step, 1 / step, float(codes) + 0.5F};
}

/// A brick's values in one atlas: its channels share a code.
struct Record {
  const float* values;
  int channels;
  float min, max;

  bool can_be_coded() const { return std::isfinite(max - min); }
};

Record record_of(const BrickAtlas& atlas, std::size_t slot) {
  const auto channels = std::size_t(atlas.channels);
  const float* values = atlas.texels32.get() + slot * brick_texels * channels;
  if (channels == 1) return {values, 1, atlas.bricks[slot].min, atlas.bricks[slot].max};
  LaneRange<brick_texels> range;
  for (std::size_t i = 0; i < channels; ++i) range.include(values + i * brick_texels);
  return {values, atlas.channels, range.least(), range.greatest()};
}

/// Calls each(record) for the brick's own, and then for that beside it.
template <typename Each>
void for_records(const BrickAtlas& atlas, const BrickAtlas* beside, std::size_t slot,
                 const Each& each) {
  each(record_of(atlas, slot));
  if (beside) each(record_of(*beside, slot));
}

/// Writes each word of a channel, and zeros behind the rows, `stride` words behind the one before.
void encode(const Record& record, int channel, CodeWidth width, std::uint64_t* words,
            std::size_t stride) {
  const BrickCode code = code_of(record.min, record.max, width);
  const float* const values = record.values + channel;
  std::array<std::int32_t, brick_texels> codes;
  const auto find = [&](auto channels) {
    for (std::size_t i = 0; i < codes.size(); ++i)
      codes[i] = code.of(values[i * std::size_t(channels)]);
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
        std::uint64_t{std::bit_cast<std::uint32_t>(code.step)} << 32);
  const auto pack = [&]<int wide>(std::integral_constant<int, wide>) {  // loops of known lengths
    constexpr int cells = brick_cells >> wide;
    for (std::size_t row = 0; row < codes.size(); row += brick_values)
      for (std::size_t z = 0; z < brick_cells; z += cells) {
        std::uint64_t word = 0;
        for (std::size_t i = cells + 1; i-- > 0;)
          word = word << word_bits[wide] | std::uint64_t(codes[row + z + i]);
        write(word);
      }
  };
  if (width == CodeWidth::bits7) pack(std::integral_constant<int, 0>());
  if (width == CodeWidth::bits12) pack(std::integral_constant<int, 1>());
  if (width == CodeWidth::bits16) pack(std::integral_constant<int, 2>());
  for (int i = 1; i < row_words(width); ++i) write(0);
}

void discard_texels(const BrickAtlas& atlas, std::size_t first, std::size_t end) {
  const std::size_t floats = brick_texels * std::size_t(atlas.channels);
  discard_values(atlas.texels32.get() + first * floats, (end - first) * floats * sizeof(float));
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
      while (width < 3 && !(code_of(record.min, record.max, CodeWidth(width)).step <= most))
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
      (*to)[slot] = code_of(record.min, record.max, widths[slot]);
      to = &codes.beside;
    });
  });
  return codes;
}

std::uint64_t coded_bytes(const std::vector<CodeWidth>& widths, int channels_beside) {
  std::uint64_t rows = 0;
  for (const CodeWidth width : widths) rows += std::uint64_t(row_words(width));
  return rows * code_words * (1 + std::uint64_t(channels_beside)) * sizeof(std::uint64_t);
}

BrickAtlas coded(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                 const BrickAtlas* beside, bool discards_texels) {
  if (!atlas.texels32 && !atlas.bricks.empty())
    throw Error(ExitCode::failure, "codes are of float32 texels");
  BrickAtlas result = atlas;
  result.texels32.reset();
  const std::size_t records = beside ? 1 + std::size_t(beside->channels) : 1;
  std::uint32_t count = 0;
  for (const CodeWidth width : widths) {
    result.code_places.push_back(count);
    count += std::uint32_t(row_words(width));
  }
  PageTable& pages = result.pages;
  pages.octants = pages.octants && count >> entry_slot_bits == 0;
  for (std::uint32_t& entry : pages.entries) {
    if (entry_kind(entry) != EntryKind::brick) continue;
    const std::uint32_t hidden = pages.octants ? entry_payload(entry) >> entry_slot_bits : 0;
    entry = make_entry(EntryKind::brick,
                       result.code_places[atlas.pages.slot(entry)] | hidden << entry_slot_bits);
  }
  const std::size_t words = std::size_t(count) * code_words * records;
  result.codes = std::make_shared_for_overwrite<std::uint64_t[]>(words);
  const auto store = [&](std::size_t slot) {
    std::uint64_t* to =
        result.codes.get() + std::size_t(result.code_places[slot]) * code_words * records;
    for_records(atlas, beside, slot, [&](const Record& record) {
      if (!record.can_be_coded())
        throw Error(ExitCode::input, "values reach from " + std::to_string(record.min) + " to " +
                                         std::to_string(record.max) +
                                         ", beyond codes; use --texel float32");
      for (int channel = 0; channel < record.channels; ++channel)
        encode(record, channel, widths[slot], to++, records);
    });
  };
  const std::size_t bricks = result.bricks.size(), at_once = discards_texels ? 1024 : bricks;
  for (std::size_t first = 0; first < bricks; first += at_once) {
    const std::size_t end = std::min(first + at_once, bricks);
    tbb::parallel_for(first, end, store);
    if (!discards_texels) continue;
    discard_texels(atlas, first, end);
    if (beside) discard_texels(*beside, first, end);
  }
  result.size.texel_bytes = words * sizeof(std::uint64_t);
  return result;
}

}  // namespace psivox
