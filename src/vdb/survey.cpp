#include "survey.h"

#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "field/index_space.h"
#include "field/lane_range.h"
#include "psivox/error.h"

namespace psivox {
namespace vdb {
namespace {

constexpr float kMaxFloat = std::numeric_limits<float>::max();

/// True if a value of the 512 is not from lo to hi. It has no branch and a fixed length, so that it
/// runs at the speed of memory; almost every leaf of almost every file needs nothing more.
bool has_bad_value(const float* values, float lo, float hi = greatest_magnitude) {
  int bad = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const int good = (values[i] >= lo) & (values[i] <= hi);
    bad |= good ^ 1;
  }
  return bad != 0;
}

/// Least and greatest of finite values, whose number is a multiple of 512.
glm::vec2 bounds_of(const float* values, std::size_t count) {
  constexpr std::size_t lanes = 64;
  LaneRange<lanes> range;
  for (std::size_t i = 0; i < count; i += lanes) range.include(values + i);
  return {range.least(), range.greatest()};
}

}  // namespace

float smallest_good(GridRole role) { return role == GridRole::data ? -greatest_magnitude : 0.0f; }

void LeafSurvey::clean_one(float& value, BadValues& count) const {
  const bool filled = fill_.is_fill(value);
  if (!filled && value >= smallest_ && value <= greatest_magnitude) return;
  if (std::isnan(value)) {
    ++count.nan;
  } else if (value == -std::numeric_limits<float>::infinity()) {
    ++count.negative_infinite;
  } else if (filled) {
    ++count.filled;
    count.least_fill = std::min(count.least_fill, value);
  } else if (value > kMaxFloat) {
    ++count.positive_infinite;  // its replacement is not known yet
    return;
  } else if (value < 0 && smallest_ == 0) {
    ++count.negative;
    count.least = std::max(std::min(count.least, value), -greatest_magnitude);
    value = 0.0f;
    return;
  } else {
    ++count.clamped;
    value = std::clamp(value, -greatest_magnitude, greatest_magnitude);
    return;
  }
  value = missing_;
}

BadValues LeafSurvey::clean(float* values) const {
  BadValues count;
  for (int c = 0; c < channels_; ++c, values += kLeafVoxels) {
    if (!has_bad_value(values, smallest_) && !holds_fill(values)) continue;
    for (std::size_t i = 0; i < kLeafVoxels; ++i) clean_one(values[i], count);
  }
  return count;
}

bool LeafSurvey::may_hold_fill(const float* values) const {
  return finds_fill_ && has_bad_value(values, 0, ValueEnds::huge);
}

bool LeafSurvey::holds_fill(const float* values) const {
  if (fill_ == Fill{}) return false;
  return std::any_of(values, values + kLeafVoxels, [&](float v) { return fill_.is_fill(v); });
}

ValueEnds LeafSurvey::ends(const float* values) const {
  ValueEnds found;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) found.add(values[i]);
  return found;
}

void LeafSurvey::find_fill(ValueEnds ends, const ValueSurvey& others,
                           const std::vector<TileValue>& tiles, std::uint64_t voxels) {
  if (!finds_fill_) return;
  for (const TileValue& tile : tiles) ends.add(tile.value, tile.voxels);
  if (!(ends.least < 0) && !(ends.huge_greatest > 0)) return;
  ends.add(others.all.min);
  ends.add(others.all.max);
  fill_ = ends.fill(voxels);
}

ValueSurvey LeafSurvey::look(const float* values, const LeafMask& active, bool infinite) const {
  const auto stride = static_cast<std::size_t>(channels_);
  ValueSurvey found;
  if (infinite) {
    for (std::size_t i = 0; i < kLeafVoxels * stride; ++i)
      if (values[i] <= kMaxFloat) found.largest = std::max(found.largest, values[i]);
  } else {
    const glm::vec2 bounds = bounds_of(values, kLeafVoxels * stride);
    found.largest = std::max(found.largest, bounds.y);
    if (stride == 1) found.all = {bounds.x, bounds.y};
  }
  if (infinite || stride > 1)
    for (std::size_t i = 0; i < kLeafVoxels; ++i) found.all.add(values[i * stride]);
  if (is_data_ && active.all())
    found.active = found.all;
  else if (is_data_)
    each_on(active, [&](std::size_t i) { found.active.add(values[i * stride]); });
  return found;
}

ValueSurvey LeafSurvey::take(float* values, const LeafMask& active) const {
  const BadValues bad = clean(values);
  ValueSurvey found = look(values, active, bad.positive_infinite > 0);
  found.bad = bad;
  found.bad.fill = fill_;
  return found;
}

