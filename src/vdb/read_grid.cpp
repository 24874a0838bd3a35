#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vector_relational.hpp>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "field/value_range.h"
#include "grid_file.h"
#include "grids_module.h"
#include "psivox/error.h"

namespace psivox::vdb {
namespace {

/// The value that stands for the grid's background; unset: its own stays. Throws Error(input) if it
/// is not 0 under options.strict.
std::optional<double> other_background(const FileGrid& grid, const ReadOptions& options,
                                       const std::string& subject) {
  if (!has_background(grid.head(), grid.summary())) return {};
  if (options.strict && !options.background)
    throw Error(ExitCode::input,
                subject + "has background " + background_text(grid.summary()) +
                    ", which strict reading does not replace; --background-value 0 leaves the"
                    " outside empty");
  return options.background.value_or(0);
}

std::string background_notice(const GridSummary& summary, const ReadOptions& options) {
  return "its background " + background_text(summary) + " is taken as " +
         formatted("%g", options.background.value_or(0)) +
         (options.background ? "" : "; --background-value gives another value");
}

/// The first channel of a tile as leaves have theirs: what is no value is absent or 0. +Inf stays.
float cleaned_value(const TilePart& part, const LeafSurvey& survey) {
  float value = part.tile().value.x;
  BadValues counted;
  survey.clean_one(value, counted);
  return value;
}

/// Finds percentiles of the first channel of active voxels, which `each_leaf(take)` visits, and of
/// tiles.
template <typename EachLeaf>
void find_percentiles(Field& field, const EachLeaf& each_leaf, const std::vector<TilePart>& tiles,
                      const LeafSurvey& survey, const ReadOptions& options) {
  set_percentiles(field, options.percentiles, [&](const auto& take) {
    each_leaf([&](const float* values, const LeafMask& active) {
      each_on(active, [&](std::size_t i) { take(values[i * std::size_t(field.channels)], 1); });
    });
    for (const TilePart& part : tiles) {
      const float value = cleaned_value(part, survey);
      if (part.active)
        take(value == HUGE_VALF ? field.replaced.largest : value, tile_voxels(part.tile()));
    }
  });
}

using LeafOfFloats = std::array<float, 3 * kLeafVoxels>;

/// One reading of a grid.
class Reading {
 public:
  Reading(GridFile& file, const GridEntry& entry, const ReadOptions& options)
      : options_(options),
        subject_(subject(file.path(), entry.name)),
        read_(file.open(entry, options.active)),
        grid_(*read_),
        topology_(&grid_.topology()) {
    field_.name = entry.name + (options.active ? ":active" : "");
    field_.value_type = options.active ? "float" : value_type_of(entry.type);
    field_.channels = grid_.channels();
  }

  Field read() {
    const GridSummary& summary = grid_.summary();
    if (options_.empty && summary.active_voxels == 0) {
      field_.active_box = {glm::ivec3(0), glm::ivec3(0)};
      field_.world_from_index = grid_.head().transform.world_from_index;
      return field_;
    }
    const std::optional<double> background = other_background(grid_, options_, subject_);
    const std::string text = background ? background_notice(summary, options_) : "";
    const bool stays = stays_in_file(background);
    if (background) {
      explained([&] { grid_.set_background(*background); });
      notice(text);
    }
    const Transform& transform = grid_.head().transform;
    refuse(problem_of(transform, summary));
    refuse(problem_of_distances(grid_.head(), summary));
    set_place(transform.world_from_index, summary);
    if (stays) set_leaves();
    if (!stays || options_.survey)
      finish(stays ? survey_in_file() : needs_tree() ? take_tree() : take_leaves());
    return std::move(field_);
  }

 private:
  void notice(const std::string& text) {
    field_.notices.push_back("grid '" + field_.name + "': " + text);
  }

  /// Throws if a grid has a problem.
  void refuse(const std::string& problem) const {
    if (!problem.empty()) throw Error(ExitCode::input, subject_ + problem);
  }

  /// Does work that throws the rest of a sentence.
  template <typename Work>
  void explained(const Work& work) const {
    or_input_error(work, [&](const std::exception& e) { return subject_ + e.what(); });
  }

