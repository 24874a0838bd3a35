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
    bits = (bits + CodedRows::mask + 1) & ~CodedRows::mask;
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
void encode(const Record& record, int channel, const CodedRows& rows, std::uint64_t* words,
            std::size_t stride) {
  const BrickCode code = code_of(record.min, record.max, rows.width, record.absent);
  const float* const values = record.values + channel;
  std::array<std::int32_t, brick_texels> codes;
  const auto find = [&](auto channels) {
    for (std::size_t i = 0; i < codes.size(); ++i)
      codes[i] = code.of(values[i * std::size_t(channels)]);
    if (record.absent)
      for (std::size_t i = 0; i < codes.size(); ++i)
        if (std::isnan(values[i * std::size_t(channels)]))
          codes[i] = (1 << bits_of(rows.width)) - 1;
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
        std::uint64_t{std::bit_cast<std::uint32_t>(code.step) | rows.in_step()} << 32);
  const auto pack = [&]<int wide>(std::integral_constant<int, wide>) {  // loops of known lengths
    constexpr int cells = brick_cells >> wide;
    for (int x = rows.first.x; x <= rows.first.x + rows.cells.x; ++x)
      for (int y = rows.first.y; y <= rows.first.y + rows.cells.y; ++y)
        for (int z = 0; z < brick_cells; z += cells) {
          const std::int32_t* const first =
              codes.data() + (x * brick_values + y) * brick_values + z;
          std::uint64_t word = 0;
          for (int i = cells; i >= 0; --i) word = word << word_bits[wide] | std::uint64_t(first[i]);
          write(word);
        }
  };
  if (rows.width == CodeWidth::bits7) pack(std::integral_constant<int, 0>());
  if (rows.width == CodeWidth::bits12) pack(std::integral_constant<int, 1>());
  if (rows.width == CodeWidth::bits16) pack(std::integral_constant<int, 2>());
}

/// The first visible layer of cells, from one plane of values to the next, and how many there are
/// up to the last: at least one.
glm::ivec2 visible_layers(const std::array<ValueRange, brick_values>& planes,
                          const Visibility& visible) {
  const auto hidden = [&](int layer) {
    const ValueRange a = planes[std::size_t(layer)], b = planes[std::size_t(layer) + 1];
    return !sees(visible, {std::min(a.min, b.min), std::max(a.max, b.max)});
  };
  int first = 0, last = brick_cells - 1;
  while (first < last && hidden(first)) ++first;
  while (first < last && hidden(last)) --last;
  return {first, last - first + 1};
}

/// The rows of a brick's visible cells.
CodedRows visible_rows(const float* values, CodeWidth width, const Visibility& visible) {
  constexpr std::size_t n = brick_values;
  std::array<ValueRange, brick_values> planes_x, planes_y;
  for (std::size_t i = 0; i < n; ++i) {
    LaneRange<n> of_x, of_y;
    for (std::size_t k = 0; k < n; ++k) {
      of_x.include(values + (i * n + k) * n);
      of_y.include(values + (k * n + i) * n);
    }
    planes_x[i] = {of_x.least(), of_x.greatest()};
    planes_y[i] = {of_y.least(), of_y.greatest()};
  }
  const glm::ivec2 x = visible_layers(planes_x, visible), y = visible_layers(planes_y, visible);
  return {width, {x.x, y.x}, {x.y, y.y}};
}

/// Bricks of codes, and where each begins.
struct CodeLayout {
  int unit = code_words;  ///< words of a channel that places count
  std::vector<CodedRows> bricks{};
  std::vector<std::uint32_t> places{};
  std::uint32_t end = 0;

  std::size_t words() const { return std::size_t(end) * std::size_t(unit); }  // of a channel
  void place() {
    for (const CodedRows& rows : bricks) {
      places.push_back(end);
      end += std::uint32_t(rows.units(unit));
    }
  }
};

/// Payloads of boxes count so many words.
constexpr int box_unit = 4;

