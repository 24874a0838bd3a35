#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "archives.h"
#include "grid_types.h"

namespace psivox::vdb {
namespace {

MetadataText text_of(const openvdb::MetaMap& metadata) {
  MetadataText text;
  for (auto item = metadata.beginMeta(); item != metadata.endMeta(); ++item)
    if (item->second->typeName() != openvdb::io::DelayedLoadMetadata::staticTypeName())
      text[item->first] = item->second->str();
  return text;
}

Transform transform_of(const openvdb::GridBase& grid) {
  Transform transform;
  transform.map = grid.transform().mapType();
  if (!grid.transform().isLinear()) {
    transform.frustum = grid.transformPtr();
    return transform;
  }
  // OpenVDB's vectors are rows: its row i is the image of axis i, which is glm's column i
  const openvdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      transform.world_from_index[row][column] = matrix(row, column);
  return transform;
}

/// A .vdb open for reading, its directory read. OpenVDB reads all of it, but not by its class File,
/// which refuses a whole file if one grid has an unregistered type, maps the file and finds it by
/// its name. Here the stream throws where the file ends.
class VdbArchive final : public GridFile, private openvdb::io::Archive {
 public:
  VdbArchive(std::shared_ptr<FileBlocks> file, Progress progress)
      : GridFile(std::move(file), std::move(progress)) {
    list_entries("VDB", [&] {
      readHeader(stream_);
      of_file_.reset(new openvdb::io::StreamMetadata);
      of_file_->setSeekable(true);
      openvdb::io::setStreamMetadataPtr(stream_, of_file_, /*transfer=*/false);
      setFormatVersion(stream_);
      setLibraryVersion(stream_);
      setDataCompression(stream_);
      openvdb::MetaMap metadata;
      metadata.readMeta(stream_);
      file_metadata_ = text_of(metadata);
      read_directory();
    });
  }

  EntryHead entry_head(const GridEntry& entry) override {
    EntryHead head;
    if (!entry.problem.empty()) return head;
    try {
      const openvdb::GridBase::Ptr grid = begin(entry).grid;
      head.metadata = text_of(*grid);
      if (has_transform_first()) head.place = place_in(head.metadata, transform_of(*grid));
    } catch (const std::exception&) {  // reading the grid says what is wrong with it
    }
    return head;
  }

 private:
  /// A grid without its tree, at which the stream is.
  struct Begun {
    openvdb::GridBase::Ptr grid;
    openvdb::io::StreamMetadata::Ptr coding;
  };

  /// Whether transforms stand before trees, as they do since grids can share a tree.
  bool has_transform_first() const {
    return fileVersion() >= openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING;
  }

  void read_directory() {
    const std::int32_t count = readGridCount(stream_);
    lost_ = std::max(count, 0);
    for (std::int32_t i = 0; i < count; ++i) {
      GridEntry entry;
      try {
        read_entry(entry);
      } catch (const std::exception& e) {
        // Grids listed before can still be read; without a type this one cannot be listed.
        if (entries_.empty() && entry.type.empty()) throw;
        if (entry.type.empty()) return;
        entry.problem = "cannot be read: " + explain(e);
        entries_.push_back(std::move(entry));
        // what psivox does not know is there; where the grids behind it are is not known
        if (!dynamic_cast<const std::ios_base::failure*>(&e)) lost_ = 0;
        return;
      }
      const bool end_is_known =
          inputHasGridOffsets() ? entry.end <= file_->size() : channels_of(entry.type) > 0;
      if (!end_is_known && i + 1 < count) {
        entry.problem += "; " + std::to_string(count - i - 1) + " more behind it cannot be found";
      }
      if (inputHasGridOffsets() && end_is_known) stream_.seekg(entry.end);
      lost_ -= entry.end <= file_->size();
      entries_.push_back(std::move(entry));
      if (end_is_known) continue;
      // behind a grid of a foreign type they are there, but not found
      if (!inputHasGridOffsets()) lost_ = 0;
      return;
    }
  }