  void add_class_notices(bool wrong_class = false) {
    if (grid_.head().grid_class == staggered_class)
      notice(
          "its class is 'staggered', but its components are taken at voxels, not at their faces");
    if (wrong_class) notice("its class is 'level set', but its background is 0: taken as fog");
  }

  void set_place(const glm::dmat4& world_from_index, const GridSummary& summary) {
    field_.active_box = summary.active_box;
    field_.active_voxels = summary.active_voxels;
    field_.world_from_index = world_from_index;
  }

  ValueSurvey survey_leaves(const auto& each) {
    survey_.emplace(options_, field_.channels);
    std::vector<TileValue> tiles;
    for (const TilePart& part : topology_->tiles)
      tiles.push_back({part.tile().value.x, tile_voxels(part.tile())});
    return vdb::survey_leaves(
        *survey_, values_.size(), tiles, field_.active_voxels, each,
        [&](std::size_t n) { return survey_->take(values_[n], topology_->masks[n]); });
  }

  /// Whether leaves' values are more than is to be kept in memory. Throws Error(memory) if they are
  /// far more and must be converted whole.
  bool stays_in_file(const std::optional<double>& background) const {
    const std::uint64_t bytes = grid_.summary().leaves * kLeafVoxels * sizeof(float) *
                                static_cast<std::uint64_t>(grid_.channels());
    const bool too_large = options_.memory > 0 && bytes > options_.memory;
    if (grid_.summary().active_voxels == 0 || !(too_large || options_.in_file)) return false;
    std::string why = grid_.why_whole();
    if (why.empty() && is_level_set(grid_.head(), grid_.summary()))
      why = "a level set is converted whole";
    if (why.empty() && !grid_.head().transform.is_linear())
      why = "a frustum transform is resampled whole";
    if (why.empty() && background.value_or(0) != 0)
      why = "a background is replaced in the whole grid";
    if (why.empty()) return true;
    if (options_.in_file || bytes <= 2 * options_.memory) return false;
    throw Error(ExitCode::memory, subject_ + "has values of " + mebibytes(bytes) +
                                      ", more than the memory limit leaves room for, and " + why);
  }

  bool needs_tree() const {
    const GridHead& head = grid_.head();
    return is_level_set(head, grid_.summary()) || is_fog_of_wrong_class(head, grid_.summary()) ||
           !head.transform.is_linear();
  }

  /// Reads leaves and cleans them as they come.
  ValueSurvey take_leaves() {
    add_class_notices();
    const std::size_t count = topology_->leaves.size();
    const std::size_t length = kLeafVoxels * static_cast<std::size_t>(field_.channels);
    Storage& storage = field_.storage;
    storage.leaves = 2048;
    for (std::size_t n = 0; n < count;) {
      const std::size_t some = std::min(storage.leaves, count - n);
      const std::shared_ptr<float[]> values = page_array<float>(some * length);
      storage.blocks.push_back(values);
      for (std::size_t i = 0; i < some; ++i, ++n) values_.push_back(values.get() + i * length);
    }
    set_leaves();
    return survey_leaves([&](const auto& look) {
      grid_.each_leaf([&](std::size_t n, const DecodedLeaf& leaf) {
        leaf.copy_to(values_[n]);
        look(n, values_[n]);
      });
    });
  }

  /// Takes what OpenVDB makes of a level set or a frustum.
  ValueSurvey take_tree() {
    explained([&] { made_ = grids_module().convert(grid_, options_); });
    add_class_notices(made_.wrong_class);
    for (const std::string& text : made_.notices) notice(text);
    topology_ = &made_.topology;
    refuse(problem_of({.world_from_index = made_.world_from_index}, topology_->summary));
    set_place(made_.world_from_index, topology_->summary);
    field_.half_width = made_.half_width;
    field_.storage = made_.storage;
    values_ = made_.values;
    set_leaves();
    return survey_leaves([&](const auto& look) {
      tbb::parallel_for(std::size_t{0}, values_.size(),
                        [&](std::size_t n) { look(n, values_[n]); });
    });
  }

