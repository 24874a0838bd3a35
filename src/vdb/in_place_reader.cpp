#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "archive.h"
#include "file_grid.h"
#include "grid_types.h"
#include "read_grid.h"
#include "reader.h"
#include "scan/scan.h"

namespace psivox::vdb {
namespace {

std::unique_ptr<GridFile> open_grids(std::shared_ptr<FileBlocks> file, Progress progress = {}) {
  if (is_nano(*file)) return open_nano_file(std::move(file), std::move(progress));
  return std::make_unique<Archive>(std::move(file), std::move(progress));
}

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
  if (header.frames > 1) source.facts.metadata["frames"] = std::to_string(header.frames);
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

/// Reads in this process. Each read has a stream of its own, so that reads may run in several
/// threads and a failed one does not affect the others.
class InPlaceReader final : public Reader {
 public:
  InPlaceReader(std::shared_ptr<FileBlocks> file, Progress progress)
      : file_(std::move(file)), progress_(std::move(progress)) {}

  FileFacts facts() override {
    const auto grids = open_grids(file_, progress_);
    FileFacts facts;
    facts.metadata = grids->metadata();
    std::vector<std::string> names;
    std::vector<MetadataText> metadata;
    for (const GridEntry& entry : grids->entries()) {
      const std::string& type = entry.descriptor.gridType();
      names.push_back(entry.descriptor.gridName());
      metadata.push_back(grids->metadata_of(entry));
      const auto grid_class = metadata.back().find("class");
      facts.grids.push_back({entry.name, names.back(),
                             entry.problem.empty() ? channels_of(type) : 0, value_type_of(type),
                             grid_class == metadata.back().end() ? "unknown" : grid_class->second});
    }
    facts.z_up = evidence_of_z_up(facts.metadata, names, metadata);
    return facts;
  }

  std::vector<GridInfo> info(const std::string& grid, bool values) override {
    const auto grids = open_grids(file_);
    if (!grid.empty()) return {grid_info(*grids, grids->find(grid), values)};
    std::vector<GridInfo> rows;
    for (const GridEntry& entry : grids->entries())
      rows.push_back(grid_info(*grids, entry, values));
    return rows;
  }

  GridContent content(const std::string& grid) override {
    const auto grids = open_grids(file_);
    return content_of(*grids, grids->find(grid));
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    const auto grids = open_grids(file_, progress_);
    const GridEntry& entry = grids->find(grid);
    if (std::optional<Field> same = last_field(grid, options)) return std::move(*same);
    ReadGrid read = read_grid(*grids, entry, options);
    if (options.active || !read.voxels) return std::move(read.field);
    const std::lock_guard lock(mutex_);
    last_ = read.field;
    last_.storage.reset();
    last_.active_range.reset();
    last_.active_percentiles.clear();
    last_role_ = options.role;
    // a notice tells that reading has changed the values
    last_voxels_ = last_.notices.empty() ? read.voxels : nullptr;
    return std::move(read.field);
  }

 private:
  /// The field that was read last, as long as somebody holds it, if it has the same values for
  /// these options. A scene in an automatic look reads its density for one role and then another.
  std::optional<Field> last_field(const std::string& name, const ReadOptions& options) {
    const std::lock_guard lock(mutex_);
    const std::shared_ptr<const Voxels> voxels = last_voxels_.lock();
    const bool negative = last_role_ == GridRole::data && options.role != GridRole::data;
    if (!voxels || options.active || name != last_.name || negative) return {};
    Field field = last_;
    field.storage = voxels;
    look_again(field, *voxels, options);
    return field;
  }

  std::shared_ptr<FileBlocks> file_;  ///< shared with the readers of fields
  Progress progress_;

  std::mutex mutex_;  ///< of what follows
  Field last_;        ///< without storage, which follows
  std::weak_ptr<const Voxels> last_voxels_;
  GridRole last_role_ = GridRole::attenuation;
};

}  // namespace

std::unique_ptr<Reader> open_reader(std::shared_ptr<FileBlocks> file,
                                    std::shared_ptr<FileBlocks> data, Progress progress) {
  if (std::unique_ptr<scan::Scan> scan = scan::open_scan(file, std::move(data)))
    return scan_reader(std::move(scan), file->path(), std::move(progress));
  return std::make_unique<InPlaceReader>(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
