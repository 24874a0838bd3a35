#include "file_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "grid_types.h"
#include "point_counts.h"
#include "psivox/error.h"
#include "psivox/value_percentile.h"

namespace psivox::vdb {
namespace {

constexpr std::size_t batch_leaves = 2048;     // 4 MiB of values
constexpr std::int64_t ahead_bytes = 8 << 20;  // that the system is asked to read
/// Enough for the kind of a leaf's values, their length and Blosc's header, if neither inactive
/// values nor a mask of them stand between. [bytes]
constexpr std::int64_t head_bytes = 32;
/// Tiles of the root that may be added: 28 MB of them.
constexpr double most_root_tiles = 1 << 20;

/// A leaf whose values are computed from `value_of(i)`.
template <typename ValueOf>
class MadeLeaf final : public DecodedLeaf {
 public:
  MadeLeaf(const LeafMask& mask, ValueOf value_of) : DecodedLeaf(mask), value_of_(value_of) {}

  void copy_to(float* values) const override { copy(values); }
  void copy_to(double* values) const override { copy(values); }

 private:
  template <typename Number>
  void copy(Number* values) const {
    for (std::size_t i = 0; i < kLeafVoxels; ++i) values[i] = static_cast<Number>(value_of_(i));
  }

  ValueOf value_of_;
};

/// Throws std::runtime_error if components of the grid's type do not have the value.
void check_component(const openvdb::GridBase& grid, double value) {
  with_typed_grid(grid, [&](const auto& typed) {
    using ValueT = typename std::decay_t<decltype(typed)>::ValueType;
    using Limits = std::numeric_limits<typename openvdb::VecTraits<ValueT>::ElementType>;
    // 2^63 is no int64, but the nearest double of the greatest.
    const bool within = value >= double(Limits::lowest()) && value < double(Limits::max()) + 1;
    if (within && (!Limits::is_integer || value == std::trunc(value))) return;
    std::ostringstream text;
    text << "has no value " << value << ", which --background-value asks for";
    throw std::runtime_error(text.str());
  });
}

}  // namespace

FileGrid::FileGrid(Archive& archive, const GridEntry& entry, std::shared_ptr<FileBlocks> file,
                   bool marked)
    : archive_(&archive), entry_(&entry), file_(std::move(file)) {
  const std::string& type = entry.descriptor.gridType();
  kind_ = marked || is_mask(type) ? Kind::marked : is_points(type) ? Kind::points : Kind::values;
  archive.guarded(entry, [&] {
    if (archive.is_old()) {
      file_ = archive.rewritten(entry);
      rewritten_ = std::make_unique<Archive>(*file_);
      archive_ = rewritten_.get();
    }
    TreeHead tree = archive_->begin_tree(rewritten_ ? archive_->entries().front() : entry);
    head_ = std::move(tree.grid);
    delayed_load_ = std::move(tree.delayed_load);
    end_ = tree.end;
    tree_at_ = archive_->stream().tellg();
    topology_ = read_topology(*head_, archive_->stream(), {.masks = kind_ != Kind::values});
    leaves_at_ = archive_->stream().tellg();
    if (kind_ == Kind::marked) mark();
  });
}

void FileGrid::mark() {
  const auto marks = new_grid<openvdb::FloatGrid>();
  marks->insertMeta(*head_);
  marks->setTransform(head_->transformPtr());
  marks->setGridClass(openvdb::GRID_UNKNOWN);
  head_ = marks;
  std::erase_if(topology_.tiles, [](const TilePart& tile) { return !tile.active; });
  for (TilePart& tile : topology_.tiles) tile.value = {1, 0, 0};
  topology_.summary.channels = 1;
  topology_.summary.background = glm::dvec3(0);
}

std::string FileGrid::why_whole() const {
  if (kind_ == Kind::marked) return "active voxels are marked in the whole";
  if (kind_ == Kind::points) return "points are counted in the whole";
  return {};
}

void FileGrid::set_background(double value) {
  check_component(*head_, value);
  fill_ = value;
  if (value != 0) {  // tiles of 0 are left out
    archive_->guarded(*entry_, [&] {
      archive_->stream().seekg(tree_at_);
      topology_ = read_topology(*head_, archive_->stream(),
                                {.masks = kind_ != Kind::values, .background = glm::dvec3(value)});
    });
    if (summary().active_voxels > 0) fill_root(value);
  }
  topology_.summary.background = glm::dvec3(0);
}

/// Adds tiles to the root where it has neither a tile nor a node.
void FileGrid::fill_root(double value) {
  constexpr int width = 4096;
  const auto node_of = [](const glm::ivec3& voxel) {
    return openvdb::Coord(voxel.x, voxel.y, voxel.z) & ~(width - 1);
  };
  // One voxel around the active ones belongs to the domain.
  const Box& box = summary().active_box;
  const openvdb::Coord first = node_of(box.min - 1);
  double count = 1;
  for (int axis = 0; axis < 3; ++axis)
    count *= (double(box.max[axis]) + 1 - first[axis]) / width + 1;
  if (count > most_root_tiles)
    throw std::runtime_error(
        "is too wide to be filled with --background-value; only 0 needs no memory");
  std::vector<TilePart>& tiles = topology_.tiles;
  // a node has leaves or tiles everywhere
  std::set<openvdb::Coord> taken;
  for (const glm::ivec3& leaf : topology_.leaves) taken.insert(node_of(leaf));
  for (const TilePart& tile : tiles) taken.insert(node_of(tile.origin));
  for (int x = first.x(); x <= box.max.x + 1; x += width)
    for (int y = first.y(); y <= box.max.y + 1; y += width)
      for (int z = first.z(); z <= box.max.z + 1; z += width)
        if (!taken.contains({x, y, z}))
          tiles.push_back({{x, y, z}, width, glm::dvec3(value), false});
  std::ranges::stable_sort(tiles, [&](const TilePart& a, const TilePart& b) {
    if (a.width != b.width) return a.width > b.width;
    return a.width == width && node_of(a.origin) < node_of(b.origin);
  });
}

void FileGrid::each_leaf(const TakeLeaf& take, const std::function<bool()>& enough) {
  archive_->guarded(*entry_, [&] {
    archive_->stream().seekg(leaves_at_);
    if (kind_ == Kind::values) return each_stored_leaf(take, enough);
    const std::vector<LeafMask>& masks = topology_.masks;
    if (kind_ == Kind::points) {
      read_point_counts(masks.size(), archive_->stream(),
                        [&](std::size_t n, const PointCounts& counts) {
                          take(n, MadeLeaf(masks[n], [&](std::size_t i) { return counts[i]; }));
                        });
    } else {
      tbb::parallel_for(std::size_t{0}, masks.size(), [&](std::size_t n) {
        take(n, MadeLeaf(masks[n], [&](std::size_t i) {
               return masks[n].isOn(static_cast<openvdb::Index>(i));
             }));
      });
    }
  });
}

/// A leaf's place depends on the lengths of those before it. So one thread finds the places of a
/// batch by skipping over them, and then all threads decode.
void FileGrid::each_stored_leaf(const TakeLeaf& take, const std::function<bool()>& enough) {
  const LeafDecoder decoder = this->decoder();
  const std::size_t count = topology_.leaves.size();
  std::istream& stream = archive_->stream();
  places_.assign(1, leaves_at_);
  places_.reserve(enough ? 1 : count + 1);
  std::vector<LeafPlace> batch;
  std::size_t wanted = enough ? 1 : batch_leaves;
  for (std::size_t first = 0; first < count; first += batch.size()) {
    file_->announce(places_.back(), ahead_bytes);
    batch.clear();
    while (batch.size() < std::min(wanted, count - first)) {
      decoder.skip(stream);
      batch.push_back({places_.back(), stream.tellg()});
      places_.push_back(batch.back().end);
    }
    archive_->buffer().read_to(places_.back());
    decoder.decode(batch, /*in_runs=*/true,
                   [&](std::size_t n, const DecodedLeaf& leaf) { take(first + n, leaf); });
    if (enough && enough()) return;
    wanted = std::min(2 * wanted, batch_leaves);
  }
}

void FileGrid::find_places() {
  archive_->guarded(*entry_, [&] {
    const LeafDecoder decoder = this->decoder();
    std::istream& stream = archive_->stream();
    stream.seekg(leaves_at_);
    places_ = decoder.lengths(delayed_load_, topology_);
    places_.insert(places_.begin(), leaves_at_);
    std::partial_sum(places_.begin(), places_.end(), places_.begin());
    const std::size_t leaves = topology_.leaves.size();
    if (places_.size() > leaves && places_.back() == end_) return;
    places_.assign(1, leaves_at_);
    // small leaves are read in fewer calls than skipped
    if (end_ - leaves_at_ > 4 * head_bytes * std::int64_t(leaves))
      archive_->buffer().read_only(head_bytes);
    for (const std::uint16_t active : topology_.active) {
      decoder.skip(stream, active);
      places_.push_back(stream.tellg());
    }
    archive_->buffer().read_only(0);
  });
}

FileLeaves::FileLeaves(const FileGrid& grid, const LeafSurvey& survey, std::string subject,
                       bool surveyed)
    : decoder_(grid.decoder()),
      survey_(survey),
      subject_(std::move(subject)),
      places_(grid.places()),
      floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(grid.channels())) {
  if (!surveyed) origins_ = grid.topology().leaves;
  for (const TilePart& part : grid.topology().tiles)
    if (part.active) active_tiles_.push_back({part.tile().value.x, tile_voxels(part.tile())});
}