  /// Sets the leaves, whose values will be there or stay in the file.
  void set_leaves() {
    for (std::size_t n = 0; n < topology_->leaves.size(); ++n)
      field_.leaves.push_back({topology_->leaves[n], values_.empty() ? nullptr : values_[n]});
  }

  /// Sets tiles. Returns what is found in them; +Inf stays.
  ValueSurvey take_tiles(const std::vector<TilePart>& parts) {
    const Box domain = field_.domain();
    for (const TilePart& part : parts) {
      const Tile tile = part.tile();
      // A background has tiles without number outside the domain.
      const bool outside = options_.background &&
                           (glm::any(glm::greaterThan(tile.origin, domain.max)) ||
                            glm::any(glm::lessThan(tile.origin + (tile.width - 1), domain.min)));
      if (tile.value != glm::vec3(0.0f) && !outside) field_.tiles.push_back(tile);
    }
    ValueSurvey found = survey_tiles(field_, *survey_);
    for (const TilePart& part : parts)
      if (part.active) found.active.add(cleaned_value(part, *survey_));
    return found;
  }

  /// Surveys leaves and keeps no value of them.
  ValueSurvey survey_in_file() {
    add_class_notices();
    survey_.emplace(options_, field_.channels);
    SurveySum sum;
    grid_.each_leaf([&](std::size_t, const DecodedLeaf& leaf) {
      LeafOfFloats values;
      leaf.copy_to(values.data());
      sum.add(survey_->take(values.data(), leaf.active()));
    });
    return sum.total();
  }

  void finish(ValueSurvey survey) {
    survey = survey + take_tiles(topology_->tiles);
    const float largest = settle(field_, survey, options_, subject_);
    const std::size_t length = kLeafVoxels * static_cast<std::size_t>(field_.channels);
    if (survey.bad.positive_infinite > 0)
      tbb::parallel_for(std::size_t{0}, values_.size(),
                        [&](std::size_t n) { replace_infinite(values_[n], length, largest); });
    const auto each_leaf = [&](const auto& take) {
      for (std::size_t n = 0; n < values_.size(); ++n) take(values_[n], topology_->masks[n]);
      if (values_.size() == topology_->leaves.size()) return;
      std::mutex mutex;
      grid_.each_leaf([&](std::size_t, const DecodedLeaf& leaf) {
        LeafOfFloats values;
        leaf.copy_to(values.data());
        survey_->clean(values.data());
        replace_infinite(values.data(), length, largest);
        const std::lock_guard lock(mutex);
        take(values.data(), leaf.active());
      });
    };
    find_percentiles(field_, each_leaf, topology_->tiles, *survey_, options_);
  }

  const ReadOptions& options_;
  std::string subject_;
  std::unique_ptr<FileGrid> read_;
  FileGrid& grid_;
  const Topology* topology_;    ///< the grid's, or what it was converted to
  ConvertedGrid made_{};        ///< that, if it was
  std::vector<float*> values_;  ///< of each leaf; empty: they stay in the file
  Field field_;
  std::optional<LeafSurvey> survey_;  ///< with its fill values, once leaves are taken
};

}  // namespace

Field read_grid(GridFile& file, const GridEntry& entry, const ReadOptions& options) {
  return Reading(file, entry, options).read();
}

std::unique_ptr<FileGrid> open_stored(GridFile& file, const GridEntry& entry,
                                      const ReadOptions& options) {
  std::unique_ptr<FileGrid> grid = file.open(entry);
  if (const auto background = other_background(*grid, options, subject(file.path(), entry.name)))
    grid->set_background(*background);
  return grid;
}

std::vector<float> stored_leaves(FileGrid& grid, const LeavesWish& wish) {
  if (!grid.why_whole().empty()) throw std::logic_error("a grid that is read whole");
  const LeafSurvey survey(wish.options, grid.channels());
  const std::size_t floats = kLeafVoxels * std::size_t(grid.channels());
  std::vector<float> values(wish.numbers.size() * floats);
  grid.some_leaves(wish.numbers, [&](std::size_t n, const DecodedLeaf& leaf) {
    float* const to = values.data() + n * floats;
    leaf.copy_to(to);
    survey.clean(to);
    replace_infinite(to, floats, wish.largest);
  });
  return values;
}

}  // namespace psivox::vdb
