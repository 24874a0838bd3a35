#include "grid_file.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <ios>
#include <new>
#include <set>
#include <stdexcept>
#include <utility>

namespace psivox::vdb {
namespace {

/// Programs whose Z axis is up, as the metadata `creator` names them, in lower case.
constexpr std::array<std::pair<const char*, const char*>, 4> z_up_programs{{
    {"blender", "Blender"},
    {"3ds max", "3ds Max"},
    {"3dsmax", "3ds Max"},
    {"unreal", "Unreal Engine"},
}};

/// Metadata that only the caches of Blender's fluids have.
constexpr const char* blender_grid_metadata = "file_base_resolution";

/// Names of grids that only Blender's smoke and fire have, beside `density`.
constexpr std::array<const char*, 3> blender_grids{"shadow", "react", "density_noise"};

/// `written by Blender`, if the metadata `creator` name such a program; else empty.
std::string z_up_creator(const MetadataText& metadata) {
  const auto creator = metadata.find("creator");
  if (creator != metadata.end())
    for (const auto& [name, program] : z_up_programs)
      if (lower_case(creator->second).find(name) != std::string::npos)
        return std::string("written by ") + program;
  return "";
}

/// Tiles of the root that may be added: 28 MB of them.
constexpr std::uint64_t most_root_tiles = 1 << 20;

}  // namespace

std::string explain(const std::exception& e) {
  if (dynamic_cast<const std::ios_base::failure*>(&e)) return "the file ends too early";
  if (dynamic_cast<const std::bad_alloc*>(&e)) return "it asks for more memory than there is";
  std::string text = e.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return printable(text);
}

GridFile::GridFile(std::shared_ptr<FileBlocks> file, Progress progress)
    : file_(std::move(file)), buffer_(*file_, std::move(progress)) {
  stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
}

/// The names are OpenVDB's, `density` or `density[1]`, with control characters escaped. A number
/// stands in the file behind a separator. OpenVDB writes grids without a name as `[0]`, `[1]`;
/// where another program repeats a name without numbers, they are numbered here.
void GridFile::list_entries(const char* format, const std::function<void()>& read) {
  or_input_error(read, [&](const std::exception& e) {
    return subject(path()) + "is a damaged " + format + " file: " + explain(e);
  });
  std::map<std::string, int> uses;
  for (GridEntry& entry : entries_) {
    constexpr char separator = '\x1e';
    const std::string& unique = entry.unique_name;
    const std::size_t end = std::min(unique.find(separator), unique.size());
    entry.base_name = unique.substr(0, end);
    entry.name = printable(
        end == unique.size() ? unique : entry.base_name + "[" + unique.substr(end + 1) + "]");
    ++uses[entry.name];
  }
  std::map<std::string, int> next;
  for (GridEntry& entry : entries_) {
    const std::string name = entry.name;
    if (name.empty() || uses[name] > 1) entry.name += "[" + std::to_string(next[name]++) + "]";
  }
}

void GridFile::guarded(const GridEntry& entry, const std::function<void()>& work) const {
  if (!entry.problem.empty())
    throw Error(ExitCode::input, subject(path(), entry.name) + entry.problem);
  or_input_error(work, [&](const std::exception& e) {
    return subject(path(), entry.name) + "cannot be read: " + explain(e);
  });
}

std::unique_ptr<FileGrid> GridFile::open(const GridEntry& entry, bool marked) {
  std::unique_ptr<FileGrid> grid;
  guarded(entry, [&] { grid = opened(entry, marked || is_mask(entry.type)); });
  return grid;
}

void FileGrid::begin(GridHead head) {
  head_ = std::move(head);
  topology_ = read_topology();
  if (!marked_) return;
  head_.type = grid_type_of("float");
  head_.grid_class = unknown_class;
  std::erase_if(topology_.tiles, [](const TilePart& tile) { return !tile.active; });
  for (TilePart& tile : topology_.tiles) tile.value = {1, 0, 0};
  topology_.summary.channels = 1;
  topology_.summary.background = glm::dvec3(0);
}

void FileGrid::set_background(double value) {
  if (!can_be(value))
    throw std::runtime_error(
        formatted("has no value %g, which --background-value asks for", value));
  fill_ = value;
  if (value != 0) {  // tiles of 0 are left out
    guarded([&] { topology_ = read_topology(); });
    if (summary().active_voxels > 0) fill_root(value);
  }
  topology_.summary.background = glm::dvec3(0);
}

/// Adds tiles to the root where it has neither a tile nor a node.
void FileGrid::fill_root(double value) {
  constexpr int width = 4096, shift = 12;
  // one voxel around the active ones belongs to the domain
  const Box box = common(summary().active_box, everywhere);
  const Box nodes{(box.min - 1) >> shift, (box.max + 1) >> shift};
  if (count_of(nodes) > most_root_tiles)
    throw std::runtime_error(
        "is too wide to be filled with --background-value; only 0 needs no memory");
  std::vector<TilePart>& tiles = topology_.tiles;
  // a node has leaves or tiles everywhere
  std::set<glm::ivec3, decltype(&comes_before)> taken(comes_before);
  for (const glm::ivec3& leaf : topology_.leaves) taken.insert(leaf >> shift);
  for (const TilePart& tile : tiles) taken.insert(tile.origin >> shift);
  for_points(nodes, [&](const glm::ivec3& node) {
    if (!taken.contains(node)) tiles.push_back({node * width, width, glm::dvec3(value), false});
  });
  std::ranges::stable_sort(tiles, [&](const TilePart& a, const TilePart& b) {
    if (a.width != b.width) return a.width > b.width;
    return a.width == width && comes_before(a.origin, b.origin);
  });
}

void FileGrid::each_leaf(const TakeLeaf& take, const std::function<bool()>& enough) {
  guarded([&] {
    if (!marked_) return read_leaves(take, enough);
    const std::vector<LeafMask>& masks = topology_.masks;
    tbb::parallel_for(std::size_t{0}, masks.size(), [&](std::size_t n) {
      take(n, MadeLeaf(masks[n], each_voxel([&](std::size_t i) { return masks[n].is_on(i); })));
    });
  });
}

void FileGrid::some_leaves(std::span<const std::uint32_t> numbers, const TakeLeaf& take) {
  guarded([&] {
    for (const std::uint32_t number : numbers)
      if (number >= topology_.leaves.size()) throw std::runtime_error("there is no such leaf");
    read_some(numbers, take);
  });
}

std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids) {
  if (file.contains("creator")) {
    if (std::string program = z_up_creator(file); !program.empty()) return program;
  } else {
    for (const MetadataText& grid : grids)
      if (std::string program = z_up_creator(grid); !program.empty()) return program;
  }
  for (const MetadataText& grid : grids)
    if (grid.contains(blender_grid_metadata)) return "a cache of Blender's fluids";
  if (std::ranges::find(names, "density") == names.end()) return "";
  for (const char* name : blender_grids)
    if (std::ranges::find(names, name) != names.end())
      return std::string("a grid '") + name + "', as Blender names it";
  return "";
}

}  // namespace psivox::vdb