  void read_entry(GridEntry& entry) {
    openvdb::io::GridDescriptor descriptor;
    std::array<std::int64_t, 3> places{};
    try {
      descriptor.read(stream_);
      places = {descriptor.getGridPos(), descriptor.getBlockPos(), descriptor.getEndPos()};
    } catch (const openvdb::LookupError&) {  // behind the names: its type is not registered
      stream_.read(reinterpret_cast<char*>(places.data()), sizeof places);
    }
    entry.unique_name = descriptor.uniqueName();
    entry.type = descriptor.gridType();
    entry.half = descriptor.saveFloatAsHalf();
    entry.parent = descriptor.instanceParentName();
    entry.begin = places[0];
    entry.end = places[2];
    if (channels_of(entry.type) == 0) entry.problem = unsupported_type(entry.type);
    if (!inputHasGridOffsets()) {
      if (entry.problem.empty()) skip_grid(entry);
      return;
    }
    // Positions only grow, so the loop over the directory ends for any file.
    if (entry.begin < std::int64_t(stream_.tellg()) || entry.end < entry.begin)
      throw std::runtime_error("its position in the file is impossible");
    if (entry.end > file_->size())
      entry.problem = "is cut short: it needs " + std::to_string(entry.end) +
                      " bytes, the file has " + std::to_string(file_->size());
  }

  /// Finds the positions of a grid in a file that has none (one that was written to a pipe). The
  /// stream is at the grid and goes behind it.
  void skip_grid(GridEntry& entry) {
    entry.begin = stream_.tellg();
    entry.end = file_->size();
    const Begun begun = begin(entry);
    if (entry.parent.empty()) {
      begun.grid->readTopology(stream_);
      if (!has_transform_first()) begun.grid->readTransform(stream_);
      if (is_points(entry.type))
        read_points(static_cast<openvdb::points::PointDataGrid&>(*begun.grid), stream_,
                    *begun.coding, /*whole=*/true);
      else
        begun.grid->readBuffers(stream_);
    }
    entry.end = stream_.tellg();
  }

  /// The grid that has an instance's tree.
  const GridEntry& parent_of(const GridEntry& entry) const {
    for (const GridEntry& parent : entries_)
      if (parent.unique_name == entry.parent) return parent;
    throw std::runtime_error("the grid that has its tree is missing");
  }

  Begun begin(const GridEntry& entry) {
    Begun begun{openvdb::GridBase::createGrid(entry.type),
                std::make_shared<openvdb::io::StreamMetadata>(*of_file_)};
    stream_.clear();
    stream_.seekg(entry.begin);
    buffer_.expect(entry.end - entry.begin);
    begun.coding->setHalfFloat(entry.half);
    of_grid_ = begun.coding;
    openvdb::io::setStreamMetadataPtr(stream_, of_grid_);
    readGridCompression(stream_);
    using namespace openvdb::io;
    if (getDataCompression(stream_) & ~(COMPRESS_ZIP | COMPRESS_ACTIVE_MASK | COMPRESS_BLOSC))
      throw std::runtime_error("it is compressed by an unknown codec");
    begun.grid->readMeta(stream_);
    begun.grid->setSaveFloatAsHalf(entry.half);  // metadata may tell otherwise
    setGridClass(stream_, begun.grid->getGridClass());
    if (has_transform_first()) begun.grid->readTransform(stream_);
    return begun;
  }

  std::unique_ptr<FileGrid> opened(const GridEntry& entry, bool marked) override {
    const Begun own = begin(entry);
    Begun tree = own;
    if (!entry.parent.empty()) {
      tree = begin(parent_of(entry));
      if (tree.grid->type() != own.grid->type())
        throw std::runtime_error("the grid that has its tree is of another type");
    }
    tree.grid->readTopology(stream_);
    if (!has_transform_first()) own.grid->readTransform(stream_);
    GridHead head{
        .type = entry.type, .metadata = text_of(*own.grid), .transform = transform_of(*own.grid)};
    head.grid_class = class_in(head.metadata);
    return vdb_grid(
        {*this, entry, marked, std::move(head), tree.grid, tree.coding, file_, stream_, buffer_});
  }

  /// How the file and its last grid are stored. The stream keeps a plain pointer to one of them.
  openvdb::io::StreamMetadata::Ptr of_file_, of_grid_;
};

}  // namespace

std::unique_ptr<GridFile> open_vdb(std::shared_ptr<FileBlocks> file, Progress progress) {
  return std::make_unique<VdbArchive>(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