CodeLayout layout_of(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths) {
  CodeLayout whole, boxes{.unit = box_unit};
  for (const CodeWidth width : widths) whole.bricks.push_back({width});
  whole.place();
  if (!atlas.visible) return whole;
  boxes.bricks.resize(widths.size());
  tbb::parallel_for(std::size_t{0}, widths.size(), [&](std::size_t slot) {
    boxes.bricks[slot] =
        visible_rows(atlas.texels.get() + slot * brick_texels, widths[slot], atlas.visible);
  });
  boxes.place();
  const bool are_worthwhile = double(boxes.words()) <= atlas.most_boxes * double(whole.words());
  return are_worthwhile && boxes.end >> entry_slot_bits == 0 ? boxes : whole;
}

void discard_texels(const BrickAtlas& atlas, std::size_t first, std::size_t end) {
  const std::size_t floats = brick_texels * std::size_t(atlas.channels);
  discard_values(atlas.texels.get() + first * floats, (end - first) * floats * sizeof(float));
}

}  // namespace

std::uint32_t CodedRows::in_step() const {
  return std::uint32_t(width) | std::uint32_t(first.x) << 2 | std::uint32_t(cells.x - 1) << 5 |
         std::uint32_t(first.y) << 8 | std::uint32_t(cells.y - 1) << 11;
}

CodedRows CodedRows::of_head(std::uint64_t head) {
  const auto at = [&](int bit) { return int(head >> (32 + bit) & 7); };
  return {CodeWidth(head >> 32 & 3), {at(2), at(8)}, {at(5) + 1, at(11) + 1}};
}

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

std::uint64_t coded_bytes(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                          const BrickAtlas* beside) {
  return layout_of(atlas, widths).words() * channels_of(beside) * sizeof(std::uint64_t);
}

BrickAtlas coded(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                 const BrickAtlas* beside, bool discards_texels) {
  if (!atlas.texels && !atlas.bricks.empty())
    throw Error(ExitCode::failure, "codes are of float32 texels");
  BrickAtlas result = atlas;
  result.texels.reset();
  const std::size_t records = channels_of(beside);
  CodeLayout layout = layout_of(atlas, widths);
  result.code_unit = layout.unit;
  result.code_places = std::move(layout.places);
  PageTable& pages = result.pages;
  pages.octants = pages.octants && layout.end >> entry_slot_bits == 0;
  for (std::uint32_t& entry : pages.entries) {
    if (entry_kind(entry) != EntryKind::brick) continue;
    const std::uint32_t hidden = pages.octants ? entry_payload(entry) >> entry_slot_bits : 0;
    entry = make_entry(EntryKind::brick,
                       result.code_places[atlas.pages.slot(entry)] | hidden << entry_slot_bits);
  }
  const std::size_t unit = std::size_t(layout.unit) * records, words = layout.words() * records;
  result.codes = page_array<std::uint64_t>(words);
  const auto store = [&](std::size_t slot) {
    const bool last = slot + 1 == result.bricks.size();
    const std::size_t end = last ? layout.end : result.code_places[slot + 1];
    const CodedRows& rows = layout.bricks[slot];
    std::uint64_t* to = result.codes.get() + result.code_places[slot] * unit;
    std::fill(to + rows.words() * records, result.codes.get() + end * unit, 0);
    for_records(atlas, beside, slot, [&](const Record& record) {
      if (!record.can_be_coded())
        throw Error(ExitCode::input, "values reach from " + std::to_string(record.min) + " to " +
                                         std::to_string(record.max) +
                                         ", beyond codes; use --texel float32");
      for (int channel = 0; channel < record.channels; ++channel)
        encode(record, channel, rows, to++, records);
    });
  };
  const std::size_t bricks = result.bricks.size();
  discards_texels =
      discards_texels && is_worth_discarding(bricks * brick_texels * records * sizeof(float));
  const std::size_t at_once = discards_texels ? 1024 : bricks;
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
