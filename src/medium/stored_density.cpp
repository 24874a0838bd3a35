#include "medium/stored_density.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/regions.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/map_field.h"

namespace psivox {
namespace {

constexpr std::size_t leaves_at_once = 4096;  // 8 MiB of scalars

/// A number that differs, in all likelihood, between files of different leaves (FNV-1a).
std::string topology_of(const Field& field) {
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&hash](int number) { hash = (hash ^ std::uint32_t(number)) * 1099511628211u; };
  for (const Leaf& leaf : field.leaves)
    for (int axis = 0; axis < 3; ++axis) add(leaf.origin[axis]);
  return std::to_string(hash) + " " + std::to_string(field.active_voxels);
}

/// Numbers of the leaves that a member of the team will draw.
std::vector<std::uint32_t> own_leaves(const Field& field, const Team& team) {
  std::vector<std::uint32_t> numbers(field.leaves.size());
  std::iota(numbers.begin(), numbers.end(), std::uint32_t{0});
  if (team.size() == 1) return numbers;
  const Regions parts = Regions::in_parts(leaf_bricks(field), std::size_t(team.size()));
  const Box part = parts.all()[std::size_t(team.rank())].bricks;
  std::erase_if(numbers,
                [&](std::uint32_t n) { return !part.contains(field.leaves[n].origin >> 3); });
  return numbers;
}

using See = std::function<void(std::span<const Leaf>)>;

/// A member's leaves of a file, once they are surveyed.
class SurveyedLeaves final : public LeafReader {
 public:
  SurveyedLeaves(const Field& field, std::vector<std::uint32_t> own)
      : file_(field.reader), own_(std::move(own)), floats_(512 * std::size_t(field.channels)) {}

  /// Surveys its own leaves, and calls `see` for them, some at a time.
  ValueSurvey survey_own(const Field& field, const See& see) const {
    ValueSurvey survey;
    std::vector<float> values(std::min(leaves_at_once, own_.size()) * floats_);
    std::vector<Leaf> leaves;
    for (std::size_t n = 0; n < own_.size(); n += leaves_at_once) {
      const auto some = std::span(own_).subspan(n, std::min(leaves_at_once, own_.size() - n));
      survey = survey + file_->read(some, values.data(), LeafRead::survey);
      leaves.clear();
      for (const std::uint32_t leaf : some)
        leaves.push_back({field.leaves[leaf].origin, values.data() + leaves.size() * floats_});
      see(leaves);
    }
    return survey;
  }

  /// What stands for +Inf from now on.
  void replace_infinite(float largest) { largest_ = largest; }

  /// Percentiles of the active values of all members' leaves.
  std::vector<double> percentiles(std::span<const double> percents, Team& team) const {
    const auto each = [&](const auto& take) {
      each_active(
          *file_, own_, int(floats_ / 512),
          [&](float value, std::uint64_t count) { take(std::min(value, largest_), count); },
          team.first());
    };
    return value_percentiles(each, percents,
                             [&](std::span<std::uint64_t> counts) { team.sum(counts); });
  }

  ValueSurvey read(std::span<const std::uint32_t> leaves, float* values,
                   LeafRead what) const override {
    const ValueSurvey found = file_->read(leaves, values, what);
    if (what == LeafRead::data)
      for (float& value : std::span(values, leaves.size() * floats_))
        value = std::min(value, largest_);
    return found;
  }
  const std::vector<TileValue>& active_tiles() const override { return file_->active_tiles(); }

  bool is_own(std::uint32_t leaf) const { return std::ranges::binary_search(own_, leaf); }

 private:
  std::shared_ptr<const LeafReader> file_;
  std::vector<std::uint32_t> own_;  ///< ascending
  std::size_t floats_;              ///< of a leaf
  float largest_ = 0;               ///< in place of +Inf
};

/// Leaves by their places. Several members may have parts of one leaf.
class SummedLeaves {
 public:
  explicit SummedLeaves(int channels) : floats_(512 * std::size_t(channels)) {}

