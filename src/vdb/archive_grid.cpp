#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "archive.h"
#include "field/value_range.h"
#include "values.h"

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

namespace {

/// How the values of an attribute of one leaf are stored.
struct Attribute {
  bool uniform, paged;
  std::int64_t bytes;
};

/// The leaves of PointDataLeafNode::writeBuffers. A pass goes over all leaves: the sizes of their
/// offsets, the descriptions of their attributes, for each attribute the lengths of the pages that
/// several leaves share, the offsets, and for each attribute its values.
class PointReader {
 public:
  PointReader(std::size_t leaves, std::istream& stream) : leaves_(leaves), stream_(stream) {}

  std::int64_t read(const TakeCounts& take_counts) {
    constexpr int passes_beside = 4;  // two for each attribute, and these
    const int passes = take<std::uint16_t>(stream_);
    if (leaves_ == 0) return 0;
    if (passes < passes_beside) throw std::runtime_error("its points have too few parts");
    skip(leaves_ * sizeof(std::uint16_t));
    read_descriptions();
    for (int n = 0; n < (passes - passes_beside) / 2; ++n) read_pages(std::size_t(n));
    for (std::size_t n = 0; n < leaves_; ++n) take_counts(n, read_counts());
    return rest_;
  }

 private:
  /// Never back, so that reading ends.
  void skip(std::uint64_t bytes) {
    if (bytes > std::uint64_t(std::numeric_limits<std::int64_t>::max()))
      throw std::runtime_error("a length in its points is impossible");
    stream_.seekg(std::int64_t(bytes), std::ios_base::cur);
  }

  void read_descriptions() {
    constexpr std::uint8_t of_all = 1, more = 2;
    bool shared = false;
    std::uint64_t count = 0;
    for (std::size_t n = 0; n < leaves_; ++n) {
      if (!shared) {
        const auto header = take<std::uint8_t>(stream_);
        count = read_descriptor();
        shared = header & of_all;
        if (header & more) skip(take<std::uint64_t>(stream_));
        if (header > (of_all | more)) throw std::runtime_error("its points have an unknown format");
      }
      for (std::uint64_t i = 0; i < count; ++i) attributes_.push_back(read_attribute());
      ends_.push_back(attributes_.size());
    }
  }

  /// Returns the number of attributes. It is one leaf's, or that of all from there on.
  std::uint64_t read_descriptor() {
    const auto count = take<std::uint64_t>(stream_);
    for (std::uint64_t n = 0; n < count; ++n)
      for (int part = 0; part < 2; ++part) skip_string(stream_);  // type and codec
    skip_names(count);
    skip_names(take<std::uint64_t>(stream_));  // of groups of points
    read_metadata(stream_);                    // defaults
    return count;
  }

  /// Each with its number.
  void skip_names(std::uint64_t count) {
    for (; count > 0; --count) {
      skip_string(stream_);
      skip(sizeof(std::uint64_t));
    }
  }

  Attribute read_attribute() {
    constexpr std::uint8_t strided = 1, uniform = 2, paged = 8, unknown = 16;
    constexpr std::uint64_t head = 6;  // that counts as values
    constexpr std::uint64_t most = std::uint64_t{1} << 40;
    const auto bytes = take<std::uint64_t>(stream_) - head;
    take<std::uint8_t>(stream_);  // what the attribute is for
    const auto stored = take<std::uint8_t>(stream_);
    take<std::uint32_t>(stream_);  // number of points
    if (stored & strided) take<std::uint32_t>(stream_);
    if (stored >= unknown || bytes > most)
      throw std::runtime_error("an attribute of its points has an unknown format");
    return {(stored & uniform) != 0, (stored & paged) != 0, std::int64_t(bytes)};
  }

  /// The pages of an attribute, whose lengths stand where the first leaf of each has its turn.
  void read_pages(std::size_t number) {
    std::int64_t page = 0, used = 0;
    for (std::size_t n = 0, begin = 0; n < ends_.size(); begin = ends_[n++]) {
      if (begin + number >= ends_[n]) continue;
      const Attribute& attribute = attributes_[begin + number];
      if (!attribute.paged) {
        rest_ += attribute.bytes + (attribute.uniform ? 0 : 1);
        continue;
      }
      if (used == page) {
        const std::int64_t stored = take<std::int32_t>(stream_);  // negative: not compressed
        page = stored > 0 ? take<std::int32_t>(stream_) : -stored;
        used = 0;
        rest_ += std::abs(stored);
      }
      used += attribute.bytes;
      if (used > page)
        throw std::runtime_error("an attribute of its points is longer than its page");
    }
  }

  /// From the offsets behind each voxel's last point.
  PointCounts read_counts() {
    constexpr std::uint16_t not_compressed = std::numeric_limits<std::uint16_t>::max();
    std::array<std::uint32_t, kLeafVoxels> ends;
    constexpr std::size_t size = kLeafVoxels * sizeof(std::uint32_t);
    skip(sizeof(LeafMask));
    const auto length = take<std::uint16_t>(stream_);
    std::string stored(length == not_compressed ? size : length, '\0');
    stream_.read(stored.data(), std::streamsize(stored.size()));
    if (length == not_compressed)
      std::memcpy(ends.data(), stored.data(), size);
    else
      expand_blosc(stored, reinterpret_cast<char*>(ends.data()), size);
    return point_counts([&](std::size_t i) { return ends[i]; });
  }

  std::size_t leaves_;
  std::istream& stream_;
  std::vector<Attribute> attributes_;  ///< of the first leaf, of the second, ...
  std::vector<std::size_t> ends_;      ///< of each leaf's attributes
  std::int64_t rest_ = 0;              ///< bytes of all attributes' values
};

}  // namespace

std::int64_t read_point_counts(std::size_t leaves, std::istream& stream, const TakeCounts& take) {
  return PointReader(leaves, stream).read(take);
}

}  // namespace psivox::vdb