template <typename Take>
void FileLeaves::decode(std::span<const std::uint32_t> leaves, float* values,
                        const Take& take) const {
  std::vector<LeafPlace> places;
  places.reserve(leaves.size());
  for (const std::uint32_t leaf : leaves) {
    if (leaf + std::size_t{1} >= places_.size())
      throw Error(ExitCode::input, subject_ + "has no leaf of that number");
    places.push_back({places_[leaf], places_[leaf + 1]});
  }
  try {
    decoder_.decode(places, /*in_runs=*/false, [&](std::size_t n, const DecodedLeaf& leaf) {
      float* const to = values + n * floats_per_leaf_;
      leaf.copy_to(to);
      take(n, to, leaf.active());
    });
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject_ + "cannot be read again: " + e.what());
  }
}

void FileLeaves::clean(float* values, const LeafMask& active) const {
  if (survey_.without_ranges().take({}, values, active).bad.positive_infinite > 0)
    vdb::replace_infinite(values, floats_per_leaf_, largest_);
}

void FileLeaves::read(std::span<const std::uint32_t> leaves, float* values) const {
  decode(leaves, values,
         [&](std::size_t, float* leaf, const LeafMask& active) { clean(leaf, active); });
}

void FileLeaves::read_active(std::span<const std::uint32_t> leaves, float* values) const {
  const std::size_t channels = floats_per_leaf_ / kLeafVoxels;
  decode(leaves, values, [&](std::size_t, float* leaf, const LeafMask& active) {
    clean(leaf, active);
    for (auto off = active.beginOff(); off; ++off)
      leaf[off.pos() * channels] = std::numeric_limits<float>::quiet_NaN();
  });
}

ValueSurvey FileLeaves::survey(std::span<const std::uint32_t> leaves, float* values) const {
  if (origins_.empty()) throw Error(ExitCode::input, subject_ + "has been surveyed");
  SurveySum sum;
  decode(leaves, values, [&](std::size_t n, float* leaf, const LeafMask& active) {
    sum.add(survey_.take(origins_[leaves[n]], leaf, active));
  });
  return sum.total();
}

}  // namespace psivox::vdb
