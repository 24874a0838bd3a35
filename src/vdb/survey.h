#pragma once

#include <openvdb/util/NodeMasks.h>
#include <tbb/combinable.h>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "psivox/field.h"
#include "psivox/vdb.h"

// One survey judges the values of every grid: from a file, in memory, or left in the file.

namespace psivox::vdb {

inline constexpr std::size_t kLeafVoxels = 512;

/// The active voxels of a leaf.
using LeafMask = openvdb::util::NodeMask<3>;

/// Smallest value that stays.
float smallest_good(GridRole role);

/// Whether a survey would leave the values as they are; `infinite`: +Inf counts as good.
bool all_good(std::span<const float> values, GridRole role, bool infinite = false);

/// Judges leaves of 512 * channels values. Several threads may use it.
class LeafSurvey {
 public:
  /// Extents are found if `ranges` is set. `box` is that of the grid's active voxels.
  LeafSurvey(GridRole role, int channels, bool ranges, const Box& box = {})
      : smallest_(smallest_good(role)), channels_(channels), ranges_(ranges), box_(box) {}

  /// Surveys a leaf. NaN, -Inf and values below the smallest good one become 0; +Inf is counted and
  /// stays.
  ValueSurvey take(const glm::ivec3& origin, float* values, const LeafMask& active) const;

  /// Surveys a leaf whose values are all good.
  ValueSurvey look(const glm::ivec3& origin, const float* values, const LeafMask& active) const;

  /// Replaces values as `take` does.
  BadValues clean(float* values) const;

 private:
  ValueSurvey extents(const glm::ivec3& origin, const float* values, const LeafMask& active,
                      bool infinite) const;

  float smallest_;
  int channels_;
  bool ranges_;
  Box box_;
};

/// The sum of what several threads find.
class SurveySum {
 public:
  void add(const ValueSurvey& found) { found_.local() = found_.local() + found; }
  ValueSurvey total() { return found_.combine(std::plus<>()); }

 private:
  tbb::combinable<ValueSurvey> found_;
};

/// Surveys a field's tiles, as `take` does a leaf, but for active voxels. Tiles of 0 go, unless
/// `keep_zeros`.
ValueSurvey survey_tiles(Field& field, GridRole role, bool keep_zeros = false);

/// Ends a field's survey: bad values are a notice, or an error under ReadOptions::strict, and tiles
/// get what stands for +Inf, which it returns. `subject` begins messages.
float settle(Field& field, ValueSurvey& survey, const ReadOptions& options,
             const std::string& subject);

/// Gives +Inf among so many values another value.
void replace_infinite(float* values, std::size_t count, float largest);

}  // namespace psivox::vdb
