#include "grid_content.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "grid_types.h"
#include "leaf_decoder.h"
#include "topology.h"
#include "tree_parts.h"

namespace psivox::vdb {
namespace {

/// NaN counts as 0.
bool is_value(float value) { return value < 0 || value > 0; }

bool has_value(const std::vector<TilePart>& tiles) {
  return std::ranges::any_of(tiles, [](const TilePart& part) {
    const glm::vec3& value = part.tile.value;
    return part.active && (is_value(value.x) || is_value(value.y) || is_value(value.z));
  });
}

bool has_value(const float* values, const LeafMask& active, int channels) {
  for (auto on = active.beginOn(); on; ++on)
    if (std::any_of(values + on.pos() * unsigned(channels),
                    values + (on.pos() + 1) * unsigned(channels), is_value))
      return true;
  return false;
}

/// Of leaves whose values the stream is at. Batches grow, for most grids have a value in their
/// first leaf.
bool has_value(const LeafDecoder& decoder, std::size_t leaves, std::istream& stream) {
  constexpr std::size_t most = 2048;
  const std::size_t floats = kLeafVoxels * std::size_t(decoder.channels());
  std::vector<LeafPlace> places;
  std::vector<float> values;
  std::vector<LeafMask> active;
  for (std::size_t first = 0, wanted = 1; first < leaves; first += places.size()) {
    places.clear();
    while (places.size() < std::min(wanted, leaves - first)) {
      const std::int64_t begin = stream.tellg();
      decoder.skip(stream);
      places.push_back({begin, stream.tellg()});
    }
    values.resize(places.size() * floats);
    active.resize(places.size());
    decoder.decode(places, /*in_runs=*/true, values.data(), active.data());
    for (std::size_t n = 0; n < places.size(); ++n)
      if (has_value(values.data() + n * floats, active[n], decoder.channels())) return true;
    wanted = std::min(2 * wanted, most);
  }
  return false;
}

/// Of a grid that is read whole.
GridContent content_of_whole(const openvdb::GridBase::Ptr& grid) {
  const TreeParts parts = parts_of(grid);
  bool found = has_value(parts.tiles);
  for (std::size_t n = 0; n < parts.leaves.size() && !found; ++n)
    found = has_value(parts.leaves[n], *parts.active[n], parts.channels);
  return content_of(grid->activeVoxelCount(), found);
}

}  // namespace

GridContent content_of(std::uint64_t active_voxels, bool has_value) {
  return {active_voxels, has_value            ? ""
                         : active_voxels == 0 ? "has no active voxel"
                                              : "is 0 everywhere"};
}

GridContent content_of(Archive& archive, const GridEntry& entry,
                       const std::shared_ptr<FileBlocks>& file) {
  const std::string& type = entry.descriptor.gridType();
  const openvdb::GridBase::Ptr grid = is_points(type) ? nullptr : archive.begin_tree(entry);
  if (!grid) return content_of_whole(archive.read(entry));
  GridContent content;
  archive.guarded(entry, [&] {
    const Topology topology = read_topology(*grid, archive.stream());
    const std::uint64_t voxels = topology.summary.active_voxels;
    const LeafDecoder decoder(file, grid, openvdb::io::StreamMetadata(archive.stream()));
    const auto some = [&] {
      return has_value(topology.tiles) ||
             has_value(decoder, topology.leaves.size(), archive.stream());
    };
    content = content_of(voxels, voxels > 0 && (is_mask(type) || some()));
  });
  return content;
}

}  // namespace psivox::vdb
