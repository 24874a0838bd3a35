#include "nano_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "grid_types.h"

namespace psivox::vdb {

NanoGrid::NanoGrid(NanoFile& file, const GridEntry& entry, bool marked)
    : FileGrid(file, entry, marked || is_mask(entry.descriptor.gridType())) {
  file.guarded(entry, [&] {
    const std::uint32_t type = file.stored(entry).type, grid_class = file.stored(entry).grid_class;
    NanoBytes bytes;
    std::tie(memory_, bytes) = file.unpacked(entry);
    openvdb::GridBase::Ptr head = nano_head(bytes, type, grid_class);
    head->setName(entry.descriptor.gridName());
    if (const NanoType stored = nano_type(type, grid_class); stored.quantised)
      head->insertMeta("nanovdb_type", openvdb::StringMetadata(stored.name));
    tree_ = nano_tree(bytes, type, grid_class);
    begin(std::move(head), /*masks=*/false);
  });
}

Topology NanoGrid::read_topology(const TopologyWish& wish) { return tree_->topology(*head_, wish); }

void NanoGrid::read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) {
  const std::size_t count = topology_.leaves.size();
  std::size_t end = enough ? 1 : count;
  for (std::size_t first = 0; first < count; first = end, end = 2 * first) {
    end = std::min(end, count);
    tbb::parallel_for(first, end, [&](std::size_t n) { tree_->decode(n, fill_, take); });
    if (enough && enough()) return;
  }
}

}  // namespace psivox::vdb
