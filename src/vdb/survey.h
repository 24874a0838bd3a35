#pragma once

#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/field.h"
#include "psivox/vdb.h"

// One survey judges the values of every grid.

namespace psivox::vdb {

inline constexpr std::size_t kLeafVoxels = 512;

/// Active voxels of one value, outside leaves.
struct TileValue {
  float value = 0;
  std::uint64_t voxels = 0;
};

/// Least and greatest of some values; +Inf, whose replacement is found last, is only noted.
struct Extent {
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();
  bool infinite = false;

  void add(float value) {
    if (std::isinf(value)) {
      infinite = true;
      return;
    }
    min = std::min(min, value);
    max = std::max(max, value);
  }
  glm::vec2 range(float largest) const {
    if (!infinite) return {min, max};
    return {std::min(min, largest), std::max(max, largest)};
  }
  Extent operator+(const Extent& other) const {
    return {std::min(min, other.min), std::max(max, other.max), infinite || other.infinite};
  }
};

/// What one pass over values of a grid finds out. Those of its parts add up.
struct ValueSurvey {
  BadValues bad;
  float largest = 0;  ///< finite value of any channel
  Extent all;         ///< first channel
  Extent active;      ///< of active voxels; for GridRole::data

  ValueSurvey operator+(const ValueSurvey& other) const {
    return {bad + other.bad, std::max(largest, other.largest), all + other.all,
            active + other.active};
  }
};

/// The active voxels of a leaf: a bit for each voxel, in OpenVDB's order.
struct LeafMask {
  std::array<std::uint64_t, 8> words{};  ///< a layer of x each, whose bits are 8 y + z

  bool is_on(std::size_t i) const { return words[i / 64] >> i % 64 & 1; }
  void set_on(std::size_t i) { words[i / 64] |= std::uint64_t{1} << i % 64; }
  bool none() const {
    return std::ranges::all_of(words, [](std::uint64_t word) { return word == 0; });
  }
  bool all() const {
    return std::ranges::all_of(words, [](std::uint64_t word) { return ~word == 0; });
  }
  int count() const {
    int sum = 0;
    for (const std::uint64_t word : words) sum += std::popcount(word);
    return sum;
  }
};

/// Calls visit(i) for the active voxels of a leaf, in ascending order.
template <typename Visit>
void each_on(const LeafMask& active, const Visit& visit) {
  for (std::size_t w = 0; w < active.words.size(); ++w)
    for (std::uint64_t word = active.words[w]; word != 0; word &= word - 1)
      visit(64 * w + std::size_t(std::countr_zero(word)));
}

/// Smallest value that stays.
float smallest_good(GridRole role);

/// Whether a survey would leave the values as they are; `absent`: NaN counts as good.
bool all_good(std::span<const float> values, GridRole role, bool absent = false);

/// Judges leaves of 512 * channels values. Several threads may use it.
class LeafSurvey {
 public:
  LeafSurvey(const ReadOptions& options, int channels)
      : smallest_(smallest_good(options.role)),
        channels_(channels),
        is_data_(options.role == GridRole::data),
        finds_fill_(options.absent && options.fill && channels == 1),
        missing_(options.absent ? std::numeric_limits<float>::quiet_NaN() : 0.0f) {
    if (options.absent) fill_.given = options.fill_value;
  }

  /// Whether a leaf may have fill values, which cannot be known before all such leaves' ends are.
  bool may_hold_fill(const float* values) const;
  ValueEnds ends(const float* values) const;
  const Fill& fill() const { return fill_; }
  /// Whether a leaf has them.
  bool holds_fill(const float* values) const;

  /// Surveys a leaf. What is no data becomes absent, or 0, and values below the smallest good one
  /// become 0; +Inf is counted and stays.
  ValueSurvey take(float* values, const LeafMask& active) const;

  /// Surveys a leaf whose values are all good, but for +Inf if there are `infinite` ones.
  ValueSurvey look(const float* values, const LeafMask& active, bool infinite = false) const;

