#include "scene/rank_leaves.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <mutex>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "psivox/atlas.h"
#include "psivox/leaf_values.h"
#include "psivox/regions.h"
#include "psivox/value_percentile.h"

namespace psivox {
namespace {

/// A number that differs, in all likelihood, between files of different leaves (FNV-1a).
std::string topology_of(const Field& field) {
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&hash](int number) {
    hash = (hash ^ static_cast<std::uint32_t>(number)) * 1099511628211u;
  };
  for (const Leaf& leaf : field.leaves)
    for (int axis = 0; axis < 3; ++axis) add(leaf.origin[axis]);
  return std::to_string(hash) + " " + std::to_string(field.active_voxels);
}

std::vector<std::uint32_t> leaves_in(const Box& bricks, const Field& field) {
  std::vector<std::uint32_t> numbers;
  for (std::size_t n = 0; n < field.leaves.size(); ++n) {
    const glm::ivec3 brick = field.leaves[n].origin >> 3;
    if (glm::clamp(brick, bricks.min, bricks.max) == brick) numbers.push_back(std::uint32_t(n));
  }
  return numbers;
}

std::vector<std::uint32_t> all_leaves(const Field& field) {
  std::vector<std::uint32_t> numbers(field.leaves.size());
  std::iota(numbers.begin(), numbers.end(), std::uint32_t{0});
  return numbers;
}

/// The leaves of one rank, or of a process that is alone.
class RankLeaves final : public LeafReader {
 public:
  /// `part`: the box of bricks that this rank's leaves are in.
  RankLeaves(const Field& field, std::shared_ptr<Ranks> ranks, const Box& part)
      : file_(field.reader),
        ranks_(std::move(ranks)),
        part_(part),
        own_(leaves_in(part, field)),
        floats_per_leaf_(512 * std::size_t(field.channels)) {}

  /// Of a process that is alone.
  explicit RankLeaves(const Field& field)
      : file_(field.reader),
        own_(all_leaves(field)),
        floats_per_leaf_(512 * std::size_t(field.channels)) {}

  /// Surveys and weighs its own leaves, and keeps their values if they are to stay.
  ValueSurvey survey_own(const Field& field, bool keep) {
    std::vector<float> values((keep ? own_.size() : std::min(leaves_at_once, own_.size())) *
                              floats_per_leaf_);
    const auto weighed = std::make_shared<WeighedLeaves>();
    weighed->leaves.reserve(own_.size());
    ValueSurvey survey;
    std::vector<Leaf> leaves;
    for (std::size_t n = 0; n < own_.size(); n += leaves_at_once) {
      const auto some = std::span(own_).subspan(n, std::min(leaves_at_once, own_.size() - n));
      float* to = values.data() + (keep ? n * floats_per_leaf_ : 0);
      survey = survey + file_->survey(some, to);
      leaves.clear();
      for (const std::uint32_t leaf : some) {
        leaves.push_back({field.leaves[leaf].origin, to});
        to += floats_per_leaf_;
      }
      weighed->add(field, leaves, ValueWeight());
    }
    if (keep) kept_ = std::move(values);
    weighed_ = weighed;
    return survey;
  }

  /// Null once a part has been read.
  std::shared_ptr<const WeighedLeaves> weighed() const {
    const std::lock_guard lock(mutex_);
    return weighed_;
  }

  /// Percentiles of the active values of all ranks.
  std::vector<double> percentiles(std::span<const double> percents) const {
    std::vector<float> values(std::min(leaves_at_once, own_.size()) * floats_per_leaf_);
    const auto each = [&](const auto& take) {
      for (std::size_t n = 0; n < own_.size(); n += leaves_at_once) {
        const auto some = std::span(own_).subspan(n, std::min(leaves_at_once, own_.size() - n));
        file_->read_active(some, values.data());
        for (std::size_t i = 0; i < 512 * some.size(); ++i)
          if (const float value = values[i * floats_per_leaf_ / 512]; !std::isnan(value))
            take(std::min(value, largest_), 1);
      }
      if (ranks_ && !ranks_->first()) return;
      for (const TileValue& tile : file_->active_tiles())
        take(std::min(tile.value, largest_), tile.voxels);
    };
    return value_percentiles(each, percents, [&](std::span<std::uint64_t> counts) { sum(counts); });
  }

  /// What stands for +Inf from now on.
  void replace_infinite(float largest) {
    largest_ = largest;
    replace_infinite(kept_);
    weighed_->counts.replace_infinite(double(largest));
  }

  void read(std::span<const std::uint32_t> leaves, float* values) const override {
    const std::lock_guard lock(mutex_);
    for (std::size_t n = 0; n < leaves.size();) {
      if (const float* kept = kept_values(leaves[n])) {
        std::memcpy(values + n * floats_per_leaf_, kept, floats_per_leaf_ * sizeof(float));
        ++n;
        continue;
      }
      std::size_t end = n + 1;
      while (end < leaves.size() && !kept_values(leaves[end])) ++end;
      const std::span<float> from_file(values + n * floats_per_leaf_, (end - n) * floats_per_leaf_);
      file_->read(leaves.subspan(n, end - n), from_file.data());
      replace_infinite(from_file);
      n = end;
    }
  }
  ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const override {
    return file_->survey(leaves, values);
  }
  void read_active(std::span<const std::uint32_t> leaves, float* values) const override {
    file_->read_active(leaves, values);
  }
  const std::vector<TileValue>& active_tiles() const override { return file_->active_tiles(); }

