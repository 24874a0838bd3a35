#include <openvdb/openvdb.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "field_reader.h"
#include "file_blocks.h"
#include "guarded_reader.h"
#include "in_place_reader.h"
#include "psivox/error.h"
#include "psivox/vdb.h"

namespace psivox {

struct VdbFile::Impl {
  Impl(const std::filesystem::path& path, Progress progress)
      : file(std::make_shared<vdb::FileBlocks>(path)) {
    if (vdb::reads_guarded())
      reader = std::make_unique<vdb::GuardedReader>(file, std::move(progress));
    else
      reader = std::make_unique<vdb::InPlaceReader>(file, std::move(progress));
    facts = reader->facts();
  }
  explicit Impl(std::unique_ptr<vdb::Reader> given) : reader(std::move(given)) {
    facts = reader->facts();
  }

  std::string path() const { return file ? file->path() : "grids in memory"; }

  std::shared_ptr<vdb::FileBlocks> file;  ///< shared with the readers of fields; null: no file
  std::unique_ptr<vdb::Reader> reader;
  vdb::FileFacts facts;

  std::optional<std::size_t> place(const std::string& grid) const;  ///< in the lists of facts
};

VdbFile::VdbFile(const std::filesystem::path& path, Progress progress)
    : impl_(std::make_unique<Impl>(path, std::move(progress))) {}

VdbFile::VdbFile(std::shared_ptr<const Field> grid)
    : impl_(std::make_unique<Impl>(std::make_unique<vdb::FieldReader>(std::move(grid)))) {}

VdbFile::VdbFile(std::vector<NamedGrid> grids)
    : impl_(std::make_unique<Impl>(std::make_unique<vdb::GatheredReader>(std::move(grids)))) {}

VdbFile::~VdbFile() = default;

const std::vector<std::string>& VdbFile::names() const { return impl_->facts.names; }

std::optional<std::size_t> VdbFile::Impl::place(const std::string& grid) const {
  for (const auto* some : {&facts.names, &facts.base_names}) {
    const auto found = std::find(some->begin(), some->end(), grid);
    if (found != some->end()) return static_cast<std::size_t>(found - some->begin());
  }
  return {};
}

int VdbFile::channels(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->facts.channels[*at] : 0;
}

std::string VdbFile::grid_class(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->facts.classes[*at] : "";
}

const std::map<std::string, std::string>& VdbFile::metadata() const {
  return impl_->facts.metadata;
}

const std::string& VdbFile::z_up() const { return impl_->facts.z_up; }

std::vector<GridInfo> VdbFile::info(bool values) const { return impl_->reader->info(values); }

std::string VdbFile::default_grid() const {
  const std::vector<std::string>& names = impl_->facts.names;
  if (std::find(impl_->facts.base_names.begin(), impl_->facts.base_names.end(), "density") !=
      impl_->facts.base_names.end()) {
    return "density";
  }
  if (names.size() == 1) return names.front();  // if it cannot be rendered, reading it says why
  const auto& channels = impl_->facts.channels;
  const auto scalars = std::count(channels.begin(), channels.end(), 1);
  const int wanted = scalars > 0 ? 1 : 3;
  if (std::count(channels.begin(), channels.end(), wanted) == 1) {
    const auto only = std::find(channels.begin(), channels.end(), wanted);
    return names[static_cast<std::size_t>(only - channels.begin())];
  }
  std::string message = impl_->path() +
                        ": has neither a grid 'density' nor exactly one scalar grid; choose one"
                        " with --grid:";
  for (std::size_t i = 0; i < names.size(); ++i) {
    message += " '" + names[i] + "'" + (channels[i] == 3 ? " (vec3)" : "") +
               (channels[i] == 0 ? " (unreadable)" : "");
  }
  if (names.empty()) message = impl_->path() + ": holds no grid";
  throw Error(ExitCode::input, message);
}

Field VdbFile::read(const std::string& grid, const ReadOptions& options) const {
  return impl_->reader->read(grid, options);
}

std::string openvdb_version() { return openvdb::getLibraryVersionString(); }

}  // namespace psivox
