#include <openvdb/openvdb.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "archive.h"
#include "grid_info.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "read_grid.h"
#include "stored_grid.h"

namespace psivox {

namespace vdb {

/// The grid that was read last, as long as somebody holds its field. A scene in an automatic look
/// reads its density for one role and then for another.
class LastGrid {
 public:
  /// The grid, if a field for this role has the same values; else null.
  openvdb::GridBase::Ptr get(const std::string& name, GridRole role) const {
    const std::lock_guard lock(mutex_);
    if (name != name_ || (role_ == GridRole::data && role != GridRole::data)) return nullptr;
    return grid_.lock();
  }

  /// Keeps a grid whose values the field shares. A notice tells that reading has changed them.
  void set(const openvdb::GridBase::Ptr& grid, const Field& field, GridRole role) {
    const std::lock_guard lock(mutex_);
    name_ = field.name;
    role_ = role;
    grid_.reset();
    if (field.notices.empty()) grid_ = grid;
  }

 private:
  mutable std::mutex mutex_;
  std::string name_;
  GridRole role_ = GridRole::attenuation;
  std::weak_ptr<openvdb::GridBase> grid_;
};

}  // namespace vdb

/// Holds the directory, and what was read last of the file. Each read has a stream of its own, so
/// that reads may run in several threads and a failed one does not affect the others.
struct VdbFile::Impl {
  explicit Impl(const std::filesystem::path& path)
      : file(std::make_shared<vdb::FileBlocks>(path)) {}

  std::shared_ptr<vdb::FileBlocks> file;  ///< shared with the readers of fields
  Progress progress;
  std::vector<std::string> names;
  std::vector<int> channels;  ///< by name; 0 if the grid cannot be read
  std::vector<std::string> classes;
  std::vector<std::string> base_names;
  vdb::MetadataText metadata;
  std::string z_up;
  vdb::LastGrid last;

  std::optional<std::size_t> place(const std::string& grid) const;  ///< in `names`
};

VdbFile::VdbFile(const std::filesystem::path& path, Progress progress)
    : impl_(std::make_unique<Impl>(path)) {
  impl_->progress = std::move(progress);
  vdb::Archive archive(*impl_->file, impl_->progress);
  impl_->metadata = archive.metadata();
  std::vector<vdb::MetadataText> grids;
  for (const vdb::GridEntry& entry : archive.entries()) {
    impl_->names.push_back(entry.name);
    impl_->channels.push_back(entry.problem.empty() ? vdb::channels_of(entry.descriptor.gridType())
                                                    : 0);
    impl_->base_names.push_back(entry.descriptor.gridName());
    grids.push_back(archive.metadata_of(entry));
    const auto grid_class = grids.back().find("class");
    impl_->classes.push_back(grid_class == grids.back().end() ? "unknown" : grid_class->second);
  }
  impl_->z_up = vdb::evidence_of_z_up(impl_->metadata, impl_->base_names, grids);
}

VdbFile::~VdbFile() = default;

const std::vector<std::string>& VdbFile::names() const { return impl_->names; }

std::optional<std::size_t> VdbFile::Impl::place(const std::string& grid) const {
  for (const auto* some : {&names, &base_names}) {
    const auto found = std::find(some->begin(), some->end(), grid);
    if (found != some->end()) return static_cast<std::size_t>(found - some->begin());
  }
  return {};
}

int VdbFile::channels(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->channels[*at] : 0;
}

std::string VdbFile::grid_class(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->classes[*at] : "";
}

const std::map<std::string, std::string>& VdbFile::metadata() const { return impl_->metadata; }

const std::string& VdbFile::z_up() const { return impl_->z_up; }

std::vector<GridInfo> VdbFile::info(bool values) const {
  vdb::Archive archive(*impl_->file);
  std::vector<GridInfo> rows;
  for (const vdb::GridEntry& entry : archive.entries()) {
    rows.push_back(vdb::grid_info(archive, entry, values));
  }
  return rows;
}

std::string VdbFile::default_grid() const {
  const std::vector<std::string>& names = impl_->names;
  if (std::find(impl_->base_names.begin(), impl_->base_names.end(), "density") !=
      impl_->base_names.end()) {
    return "density";
  }
  if (names.size() == 1) return names.front();  // if it cannot be rendered, reading it says why
  const auto& channels = impl_->channels;
  const auto scalars = std::count(channels.begin(), channels.end(), 1);
  const int wanted = scalars > 0 ? 1 : 3;
  if (std::count(channels.begin(), channels.end(), wanted) == 1) {
    const auto only = std::find(channels.begin(), channels.end(), wanted);
    return names[static_cast<std::size_t>(only - channels.begin())];
  }
  std::string message = impl_->file->path() +
                        ": has neither a grid 'density' nor exactly one scalar grid; choose one"
                        " with --grid:";
  for (std::size_t i = 0; i < names.size(); ++i) {
    message += " '" + names[i] + "'" + (channels[i] == 3 ? " (vec3)" : "") +
               (channels[i] == 0 ? " (unreadable)" : "");
  }
  if (names.empty()) message = impl_->file->path() + ": holds no grid";
  throw Error(ExitCode::input, message);
}

Field VdbFile::read(const std::string& grid, const ReadOptions& options) const {
  vdb::Archive archive(*impl_->file, impl_->progress);
  const vdb::GridEntry& entry = archive.find(grid);
  openvdb::GridBase::Ptr values = impl_->last.get(entry.name, options.role);
  std::optional<Field> stored;
  if (!values) stored = vdb::stored_field(archive, entry, impl_->file, options);
  if (!values && !stored) values = archive.read(entry);
  Field field =
      stored ? std::move(*stored)
             : vdb::field_from_grid(values, entry.name, archive.subject(entry.name), options);
  if (!stored) impl_->last.set(values, field, options.role);
  if (entry.name != grid && !grid.empty()) {
    const auto same = std::count(impl_->base_names.begin(), impl_->base_names.end(), grid);
    field.notices.insert(field.notices.begin(), "grid '" + grid + "': " + std::to_string(same) +
                                                    " grids have this name; took '" + entry.name +
                                                    "'");
  }
  return field;
}

std::string openvdb_version() { return openvdb::getLibraryVersionString(); }

}  // namespace psivox
