#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "archives.h"
#include "field/value_range.h"
#include "grid_types.h"
#include "topology_builder.h"

namespace psivox::vdb {
namespace {

constexpr std::size_t batch_leaves = 2048, leaves_per_task = 64;
/// Enough for the kind of a leaf's values and the length of their block. [bytes]
constexpr std::int64_t head_bytes = 32;
constexpr std::int64_t widest_gap = 4 << 10;  // that is read rather than skipped [bytes]

template <typename LeafT, typename Number>
void copy_values(const LeafT& leaf, Number* to) {
  using ValueT = typename LeafT::ValueType;
  if constexpr (std::is_same_v<ValueT, bool>) {  // bits
    for (openvdb::Index i = 0; i < kLeafVoxels; ++i) *to++ = leaf.getValue(i);
  } else {
    const ValueT* const values = leaf.buffer().data();
    for (std::size_t i = 0; i < kLeafVoxels; ++i)
      for (int c = 0; c < channels_of_value<ValueT>; ++c)
        *to++ = component_of<Number>(values[i], c);
  }
}

/// Where a leaf's values are in the file [bytes].
struct LeafPlace {
  std::int64_t begin, end;
};

/// Reads leaves of a grid, each from its place in the file, without the grid's tree.
template <typename LeafT>
class LeafDecoder {
 public:
  using ValueT = typename LeafT::ValueType;

  LeafDecoder(std::shared_ptr<FileBlocks> file, openvdb::io::StreamMetadata::Ptr coding,
              const ValueT& background, std::optional<double> fill)
      : file_(std::move(file)), coding_(std::move(coding)), background_(background), fill_(fill) {}

  /// Reads the leaves at these places, in all threads. Reads large runs, which the file keeps, or
  /// nothing but the leaves. Throws if a leaf is longer or shorter than its place.
  void decode(std::span<const LeafPlace> places, bool in_runs, const TakeLeaf& take) const {
    const std::size_t tasks = (places.size() + leaves_per_task - 1) / leaves_per_task;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      const std::size_t begin = task * leaves_per_task;
      const std::size_t count = std::min(leaves_per_task, places.size() - begin);
      decode_some(places.subspan(begin, count), begin, in_runs, take);
    });
  }

 private:
  void decode_some(std::span<const LeafPlace> places, std::size_t first, bool in_runs,
                   const TakeLeaf& take) const {
    FileBuffer buffer(*file_);
    std::istream stream(&buffer);
    stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    auto coding = std::make_shared<openvdb::io::StreamMetadata>(*coding_);
    coding->setSeekable(false);  // a leaf's mask is read, too
    coding->setBackgroundPtr(&background_);
    openvdb::io::setStreamMetadataPtr(stream, coding);
    LeafT leaf(openvdb::Coord(0), background_);
    std::size_t together = 0;  // leaves before this one are in what was read
    for (std::size_t n = 0; n < places.size(); ++n) {
      stream.seekg(places[n].begin);
      if (!in_runs && n == together) {
        while (++together < places.size())
          if (const auto gap = places[together].begin - places[together - 1].end;
              gap < 0 || gap > widest_gap)
            break;
        buffer.read_only(places[together - 1].end - places[n].begin);
      }
      leaf.readBuffers(stream, coding->halfFloat());
      if (stream.tellg() != places[n].end)
        throw std::runtime_error("a block of its values has another length");
      const LeafMask active = mask_of(leaf.getValueMask());
      if (fill_) replace_background(leaf);
      take(first + n, MadeLeaf(active, [&](auto* to) { copy_values(leaf, to); }));
    }
  }

  void replace_background(LeafT& leaf) const {
    const auto fill = value_from<ValueT>(*fill_);
    for (openvdb::Index i = 0; i < kLeafVoxels; ++i)
      if (!leaf.isValueOn(i) && same_values(ValueT(leaf.getValue(i)), background_))
        leaf.setValueOff(i, fill);
  }

  std::shared_ptr<FileBlocks> file_;
  openvdb::io::StreamMetadata::Ptr coding_;
  ValueT background_;
  std::optional<double> fill_;
};

template <typename GridT>
class VdbGrid final : public FileGrid {
  using TreeT = typename GridT::TreeType;
  using LeafT = typename TreeT::LeafNodeType;
  using ValueT = typename GridT::ValueType;
  static constexpr bool points = std::is_same_v<GridT, openvdb::points::PointDataGrid>;

 public:
  explicit VdbGrid(const VdbSource& from)
      : FileGrid(from.file, from.entry, from.marked),
        from_(from),
        grid_(openvdb::gridPtrCast<GridT>(from.grid)),
        places_{std::int64_t(from.stream.tellg())} {
    const auto& root = std::as_const(*grid_).tree().root();
    for (auto node = root.cbeginChildAll(); node; ++node)
      if ((node.getCoord() & ~(int(TreeT::RootNodeType::ChildNodeType::DIM) - 1)) !=
          node.getCoord())
        throw std::runtime_error("a node of its root is at an impossible place");
    begin(from.head);
  }

