#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "archive.h"
#include "field/value_range.h"

namespace psivox::vdb {
namespace {

constexpr std::size_t batch_leaves = 2048;     // 4 MiB of values
constexpr std::int64_t ahead_bytes = 8 << 20;  // that the system is asked to read
/// Enough for the kind of a leaf's values, their length and Blosc's header, if neither inactive
/// values nor a mask of them stand between. [bytes]
constexpr std::int64_t head_bytes = 32;

/// The leaves of a grid whose values stay in the file. Any of them are read again by their places.
class FileLeaves final : public LeafReader {
 public:
  /// `places`: where leaves begin in the file, and where the last one ends. `subject` begins
  /// messages.
  FileLeaves(LeafDecoder decoder, std::vector<std::int64_t> places, const Topology& topology,
             const LeafSurvey& survey, std::string subject)
      : decoder_(std::move(decoder)),
        survey_(survey),
        subject_(std::move(subject)),
        places_(std::move(places)),
        origins_(topology.leaves),
        floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(topology.summary.channels)) {
    for (const TilePart& part : topology.tiles)
      if (part.active) active_tiles_.push_back({part.tile().value.x, tile_voxels(part.tile())});
  }

  const std::vector<TileValue>& active_tiles() const override { return active_tiles_; }

  ValueSurvey read(std::span<const std::uint32_t> leaves, float* values,
                   LeafRead what) const override {
    const std::vector<LeafPlace> places = places_of(leaves);
    SurveySum sum;
    try {
      decoder_.decode(places, /*in_runs=*/false, [&](std::size_t n, const DecodedLeaf& leaf) {
        float* const to = values + n * floats_per_leaf_;
        leaf.copy_to(to);
        if (what == LeafRead::survey)
          sum.add(survey_.take(origins_[leaves[n]], to, leaf.active()));
        else
          survey_.clean(to);
        if (what == LeafRead::active) mark(to, leaf.active());
      });
    } catch (const std::exception& e) {
      throw Error(ExitCode::input, subject_ + "cannot be read again: " + e.what());
    }
    return sum.total();
  }

 private:
  std::vector<LeafPlace> places_of(std::span<const std::uint32_t> leaves) const {
    std::vector<LeafPlace> places;
    places.reserve(leaves.size());
    for (const std::uint32_t leaf : leaves) {
      if (leaf + std::size_t{1} >= places_.size())
        throw Error(ExitCode::input, subject_ + "has no leaf of that number");
      places.push_back({places_[leaf], places_[leaf + 1]});
    }
    return places;
  }

  /// Puts NaN into the first channel of voxels that are not active.
  void mark(float* values, const LeafMask& active) const {
    for (auto off = active.beginOff(); off; ++off)
      values[off.pos() * (floats_per_leaf_ / kLeafVoxels)] =
          std::numeric_limits<float>::quiet_NaN();
  }

  LeafDecoder decoder_;
  LeafSurvey survey_;
  std::string subject_;
  std::vector<std::int64_t> places_;
  std::vector<glm::ivec3> origins_;
  std::size_t floats_per_leaf_;
  std::vector<TileValue> active_tiles_;
};

/// A grid of an Archive, whatever its type and format: its leaves are read one batch after another.
class ArchiveGrid final : public FileGrid {
 public:
  ArchiveGrid(Archive& archive, const GridEntry& entry, std::shared_ptr<FileBlocks> file,
              bool marked)
      : FileGrid(archive, entry, marked || is_mask(entry.type)),
        archive_(&archive),
        file_(std::move(file)),
        points_(is_points(entry.type)) {
    archive.guarded(entry, [&] {
      if (archive.is_old()) {
        file_ = archive.rewritten(entry);
        rewritten_ = std::make_unique<Archive>(file_);
        archive_ = rewritten_.get();
      }
      TreeHead tree = archive_->begin_tree(rewritten_ ? archive_->entries().front() : entry);
      delayed_load_ = std::move(tree.delayed_load);
      coding_ = tree.coding;
      end_ = tree.end;
      tree_at_ = archive_->stream().tellg();
      begin(std::move(tree.head), points_);
    });
  }

