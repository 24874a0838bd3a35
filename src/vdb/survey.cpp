#include "survey.h"

#include <algorithm>
#include <cstdlib>
#include <glm/common.hpp>

#include "base/text.h"
#include "field/lane_range.h"
#include "field/leaf_values.h"
#include "psivox/error.h"

namespace psivox {
namespace vdb {
namespace {

constexpr float kMaxFloat = std::numeric_limits<float>::max();

/// True if a value of the 512 is NaN, infinite or below lo. It has no branch and a fixed length, so
/// that it runs at the speed of memory; almost every leaf of almost every file needs nothing more.
bool has_bad_value(const float* values, float lo) {
  int bad = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const int good = (values[i] >= lo) & (values[i] <= kMaxFloat);
    bad |= good ^ 1;
  }
  return bad != 0;
}

/// Counts one bad value and replaces it, except +Inf, whose replacement is not known yet.
void sanitise_value(float& value, float lo, BadValues& count) {
  if (value >= lo && value <= kMaxFloat) return;
  if (std::isnan(value)) {
    ++count.nan;
  } else if (value > 0.0f) {
    ++count.positive_infinite;
    return;
  } else if (std::isinf(value)) {
    ++count.negative_infinite;
  } else {
    ++count.negative;
    count.least = std::min(count.least, value);
  }
  value = 0.0f;
}

/// Least and greatest of finite values, whose number is a multiple of 512.
glm::vec2 bounds_of(const float* values, std::size_t count) {
  constexpr std::size_t lanes = 64;
  LaneRange<lanes> range;
  for (std::size_t i = 0; i < count; i += lanes) range.include(values + i);
  return {range.least(), range.greatest()};
}

}  // namespace

float smallest_good(GridRole role) { return role == GridRole::data ? -kMaxFloat : 0.0f; }

BadValues LeafSurvey::clean(float* values) const {
  BadValues count;
  for (int c = 0; c < channels_; ++c, values += kLeafVoxels) {
    if (!has_bad_value(values, smallest_)) continue;
    for (std::size_t i = 0; i < kLeafVoxels; ++i) sanitise_value(values[i], smallest_, count);
  }
  return count;
}

ValueSurvey LeafSurvey::extents(const glm::ivec3& origin, const float* values,
                                const LeafMask& active, bool infinite) const {
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
  if (!ranges_) return found;
  if (infinite || stride > 1)
    for (std::size_t i = 0; i < kLeafVoxels; ++i) found.all.add(values[i * stride]);
  if (active.isOn())
    found.active = found.all;
  else
    each_on(active, [&](std::size_t i) { found.active.add(values[i * stride]); });
  if (box_.contains(origin) && box_.contains(origin + 7))
    found.in_box = found.all;
  else
    for (int n = 0; n < int(kLeafVoxels); ++n)
      if (box_.contains(origin + leaf_voxel(n))) found.in_box.add(values[std::size_t(n) * stride]);
  return found;
}

ValueSurvey LeafSurvey::take(const glm::ivec3& origin, float* values,
                             const LeafMask& active) const {
  const BadValues bad = clean(values);
  ValueSurvey found = extents(origin, values, active, bad.positive_infinite > 0);
  found.bad = bad;
  return found;
}

ValueSurvey LeafSurvey::look(const glm::ivec3& origin, const float* values,
                             const LeafMask& active) const {
  return extents(origin, values, active, false);
}

ValueSurvey survey_tiles(Field& field, GridRole role, bool keep_zeros) {
  ValueSurvey found;
  for (Tile& tile : field.tiles)
    for (int c = 0; c < field.channels; ++c) {
      if (std::isfinite(tile.value[c])) found.largest = std::max(found.largest, tile.value[c]);
      sanitise_value(tile.value[c], smallest_good(role), found.bad);
    }
  if (!keep_zeros)
    std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  for (const Tile& tile : field.tiles) {
    found.all.add(tile.value.x);
    found.in_box.add(tile.value.x);
  }
  return found;
}

float settle(Field& field, ValueSurvey& survey, const ReadOptions& options,
             const std::string& subject) {
  BadValues& bad = survey.bad;
  bad.largest = survey.largest > 0 ? survey.largest : 1;
  if (bad.any()) {
    if (options.strict)
      throw Error(ExitCode::input, subject + "is refused by strict reading: " + bad.describe());
    field.notices.push_back("grid '" + field.name + "': " + bad.describe());
    field.replaced = bad;
  }
  for (Tile& tile : field.tiles) tile.value = glm::min(tile.value, glm::vec3(bad.largest));
  return bad.largest;
}

void replace_infinite(float* values, std::size_t count, float largest) {
  for (std::size_t i = 0; i < count; ++i) values[i] = std::min(values[i], largest);
}

bool all_good(std::span<const float> values, GridRole role, bool infinite) {
  const float lo = smallest_good(role);
  if (infinite) return std::ranges::all_of(values, [&](float v) { return v >= lo; });
  while (values.size() >= kLeafVoxels) {
    if (has_bad_value(values.data(), lo)) return false;
    values = values.subspan(kLeafVoxels);
  }
  return std::ranges::all_of(values, [&](float v) { return v >= lo && v <= kMaxFloat; });
}

void Statistics::add(double value, std::uint64_t count) {
  if (!std::isfinite(value)) {
    not_finite += count;
    return;
  }
  least = std::min(least, value);
  greatest = std::max(greatest, value);
  voxels += static_cast<double>(count);
  mean += (value - mean) * static_cast<double>(count) / voxels;
}

void Statistics::add(const Statistics& other) {
  not_finite += other.not_finite;
  if (other.voxels == 0) return;
  least = std::min(least, other.least);
  greatest = std::max(greatest, other.greatest);
  voxels += other.voxels;
  mean += (other.mean - mean) * other.voxels / voxels;
}

std::optional<ValueStatistics> Statistics::all() const {
  if (voxels == 0) return std::nullopt;
  return ValueStatistics{least, greatest, mean, not_finite};
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

BadValues operator+(BadValues a, const BadValues& b) {
  a.nan += b.nan;
  a.positive_infinite += b.positive_infinite;
  a.negative_infinite += b.negative_infinite;
  a.negative += b.negative;
  a.least = std::min(a.least, b.least);
  return a;
}

std::string BadValues::describe() const {
  std::vector<std::string> zeroed;
  if (nan > 0) zeroed.push_back(std::to_string(nan) + " NaN");
  if (negative_infinite > 0) zeroed.push_back(std::to_string(negative_infinite) + " -Inf");
  if (negative > 0) zeroed.push_back(std::to_string(negative) + " negative");
  std::string text = joined(zeroed, ", ");
  const bool one = nan + negative_infinite + negative == 1;
  if (!zeroed.empty()) text += std::string(one ? " value" : " values") + " taken as 0";
  if (positive_infinite > 0)
    text += (zeroed.empty() ? "" : "; ") + std::to_string(positive_infinite) +
            formatted(" +Inf taken as %g", double(largest));
  return text;
}

float take_survey(Field& field, const ValueSurvey& of_leaves, const ReadOptions& options,
                  const std::string& subject) {
  ValueSurvey all = of_leaves + *field.survey;
  const float largest = vdb::settle(field, all, options, subject);
  all.all.add(0);
  field.stored_range = all.all.range(largest);
  field.active_range = (options.role == GridRole::data ? all.active : all.in_box).range(largest);
  field.survey.reset();
  return largest;
}

}  // namespace psivox