  std::string why_whole() const override {
    if (is_marked()) return "active voxels are marked in the whole";
    if (points) return "points are counted in the whole";
    return {};
  }

 private:
  const ValueT& background() const { return std::as_const(*grid_).tree().background(); }

  Topology read_topology() override {
    leaves_.clear();
    TopologyBuilder<ValueT> found(fill_, background());
    take_nodes(grid_->tree().root(), found, [&](LeafT& leaf) { leaves_.push_back(&leaf); });
    return found.take();
  }

  bool can_be(double value) const override { return value_can_be<ValueT>(value); }

  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override {
    if constexpr (points)
      read_counts(take);
    else
      read_batches(take, enough);
  }

  void begin_at(std::int64_t place) {
    from_.coding->setBackgroundPtr(&background());
    openvdb::io::setStreamMetadataPtr(from_.stream, from_.coding);
    from_.stream.clear();
    from_.stream.seekg(place);
  }

  /// The numbers of points in voxels, from the offsets behind the last one of each.
  void read_counts(const TakeLeaf& take) {
    begin_at(places_.front());
    read_points(*grid_, from_.stream, *from_.coding, /*whole=*/false);
    for (std::size_t n = 0; n < leaves_.size(); ++n) {
      std::array<std::int64_t, kLeafVoxels> counts;
      std::int64_t last = 0;
      for (openvdb::Index i = 0; i < kLeafVoxels; ++i) {
        const std::int64_t end = openvdb::Index32(leaves_[n]->getValue(i));
        if (end < last) throw std::runtime_error("its points are out of order");
        counts[i] = end - std::exchange(last, end);
      }
      take(n, MadeLeaf(mask_of(leaves_[n]->getValueMask()),
                       each_voxel([&](std::size_t i) { return counts[i]; })));
    }
  }

  void read_batches(const TakeLeaf& take, const std::function<bool()>& enough) {
    std::size_t wanted = enough ? 1 : batch_leaves;
    std::vector<std::uint32_t> batch;
    for (std::size_t first = 0; first < leaves_.size(); first += batch.size()) {
      batch.resize(std::min(wanted, leaves_.size() - first));
      std::iota(batch.begin(), batch.end(), std::uint32_t(first));
      find_places(first + batch.size());
      decode(batch, /*in_runs=*/true,
             [&](std::size_t n, const DecodedLeaf& leaf) { take(first + n, leaf); });
      if (enough && enough()) return;
      wanted = std::min(2 * wanted, batch_leaves);
    }
  }

  void read_some(std::span<const std::uint32_t> numbers, const TakeLeaf& take) override {
    if constexpr (!points) {
      // small leaves are read in fewer calls than skipped
      if (from_.entry.end - places_.front() > 4 * head_bytes * std::int64_t(leaves_.size()))
        from_.buffer.read_only(head_bytes);
      find_places(leaves_.size());
      decode(numbers, /*in_runs=*/false, take);
    }
  }

  /// Finds where the first leaves are, by skipping over them in one thread: a leaf's place depends
  /// on the lengths of those before it.
  void find_places(std::size_t leaves) {
    if (places_.size() > leaves) return;
    begin_at(places_.back());
    while (places_.size() <= leaves) {
      skipped_.setValueMask(leaves_[places_.size() - 1]->getValueMask());
      skipped_.readBuffers(from_.stream, openvdb::CoordBBox(), from_.coding->halfFloat());
      places_.push_back(from_.stream.tellg());
      if (places_.size() % leaves_per_task == 0) from_.buffer.report(places_.back());
    }
    from_.buffer.report(places_.back());
  }

  void decode(std::span<const std::uint32_t> numbers, bool in_runs, const TakeLeaf& take) const {
    std::vector<LeafPlace> places;
    for (const std::uint32_t n : numbers) places.push_back({places_[n], places_[n + 1]});
    LeafDecoder<LeafT>(from_.blocks, from_.coding, background(), fill_)
        .decode(places, in_runs, take);
  }

  VdbSource from_;
  typename GridT::Ptr grid_;
  std::vector<LeafT*> leaves_;        ///< of the tree, in its order
  std::vector<std::int64_t> places_;  ///< where leaves begin, the first and those found [bytes]
  LeafT skipped_;
};

}  // namespace

std::unique_ptr<FileGrid> vdb_grid(const VdbSource& source) {
  std::unique_ptr<FileGrid> grid;
  source.grid->apply<SupportedGrids>([&](const auto& typed) {
    grid = std::make_unique<VdbGrid<std::decay_t<decltype(typed)>>>(source);
  });
  return grid;
}

}  // namespace psivox::vdb