  /// Replaces values as `take` does.
  BadValues clean(float* values) const;
  void clean_one(float& value, BadValues& count) const;

  /// Ends the search for fill values: they follow from the ends of leaves that may hold some, from
  /// what was found in the others, and from tiles.
  void find_fill(ValueEnds ends, const ValueSurvey& others, const std::vector<TileValue>& tiles,
                 std::uint64_t voxels);

 private:
  float smallest_;
  int channels_;
  bool is_data_;
  bool finds_fill_;
  float missing_;  ///< what absent values become
  Fill fill_{};
};

/// The sum of what several threads find.
template <typename Found>
class SumOf {
 public:
  void add(const Found& found) { found_.local() = found_.local() + found; }
  Found total() { return found_.combine(std::plus<>()); }

 private:
  tbb::combinable<Found> found_;
};
using SurveySum = SumOf<ValueSurvey>;

/// Surveys so many leaves of a grid of `voxels` active ones. each(look) calls look(n, values) for
/// each leaf, take(n) surveys one; where fill values may be, after all have been looked at.
ValueSurvey survey_leaves(LeafSurvey& survey, std::size_t leaves,
                          const std::vector<TileValue>& tiles, std::uint64_t voxels,
                          const auto& each, const auto& take) {
  std::vector<char> open(leaves);
  SurveySum sum;
  SumOf<ValueEnds> ends;
  each([&](std::size_t n, const float* values) {
    open[n] = survey.may_hold_fill(values);
    if (open[n])
      ends.add(survey.ends(values));
    else
      sum.add(take(n));
  });
  survey.find_fill(ends.total(), sum.total(), tiles, voxels);
  tbb::parallel_for(std::size_t{0}, leaves, [&](std::size_t n) {
    if (open[n]) sum.add(take(n));
  });
  return sum.total();
}

/// Surveys a field's tiles, as `take` does a leaf, but for active voxels. Tiles of 0 go, unless
/// `keep_zeros`.
ValueSurvey survey_tiles(Field& field, const LeafSurvey& survey, bool keep_zeros = false);

/// Ends a field's survey: bad values are a notice, or an error under ReadOptions::strict, tiles get
/// what stands for +Inf, which it returns, and the field its ranges. `subject` begins messages.
float settle(Field& field, ValueSurvey& survey, const ReadOptions& options,
             const std::string& subject);

/// Gives +Inf among so many values another value.
void replace_infinite(float* values, std::size_t count, float largest);

// What `psivox info` says of a grid, whatever it is read from.

/// Ends and mean of values.
struct Moments {
  double least = std::numeric_limits<double>::infinity(), greatest = -least, mean = 0, voxels = 0;
  void add(const Moments& other);
};

/// Statistics of active values that add up; of lengths, if there are vectors.
struct Statistics {
  Moments values, huge;  ///< huge: from ValueEnds::huge on, which may be fill values
  ValueEnds ends;        ///< of scalars
  std::uint64_t not_finite = 0;

  void add(double value, std::uint64_t count);
  void add(const Statistics& other);
  /// A value of so many voxels. `Number` is float or double.
  template <typename Number>
  void add(const Number* value, int channels, std::uint64_t count) {
    add(channels == 1 ? double(*value)
                      : std::hypot(double(value[0]), double(value[1]), double(value[2])),
        count);
    if (channels == 1) ends.add(float(*value), count);
  }
  /// The active values of a leaf.
  template <typename Number>
  void add(const Number* first, int channels, const LeafMask& active) {
    each_on(active, [&](std::size_t i) {
      add(first + i * std::size_t(channels), channels, std::uint64_t{1});
    });
  }
  std::optional<ValueStatistics> all() const;  ///< unset: no value was finite
};

/// Sets the place of a grid whose active box is set.
void set_linear(const glm::dmat4& world_from_index, GridInfo& info);

/// What a picture could be made of a grid with so many active voxels, some of which are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

/// Whether coordinates would overflow: the box is 2^30 voxels wide or that far from the origin.
bool too_large(const Box& box);

}  // namespace psivox::vdb