  const Box& part() const { return part_; }
  std::span<const std::uint32_t> own() const { return own_; }
  bool is_shared() const { return ranks_ != nullptr; }
  bool is_own(std::uint32_t leaf) const override {
    return !is_shared() || std::ranges::binary_search(own_, leaf);
  }
  std::vector<std::string> gather(const std::string& bytes) const override {
    return ranks_ ? ranks_->gather(bytes) : std::vector{bytes};
  }
  void forget() const override {
    const std::lock_guard lock(mutex_);
    kept_ = std::vector<float>();  // {} would keep the memory
    weighed_.reset();
  }

 private:
  static constexpr std::size_t leaves_at_once = 4096;  // 8 MiB of scalars

  void sum(std::span<std::uint64_t> counts) const {
    const std::string own(reinterpret_cast<const char*>(counts.data()), counts.size_bytes());
    std::ranges::fill(counts, std::uint64_t{0});
    for (const std::string& found : gather(own))
      for (std::size_t i = 0; i < counts.size(); ++i) {
        std::uint64_t count;
        std::memcpy(&count, found.data() + i * sizeof count, sizeof count);
        counts[i] += count;
      }
  }

  void replace_infinite(std::span<float> values) const {
    for (float& value : values) value = std::min(value, largest_);
  }

  /// Null if they are not kept.
  const float* kept_values(std::uint32_t leaf) const {
    if (kept_.empty()) return nullptr;
    const auto place = std::ranges::lower_bound(own_, leaf);
    if (place == own_.end() || *place != leaf) return nullptr;
    return kept_.data() + std::size_t(place - own_.begin()) * floats_per_leaf_;
  }

  std::shared_ptr<const LeafReader> file_;
  std::shared_ptr<Ranks> ranks_;
  Box part_;                        ///< [bricks], if it is shared
  std::vector<std::uint32_t> own_;  ///< ascending
  std::size_t floats_per_leaf_;
  float largest_ = 0;  ///< in place of +Inf
  mutable std::mutex mutex_;
  mutable std::vector<float> kept_;  ///< values of its own leaves, or nothing
  mutable std::shared_ptr<WeighedLeaves> weighed_;
};

}  // namespace

void survey_leaves(Field& field, const std::shared_ptr<Ranks>& ranks, const ReadOptions& options,
                   std::uint64_t memory, const std::string& subject) {
  if (ranks) ranks->check_same(topology_of(field), "sees another volume");
  if (!field.reader) return;
  std::shared_ptr<RankLeaves> leaves;
  bool keep = false;
  if (ranks) {
    const Regions parts = Regions::in_parts(leaf_bricks(field), std::size_t(ranks->count()));
    leaves =
        std::make_shared<RankLeaves>(field, ranks, parts.all()[std::size_t(ranks->rank())].bricks);
    // an atlas on host and GPU has 5.7 KiB for the 2 KiB of a leaf
    keep = memory == 0 ||
           4 * leaves->own().size() * 512 * sizeof(float) * std::uint64_t(field.channels) <= memory;
  } else {
    leaves = std::make_shared<RankLeaves>(field);
  }
  const ValueSurvey found = leaves->survey_own(field, keep);
  ValueSurvey all;
  for (const std::string& bytes :
       leaves->gather(std::string(reinterpret_cast<const char*>(&found), sizeof found))) {
    ValueSurvey of_rank;
    std::memcpy(&of_rank, bytes.data(), std::min(bytes.size(), sizeof of_rank));
    all = all + of_rank;
  }
  leaves->replace_infinite(take_survey(field, all, options, subject));
  field.reader = leaves;
  const std::vector<double> values = leaves->percentiles(options.percentiles);
  for (std::size_t i = 0; i < values.size(); ++i)
    field.active_percentiles[options.percentiles[i]] = values[i];
}

bool is_shared(const Field& field) {
  const auto* leaves = dynamic_cast<const RankLeaves*>(field.reader.get());
  return leaves && leaves->is_shared();
}

std::shared_ptr<const WeighedLeaves> weighed_leaves(const Field& field) {
  const auto* leaves = dynamic_cast<const RankLeaves*>(field.reader.get());
  return leaves ? leaves->weighed() : nullptr;
}

OwnPart own_part(const std::shared_ptr<const Field>& field) {
  constexpr glm::ivec3 most(1 << 30);  // the outermost parts reach farther than there are voxels
  const auto* leaves = dynamic_cast<const RankLeaves*>(field->reader.get());
  if (!leaves || !leaves->is_shared()) return {field, {-most, most}};
  Field own = *field;
  own.reader = nullptr;
  own.leaves.clear();
  const Box& part = leaves->part();
  const std::vector<std::uint32_t> numbers =
      leaves_in({part.min, glm::min(part.max, most) + 1}, *field);
  const std::size_t floats = 512 * std::size_t(field->channels);
  const auto values = std::make_shared_for_overwrite<float[]>(numbers.size() * floats);
  leaves->read(numbers, values.get());
  for (const std::uint32_t n : numbers)
    own.leaves.push_back({field->leaves[n].origin, values.get() + own.leaves.size() * floats});
  own.storage = values;
  return {std::make_shared<const Field>(std::move(own)),
          {8 * glm::max(part.min, -most / 8), 8 * glm::min(part.max, most / 8 - 1) + 7}};
}

}  // namespace psivox
