#include "archive.h"

#include <array>
#include <stdexcept>
#include <utility>

#include "trees.h"

namespace psivox::vdb {
namespace {

// versions of the format since which files have something
constexpr std::uint32_t with_flags = 212, with_instances = 216, with_uuid_as_text = 218,
                        with_compression_of_file = 220, with_node_masks = 222, with_passes = 224;

constexpr std::string_view magic(" BDV\0\0\0\0", 8);

/// Throws for a file of another format.
void refuse_foreign(FileBlocks& file) {
  const FileRun first = file.run(0, 1);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  if (head.starts_with(magic)) return;
  const std::string format = foreign_format(file.path(), head);
  const std::string unknown =
      head.empty() ? "is empty"
                   : "begins as no volume that psivox reads: .vdb, .nvdb, NIfTI or NRRD";
  throw Error(ExitCode::input, file.path() + ": " + (format.empty() ? unknown : format));
}

/// Throws if OpenVDB cannot be asked for it.
OldGrid old_grid(const GridEntry& entry) {
  if (stored_like(entry.type) != entry.type)
    throw std::runtime_error("a grid of its type in so old a format is not supported");
  return {entry.type, entry.half, entry.begin, entry.end};
}

}  // namespace

Archive::Archive(std::shared_ptr<FileBlocks> file, Progress progress)
    : GridFile(std::move(file), std::move(progress)) {
  refuse_foreign(*file_);
  try {
    read_header();
    file_metadata_ = read_metadata(stream_);
    read_directory();
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject(path()) + "is a damaged VDB file: " + explain(e));
  }
  name_entries();
}

bool Archive::is_old() const { return version_ < with_node_masks; }

void Archive::read_header() {
  constexpr int library_version = 8, uuid = 16, uuid_as_text = 36;
  stream_.seekg(magic.size());
  version_ = take<std::uint32_t>(stream_);
  if (version_ < with_flags)
    throw std::runtime_error("its format, " + std::to_string(version_) + ", is too old");
  stream_.seekg(library_version, std::ios_base::cur);
  has_places_ = take<char>(stream_) != 0;
  int rest = version_ < with_uuid_as_text ? uuid : uuid_as_text;
  if (version_ >= with_compression_of_file && is_old()) ++rest;  // whether it is compressed
  stream_.seekg(rest, std::ios_base::cur);
}

void Archive::read_directory() {
  const auto count = take<std::int32_t>(stream_);
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
        has_places_ ? entry.end <= file_->size() : channels_of(entry.type) > 0;
    if (!end_is_known && i + 1 < count) {
      entry.problem += "; " + std::to_string(count - i - 1) + " more behind it cannot be found";
    }
    if (has_places_ && end_is_known) stream_.seekg(entry.end);
    lost_ -= entry.end <= file_->size();
    entries_.push_back(std::move(entry));
    if (end_is_known) continue;
    if (!has_places_) lost_ = 0;  // behind a grid of a foreign type they are there, but not found
    return;
  }
}

void Archive::read_entry(GridEntry& entry) {
  constexpr std::string_view half = "_HalfFloat";
  entry.unique_name = read_string(stream_);
  entry.type = read_string(stream_);
  entry.half = entry.type.ends_with(half);
  if (entry.half) entry.type.resize(entry.type.size() - half.size());
  if (version_ >= with_instances) entry.parent = read_string(stream_);
  const auto places = take<std::array<std::int64_t, 3>>(stream_);
  entry.begin = places[0];
  entry.end = places[2];
  if (channels_of(entry.type) == 0) entry.problem = unsupported_type(entry.type);
  if (!has_places_) {
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
void Archive::skip_grid(GridEntry& entry) {
  constexpr std::int64_t mask_leaf = 64 + 3 * 4;  // the mask once more, and the origin [bytes]
  entry.begin = stream_.tellg();
  entry.end = file_->size();
  if (is_old()) {
    stream_.seekg(trees().rewritten(*file_, old_grid(entry), nullptr).end);
  } else if (const TreeHead tree = begin_grid(entry); entry.parent.empty()) {
    GridHead head = tree.head;
    const std::size_t leaves = read_topology(head, stream_, tree.coding).leaves.size();
    if (is_points(entry.type)) {
      stream_.seekg(read_point_counts(leaves, stream_, [](std::size_t, const PointCounts&) {}),
                    std::ios_base::cur);
    } else if (is_mask(entry.type)) {
      stream_.seekg(mask_leaf * std::int64_t(leaves), std::ios_base::cur);
    } else {
      const LeafDecoder decoder(nullptr, head, tree.coding);
      for (std::size_t n = 0; n < leaves; ++n) decoder.skip(stream_);
    }
  }
  entry.end = stream_.tellg();
}

/// The grid that has an instance's tree.
const GridEntry& Archive::parent_of(const GridEntry& entry) const {
  for (const GridEntry& parent : entries_)
    if (parent.unique_name == entry.parent) return parent;
  throw std::runtime_error("the grid that has its tree is missing");
}

TreeHead Archive::begin_tree(const GridEntry& entry) {
  TreeHead own = begin_grid(entry);
  if (entry.parent.empty()) return own;
  TreeHead tree = begin_grid(parent_of(entry));
  if (tree.head.type != own.head.type)
    throw std::runtime_error("the grid that has its tree is of another type");
  tree.head = std::move(own.head);
  return tree;
}

/// Reads what stands before a grid's tree.
TreeHead Archive::begin_grid(const GridEntry& entry) {
  TreeHead tree;
  tree.end = entry.end;
  stream_.clear();
  stream_.seekg(entry.begin);
  buffer_.expect(entry.end - entry.begin);
  tree.coding = {take<std::uint32_t>(stream_), entry.half};
  constexpr std::uint32_t known = ValueCoding::zip | ValueCoding::active_mask | ValueCoding::blosc;
  if (tree.coding.compression & ~known)
    throw std::runtime_error("it is compressed by an unknown codec");
  GridHead& head = tree.head;
  head.type = value_type_number(stored_like(entry.type));
  head.metadata = read_metadata(stream_, &tree.delayed_load);
  head.grid_class = class_in(head.metadata);
  head.transform = read_transform(stream_);
  if (is_points(entry.type) && version_ < with_passes)
    throw std::runtime_error("points in a file of so old a format are not supported");
  return tree;
}

std::shared_ptr<FileBlocks> Archive::rewritten(const GridEntry& entry) const {
  const OldGrid own = old_grid(entry);
  const OldGrid parent = entry.parent.empty() ? own : old_grid(parent_of(entry));
  return std::make_shared<FileBlocks>(
      path(), trees().rewritten(*file_, own, entry.parent.empty() ? nullptr : &parent).bytes);
}

std::unique_ptr<FileGrid> Archive::open(const GridEntry& entry, bool marked) {
  return open_archive_grid(*this, entry, file_, marked);
}

EntryHead Archive::entry_head(const GridEntry& entry) {
  EntryHead head;
  if (!entry.problem.empty()) return head;
  try {
    stream_.clear();
    stream_.seekg(entry.begin);
    if (!is_old()) take<std::uint32_t>(stream_);  // its compression
    head.metadata = read_metadata(stream_);
    if (!is_old()) head.place = place_in(head.metadata, read_transform(stream_));
  } catch (const std::exception&) {  // reading the grid says what is wrong with it
  }
  return head;
}

}  // namespace psivox::vdb
