#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/file_blocks.h"
#include "base/text.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "reader.h"
#include "scan/scan.h"
#include "trees.h"

namespace psivox {

struct VdbFile::Impl {
  Impl(const FrameOfFile& one, Progress progress)
      : file(std::make_shared<FileBlocks>(one.file)), frame(one.frame) {
    std::shared_ptr<FileBlocks> data;
    if (const std::string beside = scan::data_path(*file); !beside.empty())
      data = std::make_shared<FileBlocks>(beside);
    reader = vdb::open_guarded_reader(file, data, progress);
    if (!reader) reader = vdb::open_reader(file, data, std::move(progress));
    take_facts();
  }
  explicit Impl(std::unique_ptr<vdb::Reader> given) : reader(std::move(given)) { take_facts(); }

  std::string path() const { return file ? file->path() : "grids in memory"; }

  std::shared_ptr<FileBlocks> file;  ///< shared with the readers of fields; null: no file
  std::string frame;                 ///< to which the file is narrowed, see FrameOfFile
  std::unique_ptr<vdb::Reader> reader;
  vdb::FileFacts facts;
  std::vector<std::string> names;
  std::mutex mutex;                             ///< of what follows
  std::map<std::string, GridContent> contents;  ///< of grids that were asked for

  void take_facts() {
    facts = reader->facts();
    if (!frame.empty()) take_frame();
    for (const vdb::GridFacts& grid : facts.grids) names.push_back(grid.name);
  }
  /// Leaves the one grid of the frame, under its plain name.
  void take_frame() {
    const std::size_t count = facts.grids.size();
    std::erase_if(facts.grids,
                  [&](const vdb::GridFacts& grid) { return grid.name != grid.base_name + frame; });
    if (facts.grids.size() != 1)
      throw Error(ExitCode::input, path() + ": has no frame " + frame + " among its " +
                                       std::to_string(count) + (count == 1 ? " grid" : " grids"));
    facts.metadata.erase("frames");
    facts.grids.front().name = facts.grids.front().base_name;
  }
  /// A grid by one of its names, the numbered one first; null if there is none.
  const vdb::GridFacts* find(const std::string& grid) const {
    for (const auto name : {&vdb::GridFacts::name, &vdb::GridFacts::base_name}) {
      const auto found = std::ranges::find(facts.grids, grid, name);
      if (found != facts.grids.end()) return &*found;
    }
    return nullptr;
  }
  vdb::GridFacts known(const std::string& grid) const {
    const vdb::GridFacts* found = find(grid);
    return found ? *found : vdb::GridFacts();
  }
  /// The reader's name of a grid by one of its names. Throws Error(input), which lists the names.
  std::string in_reader(const std::string& grid) const {
    if (const vdb::GridFacts* known = find(grid)) return known->name + frame;
    constexpr std::size_t most_listed = 20;  // a scan may have any number of frames
    std::vector<std::string> near = nearest_first(grid, names);
    if (near.size() > most_listed) near.resize(most_listed);
    for (std::string& name : near) name = in_quotes(name);
    const std::string listed = near.empty() ? "none" : joined(near, " ");
    throw Error(ExitCode::input, (file ? file->path() + ": has no grid " : "there is no grid ") +
                                     in_quotes(grid) + (file ? "; it has " : "; there is ") +
                                     listed + (names.size() > most_listed ? " ..." : ""));
  }
  /// The name without its number, if that means the same grid.
  std::string short_name(const vdb::GridFacts& grid) const {
    return !grid.base_name.empty() && find(grid.base_name) == &grid ? grid.base_name : grid.name;
  }
};

namespace {

/// Names of densities, of scans, and then of what burns or is hot, the best first.
constexpr std::array known_names{"density",     "fog",  "smoke", "cloud", "clouds", "soot", "image",
                                 "temperature", "temp", "heat",  "flame", "flames", "fire"};

/// Names of the surface among a liquid's level sets, whose others are its obstacles.
constexpr std::array surface_names{"phi", "surface", "sdf", "distance"};

/// Place of a grid in the order in which default_grid prefers grids, which others may share.
std::size_t rank_of(const vdb::GridFacts& grid) {
  const std::string name = lower_case(grid.base_name);
  const auto known = std::ranges::find(known_names, name);
  const std::size_t unknown = known_names.size();
  if (known != known_names.end()) return std::size_t(known - known_names.begin());
  if (grid.value_type == "mask") return unknown + 6;
  if (grid.channels == 3) return unknown + 5;
  if (grid.value_type == "points") return unknown + 4;
  if (grid.grid_class == "fog volume") return unknown;
  if (grid.grid_class != "level set") return unknown + 3;
  return std::ranges::count(surface_names, name) ? unknown + 1 : unknown + 2;
}

}  // namespace

FrameOfFile frame_of_file(const std::string& path) {
  const std::size_t open = path.rfind('[');
  std::error_code unknown;
  if (open == std::string::npos || !path.ends_with(']') || std::filesystem::exists(path, unknown))
    return {path, ""};
  const std::string_view number = std::string_view(path).substr(open + 1, path.size() - open - 2);
  if (number.empty() || number.find_first_not_of("0123456789") != number.npos) return {path, ""};
  return {path.substr(0, open), path.substr(open)};
}

VdbFile::VdbFile(const std::filesystem::path& path, Progress progress)
    : impl_(std::make_unique<Impl>(frame_of_file(path.string()), std::move(progress))) {}

VdbFile::VdbFile(std::shared_ptr<const Field> grid)
    : impl_(std::make_unique<Impl>(
          vdb::field_reader({.facts = {.grids = {{grid->name, grid->name, grid->channels,
                                                  grid->value_type, "unknown"}}},
                             .make = [grid](std::size_t) { return grid; }}))) {}

VdbFile::VdbFile(std::vector<NamedGrid> grids)
    : impl_(std::make_unique<Impl>(vdb::gathered_reader(std::move(grids)))) {}

VdbFile::~VdbFile() = default;

const std::vector<std::string>& VdbFile::names() const { return impl_->names; }

int VdbFile::channels(const std::string& grid) const { return impl_->known(grid).channels; }

std::string VdbFile::value_type(const std::string& grid) const {
  return impl_->known(grid).value_type;
}

std::string VdbFile::grid_class(const std::string& grid) const {
  return impl_->known(grid).grid_class;
}

const std::map<std::string, std::string>& VdbFile::metadata() const {
  return impl_->facts.metadata;
}

const std::string& VdbFile::z_up() const { return impl_->facts.z_up; }

void VdbFile::check_whole() const {
  const int lost = impl_->facts.lost;
  if (lost > 0)
    throw Error(ExitCode::input,
                impl_->path() + formatted(": is cut short: %d grid%s not whole; --look smoke draws "
                                          "what is there",
                                          lost, lost == 1 ? " is" : "s are"));
}

std::vector<GridInfo> VdbFile::info(bool values) const {
  if (impl_->frame.empty()) return impl_->reader->info("", values);
  std::vector<GridInfo> one = impl_->reader->info(impl_->in_reader(names().front()), values);
  for (GridInfo& grid : one) grid.name = names().front();
  return one;
}

GridContent VdbFile::content(const std::string& grid) const {
  const std::lock_guard lock(impl_->mutex);
  if (const auto known = impl_->contents.find(grid); known != impl_->contents.end())
    return known->second;
  GridContent content;
  try {
    content = impl_->reader->content(impl_->in_reader(grid));
  } catch (const Error& error) {
    if (error.code() == ExitCode::memory) throw;
    content.nothing = without_subject(error.what(), impl_->path(), grid);
  }
  return impl_->contents[grid] = content;
}

std::string VdbFile::default_grid(bool empty) const {
  const std::vector<vdb::GridFacts>& all = impl_->facts.grids;
  if (all.empty()) throw Error(ExitCode::input, impl_->path() + ": holds no grid");
  if (all.size() == 1) return all.front().name;
  std::map<std::size_t, std::vector<const vdb::GridFacts*>> groups;
  for (const vdb::GridFacts& grid : all)
    if (grid.channels > 0) groups[rank_of(grid)].push_back(&grid);
  for (const auto& [group, grids] : groups) {
    const vdb::GridFacts* best = nullptr;
    std::uint64_t most = 0;
    for (const vdb::GridFacts* grid : grids) {
      const GridContent held = content(grid->name);
      if (!held.nothing.empty() || held.active_voxels <= most) continue;
      best = grid;
      most = held.active_voxels;
      if (group < known_names.size()) break;  // of a known name it is the first
    }
    if (best) return impl_->short_name(*best);
  }
  if (empty && !groups.empty()) return impl_->short_name(*groups.begin()->second.front());
  std::string message = impl_->path() + ": has nothing to draw";
  for (const std::string& name : names())
    message +=
        (&name == &names().front() ? ": grid '" : "; grid '") + name + "' " + content(name).nothing;
  throw Error(ExitCode::input, message);
}

Field VdbFile::read(const std::string& grid, const ReadOptions& options) const {
  if (options.empty && !impl_->find(grid)) {
    check_whole();
    Field nothing;
    nothing.name = grid;
    nothing.active_box = {glm::ivec3(0), glm::ivec3(0)};
    nothing.notices.push_back("grid " + in_quotes(grid) +
                              " is not in the file, and counts as empty");
    return nothing;
  }
  const std::string in_reader = impl_->in_reader(grid);
  Field field = impl_->reader->read(in_reader, options);
  if (!impl_->frame.empty()) {
    field.name = grid;
  } else if (in_reader != grid && !grid.empty()) {
    const auto same = std::ranges::count(impl_->facts.grids, grid, &vdb::GridFacts::base_name);
    field.notices.insert(field.notices.begin(), "grid '" + grid + "': " + std::to_string(same) +
                                                    " grids have this name; took '" + in_reader +
                                                    "'");
  }
  if (impl_->file && !field.reader)
    field.origin = std::make_shared<const FieldOrigin>(
        FieldOrigin{field.storage, [path = impl_->path() + impl_->frame, grid, options] {
                      return VdbFile(path).read(grid, options);
                    }});
  return field;
}

std::string openvdb_version() { return vdb::trees().version(); }

}  // namespace psivox
