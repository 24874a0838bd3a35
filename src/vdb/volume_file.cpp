#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/file_blocks.h"
#include "base/text.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "reader.h"
#include "scan/scan.h"
#include "vdb/grid_head.h"
#include "vdb/grid_names.h"
#include "vdb/grids_module.h"
#include "vdb/joined_vectors.h"

namespace psivox {
namespace vdb {

/// A file's reader. Frames of the file share it while somebody holds it: one after another they are
/// unpacked once.
struct SharedReader {
  explicit SharedReader(const std::filesystem::path& path)
      : file(std::make_shared<FileBlocks>(path)) {
    std::shared_ptr<FileBlocks> data;
    if (const std::string beside = scan::data_path(*file); !beside.empty())
      data = std::make_shared<FileBlocks>(std::filesystem::path(beside));
    const Progress report = [this](double done) {
      if (progress) progress(done);
    };
    reader = open_guarded_reader(file, data, report);
    if (!reader) reader = open_reader(file, data, report);
  }

  std::shared_ptr<FileBlocks> file;
  std::mutex mutex{};   ///< of what a frame reads
  Progress progress{};  ///< of who reads now
  std::unique_ptr<Reader> reader{};
};

/// While a frame reads, its progress is the reader's.
struct Turn {
  Turn(SharedReader& reader, Progress& progress)
      : lock(reader.mutex), shared(reader), own(progress) {
    std::swap(shared.progress, own);
  }
  ~Turn() { std::swap(shared.progress, own); }

  std::lock_guard<std::mutex> lock;
  SharedReader& shared;
  Progress& own;
};

/// A file's reader; that of a file that is open already for one of its frames. Throws Error(input).
static std::shared_ptr<SharedReader> reader_of(const FrameOfFile& one, const Progress& progress) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<SharedReader>> open;  // by path and stamp
  const std::string key = one.file.string() + "\n" + file_stamp(one.file);
  if (!one.frame.empty()) {
    const std::lock_guard lock(mutex);
    if (const auto known = open.find(key); known != open.end())
      if (auto shared = known->second.lock()) return shared;
  }
  auto shared = std::make_shared<SharedReader>(one.file);
  if (one.frame.empty()) shared->progress = progress;
  const std::lock_guard lock(mutex);
  std::erase_if(open, [](const auto& item) { return item.second.expired(); });
  open[key] = shared;
  return shared;
}

}  // namespace vdb

struct VolumeFile::Impl {
  Impl(const FrameOfFile& one, Progress own_progress)
      : shared(vdb::reader_of(one, own_progress)),
        file(shared->file),
        frame(one.frame),
        progress(std::move(own_progress)),
        reader(shared, shared->reader.get()) {
    take_facts();
  }
  explicit Impl(std::unique_ptr<vdb::Reader> given) : reader(std::move(given)) { take_facts(); }

  std::string path() const { return file ? file->path() : "grids in memory"; }

  Field read(const std::string& grid, const ReadOptions& options) {
    if (frame.empty()) return with_leaves(grid, options, reader->read(grid, options));
    const vdb::Turn turn{*shared, progress};
    return reader->read(grid, options);
  }

  /// A field whose values may have stayed in the file, with what reads them.
  Field with_leaves(const std::string& grid, const ReadOptions& options, Field field) const {
    if (field.reader || !vdb::stays_in_file(field)) return field;
    field.reader = [from = reader, wish = vdb::LeavesWish{grid, options}](
                       const FieldHead& head, std::span<const std::uint32_t> numbers,
                       float* values) {
      vdb::LeavesWish some = wish;
      some.largest = head.replaced.positive_infinite > 0 ? head.replaced.largest : HUGE_VALF;
      some.numbers.assign(numbers.begin(), numbers.end());
      std::ranges::copy(from->leaves(some), values);
    };
    return field;
  }

  std::shared_ptr<vdb::SharedReader> shared;  ///< null: no file
  std::shared_ptr<FileBlocks> file;           ///< shared with the readers of fields; null: no file
  std::string frame;                          ///< to which the file is narrowed, see FrameOfFile
  Progress progress;                          ///< of a frame
  std::shared_ptr<vdb::Reader> reader;
  vdb::FileFacts facts;
  std::vector<std::string> names;
  std::map<std::string, vdb::Components> vectors;  ///< that grids are the components of
  std::mutex mutex;                                ///< of what follows
  std::map<std::string, GridContent> contents;     ///< of grids that were asked for

