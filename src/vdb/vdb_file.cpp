#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "field_reader.h"
#include "file_blocks.h"
#include "file_metadata.h"
#include "guarded_reader.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "reader.h"

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
  std::mutex mutex;                             ///< of what follows
  std::map<std::string, GridContent> contents;  ///< of grids that were asked for

  std::optional<std::size_t> place(const std::string& grid) const;  ///< in the lists of facts
  /// The name without its number, if that means the same grid.
  std::string short_name(std::size_t n) const {
    const std::string& base = facts.base_names[n];
    return !base.empty() && place(base) == n ? base : facts.names[n];
  }
};

namespace {

/// Names of densities, and then of what burns or is hot, the best first.
constexpr std::array known_names{"density",     "fog",  "smoke", "cloud", "clouds", "soot",
                                 "temperature", "temp", "heat",  "flame", "flames", "fire"};

/// Names of the surface among a liquid's level sets, whose others are its obstacles.
constexpr std::array surface_names{"phi", "surface", "sdf", "distance"};

/// Place of a grid in the order in which default_grid prefers grids, which others may share.
std::size_t rank_of(const vdb::FileFacts& facts, std::size_t n) {
  const std::string name = vdb::lower_case(facts.base_names[n]);
  const auto known = std::ranges::find(known_names, name);
  const std::size_t unknown = known_names.size();
  if (known != known_names.end()) return std::size_t(known - known_names.begin());
  if (facts.value_types[n] == "mask") return unknown + 6;
  if (facts.channels[n] == 3) return unknown + 5;
  if (facts.value_types[n] == "points") return unknown + 4;
  if (facts.classes[n] == "fog volume") return unknown;
  if (facts.classes[n] != "level set") return unknown + 3;
  return std::ranges::count(surface_names, name) ? unknown + 1 : unknown + 2;
}

}  // namespace

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

std::string VdbFile::value_type(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->facts.value_types[*at] : "";
}

std::string VdbFile::grid_class(const std::string& grid) const {
  const std::optional<std::size_t> at = impl_->place(grid);
  return at ? impl_->facts.classes[*at] : "";
}

const std::map<std::string, std::string>& VdbFile::metadata() const {
  return impl_->facts.metadata;
}

const std::string& VdbFile::z_up() const { return impl_->facts.z_up; }

std::vector<GridInfo> VdbFile::info(bool values) const { return impl_->reader->info("", values); }

GridContent VdbFile::content(const std::string& grid) const {
  const std::lock_guard lock(impl_->mutex);
  if (const auto known = impl_->contents.find(grid); known != impl_->contents.end())
    return known->second;
  GridContent content;
  try {
    content = impl_->reader->content(grid);
  } catch (const Error& error) {
    if (error.code() == ExitCode::memory) throw;
    content.nothing = vdb::without_subject(error.what(), impl_->path(), grid);
  }
  return impl_->contents[grid] = content;
}

std::string VdbFile::default_grid(bool empty) const {
  const vdb::FileFacts& facts = impl_->facts;
  if (facts.names.empty()) throw Error(ExitCode::input, impl_->path() + ": holds no grid");
  if (facts.names.size() == 1) return facts.names.front();
  std::map<std::size_t, std::vector<std::size_t>> ranks;
  for (std::size_t n = 0; n < facts.names.size(); ++n)
    if (facts.channels[n] > 0) ranks[rank_of(facts, n)].push_back(n);
  for (const auto& [rank, grids] : ranks) {
    std::optional<std::size_t> best;
    std::uint64_t most = 0;
    for (const std::size_t n : grids) {
      const GridContent held = content(facts.names[n]);
      if (!held.nothing.empty() || held.active_voxels <= most) continue;
      best = n;
      // of a known name it is the first
      most = rank < known_names.size() ? ~std::uint64_t{0} : held.active_voxels;
    }
    if (best) return impl_->short_name(*best);
  }
  if (empty && !ranks.empty()) return impl_->short_name(ranks.begin()->second.front());
  std::string message = impl_->path() + ": has nothing to draw";
  for (const std::string& name : facts.names)
    message += (&name == &facts.names.front() ? ": grid '" : "; grid '") + name + "' " +
               content(name).nothing;
  throw Error(ExitCode::input, message);
}

Field VdbFile::read(const std::string& grid, const ReadOptions& options) const {
  return impl_->reader->read(grid, options);
}

std::string openvdb_version() { return openvdb::getLibraryVersionString(); }

}  // namespace psivox