ValueSurvey survey_tiles(Field& field, const LeafSurvey& survey, bool keep_zeros) {
  ValueSurvey found;
  found.bad.fill = survey.fill();
  for (Tile& tile : field.tiles)
    for (int c = 0; c < field.channels; ++c) {
      survey.clean_one(tile.value[c], found.bad);
      if (std::isfinite(tile.value[c])) found.largest = std::max(found.largest, tile.value[c]);
    }
  if (!keep_zeros)
    std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  for (const Tile& tile : field.tiles) found.all.add(tile.value.x);
  return found;
}

float settle(Field& field, ValueSurvey& survey, const ReadOptions& options,
             const std::string& subject) {
  BadValues& bad = survey.bad;
  bad.largest = survey.largest > 0 ? survey.largest : 1;
  bad.absent = options.absent;
  field.absent = options.absent && bad.missing() > 0;
  if (bad.any()) {
    if (options.strict)
      throw Error(ExitCode::input, subject + "is refused by strict reading: " + bad.describe());
    field.notices.push_back("grid '" + field.name + "': " + bad.describe());
    field.replaced = bad;
  }
  for (Tile& tile : field.tiles)
    for (int c = 0; c < 3; ++c)
      if (tile.value[c] > bad.largest) tile.value[c] = bad.largest;
  survey.all.add(0);
  field.stored_range = survey.all.range(bad.largest);
  if (options.role == GridRole::data) field.active_range = survey.active.range(bad.largest);
  return bad.largest;
}

void replace_infinite(float* values, std::size_t count, float largest) {
  for (std::size_t i = 0; i < count; ++i)
    if (values[i] > largest) values[i] = largest;
}

bool all_good(std::span<const float> values, GridRole role, bool absent) {
  const float lo = smallest_good(role);
  const auto good = [&](float v) {
    return (v >= lo && v <= greatest_magnitude) || (absent && std::isnan(v));
  };
  if (absent) return std::ranges::all_of(values, good);
  while (values.size() >= kLeafVoxels) {
    if (has_bad_value(values.data(), lo)) return false;
    values = values.subspan(kLeafVoxels);
  }
  return std::ranges::all_of(values, good);
}

void Moments::add(const Moments& other) {
  if (other.voxels == 0) return;
  least = std::min(least, other.least);
  greatest = std::max(greatest, other.greatest);
  voxels += other.voxels;
  mean += (other.mean - mean) * other.voxels / voxels;
}

void Statistics::add(double value, std::uint64_t count) {
  if (std::isfinite(value))
    (std::abs(value) < double(ValueEnds::huge) ? values : huge)
        .add({value, value, value, double(count)});
  else
    not_finite += count;
}

void Statistics::add(const Statistics& other) {
  values.add(other.values);
  huge.add(other.huge);
  ends = ends + other.ends;
  not_finite += other.not_finite;
}

std::optional<ValueStatistics> Statistics::all() const {
  const Fill fill = ends.fill(std::uint64_t(values.voxels + huge.voxels));
  Moments kept = values, filled;
  (fill.is_fill(ends.huge_greatest) ? filled : kept).add(huge);
  if (fill.low == ends.least) {
    const Moments padding{ends.least, ends.least, ends.least, double(ends.count)};
    kept.mean += (kept.mean - padding.mean) * padding.voxels / (kept.voxels - padding.voxels);
    kept.voxels -= padding.voxels;
    kept.least = ends.next;
    filled.add(padding);
  }
  if (kept.voxels == 0) return std::nullopt;
  return ValueStatistics{kept.least,
                         kept.greatest,
                         kept.mean,
                         not_finite,
                         std::uint64_t(filled.voxels),
                         filled.voxels > 0 ? filled.least : 0};
}

void set_linear(const glm::dmat4& world_from_index, GridInfo& info) {
  info.world_from_index = world_from_index;
  for (int axis = 0; axis < 3; ++axis)
    info.voxel_size[axis] = glm::length(glm::dvec3(world_from_index[axis]));
  if (!info.active_box.empty())
    std::tie(info.world_min, info.world_max) = bounds_of(info.active_box, world_from_index);
}

GridContent content_of(std::uint64_t active_voxels, bool has_value) {
  return {active_voxels, has_value            ? ""
                         : active_voxels == 0 ? "has no active voxel"
                                              : "is 0 everywhere"};
}