  void take_facts() {
    facts = reader->facts();
    if (!frame.empty()) take_frame();
    vectors = vdb::vectors_of(facts.grids);
    for (const vdb::GridFacts& grid : facts.grids)
      if (!is_component(grid)) names.push_back(grid.name);
    for (const auto& [vector, components] : vectors) {
      names.push_back(vector);
      facts.grids.push_back({vector, vector, 3, "vec3s", std::string(vdb::unknown_class)});
    }
  }
  /// Whether the grid is one of a vector's three: drawn only if it is named.
  bool is_component(const vdb::GridFacts& grid) const {
    return std::ranges::any_of(vectors, [&](const auto& vector) {
      return std::ranges::count(vector.second, grid.name) > 0;
    });
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

/// Words for scans, and then for what burns or is hot, after density_words; the best first.
constexpr std::array further_words{"image", "temperature", "temp", "heat", "flame", "fire"};
/// Ranks of grids whose names say none of these words begin here.
constexpr std::size_t unknown = 2 * (density_words.size() + further_words.size());
constexpr std::size_t of_solver = unknown + 7;

/// Names of the surface among a liquid's level sets, whose others are its obstacles.
constexpr std::array surface_names{"phi", "surface", "sdf", "distance"};

/// Place of a grid in the order in which default_grid prefers grids, which others may share.
std::size_t rank_of(const vdb::GridFacts& grid) {
  std::size_t rank = 0;
  for (const auto& words :
       {std::span<const char* const>(density_words), std::span<const char* const>(further_words)})
    for (const char* word : words) {
      if (const Saying how = saying(grid.base_name, word); how != Saying::not_at_all)
        return rank + (how == Saying::whole ? 0 : 1);
      rank += 2;
    }
  const std::string name = lower_case(grid.base_name);
  const bool surface = std::ranges::count(surface_names, name) > 0;
  if (is_of_solver(name) && !(surface && grid.grid_class == "level set")) return of_solver;
  if (grid.value_type == "mask") return unknown + 6;
  if (grid.channels == 3) return unknown + 5;
  if (grid.value_type == "points") return unknown + 4;
  if (grid.grid_class == "fog volume") return unknown;
  if (grid.grid_class != "level set") return unknown + 3;
  return surface ? unknown + 1 : unknown + 2;
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

std::shared_ptr<const VolumeFile> file_of_frame(const std::string& path) {
  const FrameOfFile one = frame_of_file(path);
  return one.frame.empty() ? nullptr : std::make_shared<const VolumeFile>(one.file);
}

VolumeFile::VolumeFile(const std::filesystem::path& path, Progress progress)
    : impl_(std::make_unique<Impl>(frame_of_file(path.string()), std::move(progress))) {}

VolumeFile::VolumeFile(std::shared_ptr<const Field> grid)
    : impl_(std::make_unique<Impl>(
          vdb::field_reader({.facts = {.grids = {{grid->name, grid->name, grid->channels,
                                                  grid->value_type, "unknown"}}},
                             .make = [grid](std::size_t) { return grid; }}))) {}

VolumeFile::VolumeFile(std::vector<NamedGrid> grids)
    : impl_(std::make_unique<Impl>(vdb::gathered_reader(std::move(grids)))) {}

VolumeFile::~VolumeFile() = default;

const std::vector<std::string>& VolumeFile::names() const { return impl_->names; }

int VolumeFile::channels(const std::string& grid) const { return impl_->known(grid).channels; }

std::string VolumeFile::value_type(const std::string& grid) const {
  return impl_->known(grid).value_type;
}

std::string VolumeFile::grid_class(const std::string& grid) const {
  return impl_->known(grid).grid_class;
}

const std::map<std::string, std::string>& VolumeFile::metadata() const {
  return impl_->facts.metadata;
}

const std::string& VolumeFile::z_up() const { return impl_->facts.z_up; }

void VolumeFile::check_whole() const {
  const int lost = impl_->facts.lost;
  if (lost == 0) return;
  const bool some = std::ranges::any_of(
      impl_->facts.grids, [](const vdb::GridFacts& grid) { return grid.channels > 0; });
  throw Error(ExitCode::input, impl_->path() +
                                   formatted(": is cut short: %d grid%s not whole", lost,
                                             lost == 1 ? " is" : "s are") +
                                   (some ? "; --look smoke draws what is there" : ""));
}

bool VolumeFile::known_to_be_empty(const std::string& grid) const {
  const GridPlace in_header = place(grid);
  if (in_header.known && in_header.voxels == 0) return true;
  const std::lock_guard lock(impl_->mutex);
  const auto known = impl_->contents.find(grid);
  return known != impl_->contents.end() && !known->second.nothing.empty();
}

GridPlace VolumeFile::place(const std::string& grid) const {
  GridPlace place = impl_->known(grid).place;
  constexpr double most = 1e75;  // as of a transform
  const auto possible = [](const glm::dvec3& v) {
    return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
  };
  place.known &= possible(place.world_min) && possible(place.world_max);
  if (!(place.voxel_size > 0 && place.voxel_size <= most)) place.voxel_size = 0;
  return place;
}

std::vector<GridInfo> VolumeFile::info(bool values) const {
  // a grid may end the guarded process, and several that do may take all the time of the file
  constexpr int most_ends = 2;
  int ends = 0;
  std::vector<GridInfo> rows;
  for (const vdb::GridFacts& grid : impl_->facts.grids) {
    if (impl_->vectors.contains(grid.name)) continue;
    GridInfo row;
    row.channels = grid.channels;
    row.problem = "was not read, because reading other grids failed";
    try {
      if (ends < most_ends) row = impl_->reader->info(grid.name + impl_->frame, values);
    } catch (const Error& error) {
      if (error.code() != ExitCode::input) throw;
      row.problem = without_subject(error.what(), impl_->path(), grid.name);
      ++ends;
    }
    row.name = grid.name;
    rows.push_back(std::move(row));
  }
  return rows;
}

GridContent VolumeFile::content(const std::string& grid) const {
  if (const auto vector = impl_->vectors.find(grid); vector != impl_->vectors.end()) {
    GridContent all = content(vector->second[0]);
    for (const std::string& component : vector->second)
      if (const GridContent one = content(component); one.nothing.empty()) all = one;
    return all;
  }
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

std::string VolumeFile::default_grid(bool empty) const {
  const std::vector<vdb::GridFacts>& all = impl_->facts.grids;
  if (all.empty()) throw Error(ExitCode::input, impl_->path() + ": holds no grid");
  if (all.size() == 1) return all.front().name;
  std::map<std::size_t, std::vector<const vdb::GridFacts*>> groups;
  for (const vdb::GridFacts& grid : all)
    if (grid.channels > 0 && !impl_->is_component(grid)) groups[rank_of(grid)].push_back(&grid);
  // Beside a density, even one that is still empty, a solver's own grids are none to draw.
  // Blender's caches hold many of them.
  const bool has_density = !groups.empty() && groups.begin()->first < 2 * density_words.size();
  const std::size_t drawn = !has_density                            ? of_solver + 1
                            : z_up().find("Blender") != z_up().npos ? unknown
                                                                    : of_solver;
  bool rests = false;
  for (const auto& [group, grids] : groups) {
    if (group >= drawn) {
      rests = true;
      break;
    }
    const vdb::GridFacts* best = nullptr;
    std::uint64_t most = 0;
    for (const vdb::GridFacts* grid : grids) {
      const GridContent held = content(grid->name);
      if (!held.nothing.empty() || held.active_voxels <= most) continue;
      best = grid;
      most = held.active_voxels;
      if (group < unknown && group % 2 == 0) break;  // of a known name it is the first
    }
    if (best) return impl_->short_name(*best);
  }
  if ((empty || rests) && !groups.empty())
    return impl_->short_name(*groups.begin()->second.front());
  std::string message = impl_->path() + ": has nothing to draw";
  for (const std::string& name : names())
    message +=
        (&name == &names().front() ? ": grid '" : "; grid '") + name + "' " + content(name).nothing;
  throw Error(ExitCode::input, message);
}

Field VolumeFile::read(const std::string& grid, const ReadOptions& options) const {
  if (const auto vector = impl_->vectors.find(grid); vector != impl_->vectors.end()) {
    ReadOptions whole = options;
    whole.empty = true;
    whole.memory = 0;
    whole.in_file = false;
    whole.percentiles.clear();
    if (!options.active) whole.role = GridRole::data;
    std::array<Field, 3> components;
    for (std::size_t c = 0; c < 3; ++c) components[c] = read(vector->second[c], whole);
    return options.active ? components[0] : vdb::joined_vectors(grid, components);
  }
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
  Field field = impl_->read(in_reader, options);
  if (!impl_->frame.empty()) {
    field.name = grid;
  } else if (in_reader != grid && !grid.empty()) {
    const auto same = std::ranges::count(impl_->facts.grids, grid, &vdb::GridFacts::base_name);
    const std::string count = std::to_string(same), last = std::to_string(same - 1);
    field.notices.insert(
        field.notices.begin(),
        metadata().contains("frames")
            ? "the first of " + count + " frames; --frames 0-" + last + " draws all of them"
            : "grid '" + grid + "': " + count + " grids have this name; took '" + in_reader + "'");
  }
  return field;
}

std::string openvdb_version() { return vdb::grids_module().version(); }

}  // namespace psivox
