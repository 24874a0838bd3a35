#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "field/index_space.h"
#include "field/value_range.h"
#include "grid_file.h"
#include "grids_module.h"
#include "reader.h"
#include "scan/scan.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

/// Throws for a file of a format that psivox does not read.
[[noreturn]] void refuse_foreign(FileBlocks& file) {
  const FileRun first = file.run(0);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  const std::string format = foreign_format(file.path(), head);
  const std::string unknown =
      head.empty() ? "is empty"
                   : "begins as no volume that psivox reads: .vdb, .nvdb, NIfTI or NRRD";
  throw Error(ExitCode::input, file.path() + ": " + (format.empty() ? unknown : format));
}

/// Statistics of the active values in their own type.
std::optional<ValueStatistics> statistics_of(FileGrid& grid) {
  const int channels = grid.channels();
  std::vector<Statistics> leaves(grid.topology().leaves.size());
  grid.each_leaf([&](std::size_t n, const DecodedLeaf& leaf) {
    std::array<double, 3 * kLeafVoxels> values;
    leaf.copy_to(values.data());
    leaves[n].add(values.data(), channels, leaf.active());
  });
  Statistics found;
  for (const Statistics& leaf : leaves) found.add(leaf);
  for (const TilePart& part : grid.topology().tiles)
    if (part.active) found.add(&part.value.x, channels, tile_voxels(part.tile()));
  return found.all();
}

void set_transform(const Transform& transform, GridInfo& info) {
  info.transform = transform.map;
  if (!transform.is_linear()) {
    const FrustumPlace place = grids_module().place(transform, info.active_box);
    info.voxel_size = place.voxel_size;
    info.world_min = place.world_min;
    info.world_max = place.world_max;
    return;
  }
  set_linear(transform.world_from_index, info);
}

/// Without OpenVDB's own statistics of the file and what other rows tell.
MetadataText other_metadata(MetadataText text) {
  for (const char* known :
       {"name", "class", "is_saved_as_half_float", "file_bbox_min", "file_bbox_max",
        "file_mem_bytes", "file_voxel_count", "file_compression", "file_delayed_load"})
    text.erase(known);
  return text;
}

/// NaN counts as 0.
bool is_value(double value) { return value < 0 || value > 0; }

bool has_value(const DecodedLeaf& leaf, int channels) {
  std::array<float, 3 * kLeafVoxels> values;
  leaf.copy_to(values.data());
  const auto stride = std::size_t(channels);
  bool found = false;
  each_on(leaf.active(), [&](std::size_t i) {
    found |= std::any_of(values.data() + i * stride, values.data() + (i + 1) * stride, is_value);
  });
  return found;
}

bool has_value(FileGrid& grid) {
  for (const TilePart& part : grid.topology().tiles) {
    const glm::vec3 value = part.tile().value;
    if (part.active && (is_value(value.x) || is_value(value.y) || is_value(value.z))) return true;
  }
  std::atomic<bool> found = false;
  grid.each_leaf(
      [&](std::size_t, const DecodedLeaf& leaf) {
        if (!found && has_value(leaf, grid.channels())) found = true;
      },
      [&] { return found.load(); });
  return found;
}

/// What a picture could be made of. It reads the topology, and leaves up to the first that has an
/// active value other than 0. Throws Error(input).
GridContent content_of(GridFile& file, const GridEntry& entry) {
  const auto grid = file.open(entry);
  const std::uint64_t voxels = grid->summary().active_voxels;
  return vdb::content_of(voxels, voxels > 0 && has_value(*grid));
}

/// The row of one grid; reads its tree, without `values` only its topology. Never throws for a bad
/// grid: GridInfo::problem says why.
GridInfo grid_info(GridFile& file, const GridEntry& entry, bool values) {
  GridInfo info;
  info.name = entry.name;
  info.type = printable(entry.type);
  info.value_type = value_type_of(info.type);
  info.channels = channels_of(info.type);
  info.saved_as_half = entry.half;
  info.problem = entry.problem;
  if (!entry.problem.empty()) return info;

  try {
    const auto grid = file.open(entry);
    if (values) info.values = statistics_of(*grid);
    info.values_read = values;
    const GridSummary& summary = grid->summary();
    const GridHead& head = grid->head();
    info.grid_class = head.grid_class;
    info.active_voxels = summary.active_voxels;
    info.leaves = summary.leaves;
    info.active_tiles = summary.active_tiles;
    info.active_box = summary.active_box;
    info.background = summary.background[0];
    set_transform(head.transform, info);
    info.metadata = other_metadata(head.metadata);
    info.problem = problem_of(head.transform, summary);
    if (info.problem.empty()) info.problem = problem_of_distances(head, summary);
  } catch (const Error& e) {
    info.problem = without_subject(e.what(), file.path(), entry.name);  // the row names the grid
  }
  return info;
}