  void reserve(std::size_t leaves) { values_.reserve(leaves * floats_); }

  void add(const glm::ivec3& origin, std::span<const float> values) {
    const auto [number, is_new] = numbers_.try_emplace(tree_order(origin), origins_.size());
    if (is_new) {
      origins_.push_back(origin);
      values_.resize(values_.size() + floats_);
    }
    float* sums = values_.data() + number->second * floats_;
    for (std::size_t i = 0; i < floats_; ++i) sums[i] += values[i];
  }
  void add(const Field& field) {
    for (const Leaf& leaf : field.leaves) add(leaf.origin, std::span(leaf.values, floats_));
  }
  /// Adds what each member has, a few leaves at a time.
  void add_all(const SummedLeaves& own, Team& team) {
    constexpr std::size_t at_once = 512;
    std::size_t most = 0;
    for (const std::size_t count : team.gather(own.origins_.size())) most = std::max(most, count);
    for (std::size_t first = 0; first < most; first += at_once) {
      const std::size_t begin = std::min(first, own.origins_.size()),
                        count = std::min(at_once, own.origins_.size() - begin);
      const auto origins = team.gather(std::span(own.origins_).subspan(begin, count));
      const auto values =
          team.gather(std::span(own.values_).subspan(begin * floats_, count * floats_));
      for (std::size_t rank = 0; rank < origins.size(); ++rank)
        for (std::size_t n = 0; n < origins[rank].size(); ++n)
          add(origins[rank][n], std::span(values[rank]).subspan(n * floats_, floats_));
    }
  }
  /// Gives the leaves to a field, with values of at most `largest`.
  void move_to(Field& field, float largest) && {
    for (float& value : values_) value = std::min(value, largest);
    const auto values = std::make_shared<const std::vector<float>>(std::move(values_));
    field.leaves.clear();
    for (const auto& [order, number] : numbers_)
      field.leaves.push_back({origins_[number], values->data() + number * floats_});
    field.storage = values;
  }

 private:
  std::size_t floats_;  ///< of a leaf
  std::map<TreeOrder, std::size_t> numbers_;
  std::vector<glm::ivec3> origins_;
  std::vector<float> values_;
};

/// The leaves of a team's members together, coarser.
class Gathering {
 public:
  Gathering(const Field& field, int level, Centering centering, CoarseValue value)
      : field_(field),
        bare_(part_of_field(field, Box{})),
        level_(level),
        centering_(centering),
        value_(value),
        own_(field.channels) {
    bare_.tiles.clear();
    bare_.active_range = bare_.stored_range = glm::vec2(0);  // known later
  }

  /// Adds leaves of this member.
  void add(std::span<const Leaf> leaves) {
    Field some = bare_;
    some.leaves.assign(leaves.begin(), leaves.end());
    own_.add(level_ ? coarse_field(some, level_, centering_, value_) : some);
  }

  /// The field of all members' leaves. `largest` stands for +Inf.
  Field joined(Team& team, float largest) {
    const Field tiles = part_of_field(field_, Box{});
    Field all = level_ ? coarse_field(tiles, level_, centering_, value_) : tiles;
    SummedLeaves leaves(field_.channels);
    if (level_ == 0) leaves.reserve(field_.leaves.size());
    leaves.add(all);
    leaves.add_all(std::exchange(own_, SummedLeaves(field_.channels)), team);
    std::move(leaves).move_to(all, largest);
    all.replaced = field_.replaced;
    all.notices = field_.notices;
    return all;
  }

 private:
  const Field& field_;
  Field bare_;  ///< without leaves and tiles
  int level_;
  Centering centering_;
  CoarseValue value_;
  SummedLeaves own_;
};

/// How often an overview is halved to have so many leaves at most.
int overview_level(const Field& field, std::size_t most) {
  std::vector<glm::ivec3> places;
  for (const Leaf& leaf : field.leaves) places.push_back(leaf.origin >> 3);
  int level = 0;
  for (; places.size() > most; ++level) {
    for (glm::ivec3& place : places) place >>= 1;
    std::ranges::sort(places, {}, [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); });
    const auto same = std::ranges::unique(places);
    places.erase(same.begin(), same.end());
  }
  return level;
}