  std::string why_whole() const override {
    if (is_marked()) return "active voxels are marked in the whole";
    if (points_) return "points are counted in the whole";
    return {};
  }

  std::shared_ptr<LeafReader> stored_leaves(const LeafSurvey& survey,
                                            std::string subject) override {
    return std::make_shared<FileLeaves>(decoder(), find_places(), topology_, survey,
                                        std::move(subject));
  }

 private:
  LeafDecoder decoder() const { return {file_, head_, coding_, fill_}; }

  Topology read_topology(const TopologyWish& wish) override {
    archive_->stream().seekg(tree_at_);
    Topology topology = vdb::read_topology(head_, archive_->stream(), coding_, wish);
    leaves_at_ = archive_->stream().tellg();
    return topology;
  }

  /// A leaf's place depends on the lengths of those before it. So one thread finds the places of a
  /// batch by skipping over them, and then all threads decode.
  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override {
    std::istream& stream = archive_->stream();
    stream.seekg(leaves_at_);
    if (points_) {
      const std::vector<LeafMask>& masks = topology_.masks;
      read_point_counts(masks.size(), stream, [&](std::size_t n, const PointCounts& counts) {
        take(n, MadeLeaf(masks[n], each_voxel([&](std::size_t i) { return counts[i]; })));
      });
      return;
    }
    const LeafDecoder decoder = this->decoder();
    const std::size_t count = topology_.leaves.size();
    std::int64_t end = leaves_at_;
    std::vector<LeafPlace> batch;
    std::size_t wanted = enough ? 1 : batch_leaves;
    for (std::size_t first = 0; first < count; first += batch.size()) {
      file_->announce(end, ahead_bytes);
      batch.clear();
      while (batch.size() < std::min(wanted, count - first)) {
        decoder.skip(stream);
        batch.push_back({end, stream.tellg()});
        end = batch.back().end;
      }
      archive_->buffer().read_to(end);
      decoder.decode(batch, /*in_runs=*/true,
                     [&](std::size_t n, const DecodedLeaf& leaf) { take(first + n, leaf); });
      if (enough && enough()) return;
      wanted = std::min(2 * wanted, batch_leaves);
    }
  }

  /// Where leaves begin, and where the last one ends: by the metadata for delayed loading or, if
  /// these do not lead to the grid's end, by a few bytes of each leaf.
  std::vector<std::int64_t> find_places() {
    std::vector<std::int64_t> places;
    guarded([&] {
      const LeafDecoder decoder = this->decoder();
      std::istream& stream = archive_->stream();
      stream.seekg(leaves_at_);
      places = decoder.lengths(delayed_load_, topology_);
      places.insert(places.begin(), leaves_at_);
      std::partial_sum(places.begin(), places.end(), places.begin());
      const std::size_t leaves = topology_.leaves.size();
      if (places.size() > leaves && places.back() == end_) return;
      places.assign(1, leaves_at_);
      // small leaves are read in fewer calls than skipped
      if (end_ - leaves_at_ > 4 * head_bytes * std::int64_t(leaves))
        archive_->buffer().read_only(head_bytes);
      for (const std::uint16_t active : topology_.active) {
        decoder.skip(stream, active);
        places.push_back(stream.tellg());
      }
      archive_->buffer().read_only(0);
    });
    return places;
  }

  std::unique_ptr<Archive> rewritten_;  ///< of a grid in an old format
  Archive* archive_;
  std::shared_ptr<FileBlocks> file_;
  bool points_;
  ValueCoding coding_;
  std::string delayed_load_;
  std::int64_t tree_at_ = 0, leaves_at_ = 0, end_ = 0;  ///< in the file [bytes]
};

}  // namespace

std::unique_ptr<FileGrid> open_archive_grid(Archive& archive, const GridEntry& entry,
                                            std::shared_ptr<FileBlocks> file, bool marked) {
  return std::make_unique<ArchiveGrid>(archive, entry, std::move(file), marked);
}

}  // namespace psivox::vdb