/// Reads in this process. Each read has a stream to itself, so that reads may run in several
/// threads and a failed one does not affect the others.
class InPlaceReader final : public Reader {
 public:
  InPlaceReader(std::shared_ptr<FileBlocks> file, Progress progress)
      : file_(std::move(file)), progress_(std::move(progress)) {}

  FileFacts facts() override {
    return with_grids([](GridFile& grids) {
      FileFacts facts;
      facts.metadata = grids.metadata();
      facts.lost = grids.lost();
      std::vector<std::string> names;
      std::vector<MetadataText> metadata;
      for (const GridEntry& entry : grids.entries()) {
        const std::string& type = entry.type;
        names.push_back(entry.base_name);
        EntryHead head = grids.entry_head(entry);
        facts.grids.push_back({entry.name, names.back(),
                               entry.problem.empty() ? channels_of(type) : 0, value_type_of(type),
                               std::string(class_in(head.metadata)), head.place});
        metadata.push_back(std::move(head.metadata));
      }
      facts.z_up = evidence_of_z_up(facts.metadata, names, metadata);
      return facts;
    });
  }

  GridInfo info(const std::string& grid, bool values) override {
    return with_grids([&](GridFile& grids) { return grid_info(grids, grids.find(grid), values); });
  }

  GridContent content(const std::string& grid) override {
    return with_grids([&](GridFile& grids) { return content_of(grids, grids.find(grid)); });
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    return with_grids([&](GridFile& grids) { return read_grid(grids, grids.find(grid), options); });
  }

  std::vector<float> leaves(const LeavesWish& wish) override {
    const std::lock_guard lock(stored_mutex_);
    if (!stored_ || stored_name_ != wish.grid) {
      stored_.reset();
      stored_file_ = grids_module().open(file_, {});
      stored_ = open_stored(*stored_file_, stored_file_->find(wish.grid), wish.options);
      stored_name_ = wish.grid;
    }
    return stored_leaves(*stored_, wish);
  }

 private:
  /// The result of work, in a directory that is read again only if another thread uses it.
  template <typename Work>
  std::invoke_result_t<const Work&, GridFile&> with_grids(const Work& work) {
    std::unique_ptr<GridFile> grids;
    {
      const std::lock_guard lock(mutex_);
      grids = std::move(idle_);
    }
    if (!grids) grids = grids_module().open(file_, progress_);
    auto result = work(*grids);
    const std::lock_guard lock(mutex_);
    idle_ = std::move(grids);
    return result;
  }

  std::shared_ptr<FileBlocks> file_;
  Progress progress_;

  std::mutex mutex_;                ///< of what follows
  std::unique_ptr<GridFile> idle_;  ///< whose directory is read

  std::mutex stored_mutex_;  ///< of what follows
  std::unique_ptr<GridFile> stored_file_;
  std::unique_ptr<FileGrid> stored_;  ///< whose leaves were asked for last
  std::string stored_name_;
};

/// Reads a scan's frames as grids: `image`, or `image[0]`, `image[1]`, ... of several; `rgb` of
/// colours.
std::unique_ptr<Reader> scan_reader(std::shared_ptr<const scan::Scan> scan, const std::string& path,
                                    Progress progress) {
  const scan::Header& header = scan->header();
  FieldSource source;
  source.path = path;
  source.type = header.format;
  source.facts.metadata = header.metadata;
  source.facts.z_up = header.z_up;
  source.facts.value_bytes = std::uint64_t(header.values) * std::uint64_t(size_of(header.type));
  if (header.frames > 1 && header.in_time)
    source.facts.metadata["frames"] = std::to_string(header.frames);
  const std::string base = header.colour ? "rgb" : "image";
  for (std::int64_t n = 0; n < header.frames; ++n)
    source.facts.grids.push_back({header.frames == 1 ? base : base + "[" + std::to_string(n) + "]",
                                  base, header.channels, header.value_type(),
                                  header.statistic ? "unknown" : "scan"});
  source.make = [scan = std::move(scan), names = source.facts.grids,
                 progress = std::move(progress)](std::size_t n) {
    return std::make_shared<const Field>(scan->read(std::int64_t(n), names[n].name, progress));
  };
  return field_reader(std::move(source));
}

}  // namespace

std::unique_ptr<Reader> open_reader(std::shared_ptr<FileBlocks> file,
                                    std::shared_ptr<FileBlocks> data, Progress progress) {
  if (std::unique_ptr<scan::Scan> scan = scan::open_scan(file, std::move(data)))
    return scan_reader(std::move(scan), file->path(), std::move(progress));
  if (!has_grids(*file)) refuse_foreign(*file);
  return std::make_unique<InPlaceReader>(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