/// Whether the values of so many leaves and their atlas may be in memory.
bool fits(std::size_t leaves, const Field& field, const SurveyOptions& options) {
  // an atlas on host and GPU has 5.7 KiB for the 2 KiB of a leaf
  const std::uint64_t leaf_bytes = 4 * 512 * sizeof(float) * std::uint64_t(field.channels);
  return options.memory == 0 || leaf_bytes * leaves <= options.memory;
}

/// Surveys a member's leaves. The field gets all members' ranges and percentiles, and `leaves` as
/// its reader. Returns what stands for +Inf.
float survey_leaves(Field& field, const std::shared_ptr<SurveyedLeaves>& leaves, const See& see,
                    Team& team, const SurveyOptions& options) {
  ValueSurvey all;
  for (const ValueSurvey& of_member : team.gather(leaves->survey_own(field, see)))
    all = all + of_member;
  const float largest = take_survey(field, all, options.reading, options.subject);
  leaves->replace_infinite(largest);
  field.reader = leaves;
  const std::vector<double>& percents = options.reading.percentiles;
  const std::vector<double> values = leaves->percentiles(percents, team);
  for (std::size_t i = 0; i < values.size(); ++i) field.active_percentiles[percents[i]] = values[i];
  return largest;
}

/// The survey of a density whose leaves several members have.
SurveyedDensity survey_together(Field field, const std::shared_ptr<SurveyedLeaves>& leaves,
                                Team& team, const SurveyOptions& options) {
  if (options.lod > 0) {  // means need what stands for +Inf
    const float largest = survey_leaves(
        field, leaves, [](std::span<const Leaf>) {}, team, options);
    Gathering coarse(field, options.lod, options.centering, CoarseValue::mean);
    visit_leaves(
        field, [&](std::span<const Leaf> some) { coarse.add(some); },
        [&](const Leaf& leaf) {
          return leaves->is_own(std::uint32_t(&leaf - field.leaves.data()));
        });
    return {.field = coarse.joined(team, largest), .is_coarse = true};
  }
  std::size_t most = options.most_leaves;
  while (most > 8 && !fits(most, field, options)) most /= 2;
  Gathering overview(field, overview_level(field, most), options.centering, CoarseValue::sample);
  const float largest = survey_leaves(
      field, leaves, [&](std::span<const Leaf> some) { overview.add(some); }, team, options);
  Field whole = overview.joined(team, largest);
  return {.field = std::move(whole), .drawn = std::move(field)};
}

}  // namespace

bool is_shared(const Parts& parts) { return parts.team->size() > 1; }

std::uint64_t own_memory(const Scene& scene, const Parts& parts) {
  // a limit is each process's
  const int sharing = scene.memory_limit ? 1 : parts.team->place().local_size;
  return grid_memory(scene) / std::uint64_t(sharing);
}

SurveyedDensity survey_density(Field field, const Parts& parts, const SurveyOptions& options) {
  Team& team = *parts.team;
  team.check_same(topology_of(field), "sees another volume");
  if (!field.reader) return {.field = std::move(field)};
  const auto leaves = std::make_shared<SurveyedLeaves>(field, own_leaves(field, team));
  if (team.size() > 1) return survey_together(std::move(field), leaves, team, options);
  const auto weights = std::make_shared<WeighedLeaves>();
  const float largest = survey_leaves(
      field, leaves, [&](std::span<const Leaf> some) { weights->add(field, some, ValueWeight()); },
      team, options);
  weights->counts.replace_infinite(double(largest));
  return {.field = std::move(field), .weights = weights};
}

}  // namespace psivox