constexpr std::int64_t max_extent = std::int64_t{1} << 30;
bool too_large(const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = box.min[axis], hi = box.max[axis];
    if (hi - lo + 1 >= max_extent || std::abs(lo) >= max_extent || std::abs(hi) >= max_extent) {
      return true;
    }
  }
  return false;
}

}  // namespace vdb

void ValueEnds::add(float value, std::uint64_t voxels) {
  if (!std::isfinite(value)) return;
  const float size = std::abs(value);
  if (size >= huge) {
    huge_least = std::min(huge_least, size);
    huge_greatest = std::max(huge_greatest, size);
    return;
  }
  greatest = std::max(greatest, value);
  magnitude = std::max(magnitude, size);
  if (value == least) {
    count += voxels;
  } else if (value < least) {
    third = next;
    next = least;
    least = value;
    count = voxels;
  } else if (value < next) {
    third = next;
    next = value;
  } else if (value > next) {
    third = std::min(third, value);
  }
}

ValueEnds ValueEnds::operator+(const ValueEnds& other) const {
  ValueEnds sum = *this;
  sum.add(other.least, other.count);
  sum.add(other.next, 0);
  sum.add(other.third, 0);
  sum.greatest = std::max(sum.greatest, other.greatest);
  sum.magnitude = std::max(sum.magnitude, other.magnitude);
  sum.huge_least = std::min(sum.huge_least, other.huge_least);
  sum.huge_greatest = std::max(sum.huge_greatest, other.huge_greatest);
  return sum;
}

Fill ValueEnds::fill(std::uint64_t voxels) const {
  // Two decades lie between the greatest values of any one quantity that was seen and what programs
  // write for none: 1e20 (climate models), 9.97e36 (netCDF), 3.4e38 (GIS).
  constexpr float apart = 1e6f, surely = 1e30f;
  // a scanner's padding: one value, in many voxels, a tenth of all others' range below them, and
  // further than the lowest of these are apart: -1 beside 0, 1 and 2 is one of them
  constexpr std::uint64_t few = 64;
  constexpr double rare = 1e-4, gap = 0.1;
  Fill fill;
  if (magnitude > 0 && huge_greatest > 0 && huge_least > apart * magnitude &&
      (huge_least == huge_greatest || huge_least >= surely)) {
    fill.low = -huge_least;
    fill.high = huge_least;
  }
  const double others = double(greatest) - double(next);
  const double step = double(std::min(third, greatest)) - double(next);
  if (least < 0 && double(count) >= std::max(double(few), rare * double(voxels)) && others > 0 &&
      double(next) - double(least) >= gap * others && double(next) - double(least) > step)
    fill.low = least;
  return fill;
}

BadValues operator+(BadValues a, const BadValues& b) {
  a.nan += b.nan;
  a.filled += b.filled;
  a.clamped += b.clamped;
  if (b.filled > 0) a.fill = b.fill;
  a.least_fill = std::min(a.least_fill, b.least_fill);
  a.positive_infinite += b.positive_infinite;
  a.negative_infinite += b.negative_infinite;
  a.negative += b.negative;
  a.least = std::min(a.least, b.least);
  return a;
}

std::string BadValues::describe() const {
  std::vector<std::string> gone, zeroed, parts;
  std::vector<std::string>& missing_ones = absent ? gone : zeroed;
  const auto several = [](std::uint64_t count) { return count == 1 ? " value" : " values"; };
  if (nan > 0) missing_ones.push_back(std::to_string(nan) + " NaN");
  if (negative_infinite > 0) missing_ones.push_back(std::to_string(negative_infinite) + " -Inf");
  if (filled > 0)
    missing_ones.push_back(std::to_string(filled) + several(filled) +
                           formatted(" of %g", double(least_fill)));
  if (negative > 0) zeroed.push_back(std::to_string(negative) + " negative");
  if (!gone.empty())
    parts.push_back(joined(gone, ", ") + (filled > 0 ? "" : several(missing())) +
                    " taken as no data" + (filled > 0 ? "; --fill-value none keeps them" : ""));
  if (!zeroed.empty())
    parts.push_back(joined(zeroed, ", ") + several((absent ? 0 : missing()) + negative) +
                    " taken as 0");
  if (positive_infinite > 0)
    parts.push_back(std::to_string(positive_infinite) +
                    formatted(" +Inf taken as %g", double(largest)));
  if (clamped > 0)
    parts.push_back(std::to_string(clamped) + several(clamped) +
                    formatted(" beyond %g taken as that", double(greatest_magnitude)));
  return joined(parts, "; ");
}

}  // namespace psivox
