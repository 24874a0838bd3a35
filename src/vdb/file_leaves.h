#pragma once

#include <functional>
#include <istream>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leaf_decoder.h"
#include "psivox/active_values.h"
#include "psivox/field.h"
#include "topology.h"

namespace psivox::vdb {

/// Some leaves with their values.
struct LeafBatch {
  std::size_t first = 0, count = 0;
  std::vector<float> values;
  std::vector<LeafMask> active;
};

/// What is found in the values of some leaves, which become sanitised. `box` is that of the grid's
/// active voxels.
ValueSurvey survey_values(std::span<const LeafMask> active, float* values, int channels,
                          float smallest, const Box& box,
                          const std::function<glm::ivec3(std::size_t)>& origin_of);

/// The leaves of a grid whose values stay in the file.
class FileLeaves final : public LeafReader, public ActiveValues {
 public:
  using Visit = std::function<void(LeafBatch&)>;

  /// `smallest` is the least value that stays, `subject` begins messages.
  FileLeaves(LeafDecoder decoder, std::string subject, float smallest)
      : decoder_(std::move(decoder)), subject_(std::move(subject)), smallest_(smallest) {}

  /// Finds the leaves' places in a stream that is at the first, and visits their values on the way.
  void find(std::size_t leaves, std::istream& stream, FileBuffer& buffer, const Visit& visit);

  /// Finds their places alone, in a stream that is at the first, and can survey them from then on.
  /// Their lengths come from the grid's metadata for delayed loading; if these do not lead to
  /// `end`, from a few bytes of each leaf.
  void find(const Topology& topology, std::string_view delayed_load, std::istream& stream,
            FileBuffer& buffer, std::int64_t end);

  /// Visits all values, as the file has them.
  void visit(const Visit& visit) const;

  /// Without this, +Inf stays.
  void replace_infinite(float largest) { largest_ = largest; }

  void read(std::span<const std::uint32_t> leaves, float* values) const override;
  ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const override;

  void set_active_tiles(std::vector<TileValue> tiles) { active_tiles_ = std::move(tiles); }
  void read_active(std::span<const std::uint32_t> leaves, float* values) const override;
  const std::vector<TileValue>& active_tiles() const override { return active_tiles_; }

 private:
  std::size_t floats_per_leaf() const;
  void sanitise_all(std::size_t leaves, float* values) const;
  void for_batches(std::size_t leaves, const Visit& visit, bool in_runs,
                   const std::function<void(std::size_t end)>& prepare) const;
  void decode(std::span<const std::uint32_t> leaves, float* values, LeafMask* active) const;

  LeafDecoder decoder_;
  std::string subject_;
  float smallest_, largest_ = std::numeric_limits<float>::infinity();
  std::vector<std::int64_t> places_;  ///< and the end of the last leaf
  std::vector<glm::ivec3> origins_;   ///< if they can be surveyed
  Box active_box_;                    ///< likewise
  std::vector<TileValue> active_tiles_;
};

}  // namespace psivox::vdb
